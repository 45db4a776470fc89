"""orbit."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors import PlanStart, describe
from behaviors.curves import onto_circle
from behaviors.orbit import Orbit
from behaviors.path import angle_between
from hal.vehicle import Position
from tests.behaviors.flying import Solo
from vencejo.geometry import Point, bearing, distance, horizontal_distance, wrap

INFO = describe(Orbit)


def fly(values: dict[str, Any], solo: Solo | None = None) -> tuple[Solo, list[Position]]:
    solo = solo or Solo(INFO, values)
    told = []
    while solo.outcome is None:
        setpoint = solo.step()
        assert isinstance(setpoint, Position)
        told.append(setpoint)
        assert solo.time < 200
    return solo, told


@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize("middle", [Point(12.0, 3.0, 0.0), Point(1.0, 0.5, 0.0), Point(0, 0, 0)])
def test_it_comes_round_facing_the_point_without_a_jump(middle: Point, clockwise: bool) -> None:
    solo, told = fly({"around": middle, "radius": 4.0, "turns": 1.5, "clockwise": clockwise})
    assert solo.word == "done" and solo.events == [("orbit.turn", {"turn": 1})]
    away = [horizontal_distance(setpoint.xyz, middle) for setpoint in told]
    on_it = next(k for k, r in enumerate(away) if r == pytest.approx(4.0, abs=0.03) and k > 20)
    rest = told[on_it + 30 :]
    for setpoint in rest[:-1]:
        assert horizontal_distance(setpoint.xyz, middle) == pytest.approx(4.0, abs=0.1)
        assert setpoint.yaw is not None
        assert abs(wrap(setpoint.yaw - bearing(setpoint.xyz, middle))) < 0.05
    # One and a half turns in that direction.
    swept, last = 0.0, bearing(middle, told[on_it].xyz)
    for setpoint in told[on_it:]:
        now = bearing(middle, setpoint.xyz)
        swept, last = swept + wrap(now - last), now
    assert swept == pytest.approx((-1 if clockwise else 1) * 3 * pi, abs=0.4)
    speeds = [s.velocity.norm() for s in told if s.velocity]
    assert max(speeds) <= 2.0 + 1e-6
    velocities = [s.velocity for s in told if s.velocity]
    assert max(distance(a, b) for a, b in pairwise(velocities)) <= 3.0 * 0.025


def test_height_and_climb() -> None:
    around = Point(6.0, 0.0, 0.0)
    solo, told = fly({"around": around, "radius": 3.0, "height": 5.0, "turns": 2, "climb": 1.0})
    assert solo.vehicle.position.z == pytest.approx(7.0, abs=0.01)
    assert max(s.xyz.z for s in told) <= 7.01
    _, told = fly({"around": around, "radius": 3.0})
    assert all(s.xyz.z == pytest.approx(3.0, abs=1e-6) for s in told)


def test_on_its_circle_it_goes_on_at_once() -> None:
    values = {"around": Point(5.0, 0.0, 3.0), "radius": 5.0, "turns": 0.25, "speed": 1.0}
    solo, _ = fly(values)
    assert distance(solo.vehicle.position, (5, -5, 3)) < 0.05


@settings(max_examples=80, deadline=None, derandomize=True)
@given(
    st.floats(-30, 30), st.floats(-30, 30), st.floats(-5, 5),
    st.floats(0.5, 15), st.sampled_from([1.0, -1.0]),
)  # fmt: skip
def test_every_way_onto_a_circle_ends_along_it(
    x: float, y: float, z: float, radius: float, turn: float
) -> None:
    here, centre = Point(x, y, z), Point(0.0, 0.0, 0.0)
    path, meets = onto_circle(here, centre, radius, turn)
    rim = Point(radius * cos(meets), radius * sin(meets), 0.0)
    assert distance(path.places[-1], rim) < 1e-6
    assert distance(path.places[0], here) < 0.5
    along = Point(-turn * sin(meets), turn * cos(meets), 0.0)
    assert angle_between(path.directions[-1], along) < 1e-3


def test_its_plan_leads_round() -> None:
    start = PlanStart(Point(10, 0, 3), 0.0, True, 0.0, 5.0)
    given_ = {name: parameter.default for name, parameter in INFO.parameters.items()}
    legs = Orbit.plan(Orbit.Params(**{**given_, "around": Point(0, 0, 0), "turns": 1.0}), start)
    assert legs is not None
    far = [horizontal_distance(leg.to, (0, 0, 0)) for leg in legs]
    assert min(far) == pytest.approx(5.0, abs=0.01) and max(far) < 10
    assert {round(wrap(bearing((0, 0, 0), leg.to))) for leg in legs} >= {-3, -2, -1, 0, 1, 2, 3}
