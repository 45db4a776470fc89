"""Command noise: four axes, in the command's own frame."""

from __future__ import annotations

from itertools import pairwise
from math import pi
from random import Random

import pytest

from hal.sim.control import Controller
from hal.sim.model_files import load_model
from hal.sim.motion import axes_of
from hal.sim.noise import CommandNoise
from hal.vehicle import Velocity
from tests.hal.flying import LONG, only, session_of, take_off, wait
from tests.hal.scenes import world_of
from vencejo.geometry import yaw_quaternion

MODEL = load_model("ardrone2")


def test_each_axis_drifts_for_five_seconds_and_trembles_within_its_bounds() -> None:
    noise = CommandNoise(2.0, Random(1))
    drawn = [noise.next() for _ in range(2000)]
    for values in zip(*drawn, strict=True):
        # Drift of 0.03 and small noise of 0.05, twice as strong.
        assert max(map(abs, values)) <= 0.16 + 1e-12
        drifts = [sum(values[n : n + 200]) / 200 for n in range(0, 2000, 200)]
        assert all(abs(drift) < 0.075 for drift in drifts) and max(map(abs, drifts)) > 0.02
        small = [b - a for a, b in pairwise(values[:200])]
        assert 0.15 < max(map(abs, small)) <= 0.2
    assert CommandNoise(0.0, Random(1)).next() == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("in_heading", "forward", "left"), [(False, 0.2, -0.1), (True, 0.1, 0.2)])
def test_the_noise_is_in_the_commands_own_frame(
    in_heading: bool, forward: float, left: float
) -> None:
    """A vehicle that faces north: its thrust is to lean as the noise says, and it is to turn."""
    controller = Controller(MODEL, 0.0)
    controller.fly_at(0.0, 0.0, 0.0, in_heading)
    controller.noise = (0.1, 0.2, 0.3, 0.4)
    still, north = (0.0, 0.0, 0.0), yaw_quaternion(pi / 2)
    state = (0.0, 0.0, 5.0), north, still, still
    controller.plan(state)
    thrust, roll, pitch, yaw = controller.step(state, axes_of(north))
    about_x, about_y, about_z = MODEL.inertia
    assert pitch / about_y / forward == pytest.approx(-roll / about_x / left)
    assert pitch / forward > 0 and yaw / about_z == pytest.approx(15.0 * 0.4)
    assert thrust > MODEL.weight


def test_noise_turns_a_vehicle_that_holds_its_heading() -> None:
    spread = []
    for factor in (0.0, 1.0):
        with session_of(world_of(), noise=factor) as session:
            take_off(session, 3.0)
            only(session).command(Velocity(), LONG)
            spread.append(max(abs(seen.yaw) for seen in wait(session, 6)))
    still, turned = spread
    assert still < 1e-4 and 1e-3 < turned < 0.05
