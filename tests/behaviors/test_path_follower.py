"""Following a path: its set-points, and what they wait for."""

from __future__ import annotations

import json
from itertools import pairwise
from math import cos, pi, sin

import pytest

from behaviors.guidance import ACCELERATION, MAX_LEAD, SMOOTHING
from behaviors.pace import Agility, Pace, paced
from behaviors.path import Corner, Path, PathBuilder, blended
from behaviors.path_follower import PathFollower
from hal.fake import FakeVehicle
from hal.vehicle import PERIOD, Observation
from tests.behaviors.flying import observed
from vencejo.geometry import Point, distance

SEEN = observed(FakeVehicle())
CORNERS = [Point(0, 0, 2), Point(6, 0, 2), Point(6, 6, 2), Point(0, 6, 2)]


def square(speed: float = 2.0) -> PathFollower:
    path, _ = blended([Corner(place, 0.25) for place in CORNERS])
    return PathFollower(path, paced(path, [speed] * (len(path.ways) - 1), Agility(3.0)))


def circle(turns: float, speed: float = 1.0) -> tuple[Path, Pace]:
    """A circle of radius 2 m, at its speed from the first moment on."""
    builder = PathBuilder(Point(2, 0, 2), Point(0, 1, 0))
    for k in range(1, round(100 * turns) + 1):
        a = k * pi / 50
        place, direction = Point(2 * cos(a), 2 * sin(a), 2), Point(-sin(a), cos(a), 0)
        builder.add(place, direction, 2 * pi / 50)
    path = builder.path()
    times = [way / speed for way in path.ways]
    return path, Pace(times, path.ways, [speed] * len(times))


def on_it(follower: PathFollower) -> Observation:
    """A vehicle that is right where the follower is."""
    return SEEN._replace(position=follower.place, velocity=follower.velocity)


def test_its_set_points_belong_together_and_have_no_steps() -> None:
    follower = square()
    last, count = None, 0
    while not follower.ended:
        follower.step(on_it(follower), PERIOD)
        setpoint = follower.setpoint(0.0)
        assert setpoint.velocity is not None and setpoint.acceleration is not None
        assert setpoint.velocity.norm() <= 2.0 + 1e-9
        if last is not None:
            (place, velocity, *_, acceleration), dt = last, PERIOD
            assert distance(setpoint.xyz, place.plus([v * dt for v in velocity])) < 1e-9
            assert distance(setpoint.velocity, velocity.plus([a * dt for a in acceleration])) < 1e-9
            step = distance(setpoint.acceleration, acceleration)
            assert step <= 2 * 5.0 / SMOOTHING
        last, count = setpoint, count + 1
        assert count < 1000
    assert last is not None and distance(last.xyz, CORNERS[-1]) < 1e-6
    assert last.velocity == pytest.approx((0, 0, 0), abs=1e-5)


def test_it_waits_for_a_vehicle_that_does_not_follow_and_goes_on_with_it() -> None:
    follower = square()
    for _ in range(400):
        follower.step(SEEN._replace(position=CORNERS[0]), PERIOD)
    assert distance(follower.place, CORNERS[0]) == pytest.approx(MAX_LEAD, abs=0.3)
    assert follower.velocity.norm() < 0.02
    for _ in range(600):
        follower.step(on_it(follower), PERIOD)
    assert follower.ended


def test_a_path_at_speed_is_come_to_smoothly_and_flown_exactly_in_time() -> None:
    path, pace = circle(3)
    follower = PathFollower(path, pace, ramp=1.0)
    ways, speeds = [], []
    while not follower.ended:
        follower.step(on_it(follower), PERIOD)
        ways.append(follower.way)
        speeds.append(follower.velocity.norm())
        assert distance(follower.place, (0, 0, 2)) == pytest.approx(2, abs=1e-4)
        assert len(ways) < 2000
    assert speeds[0] < 0.01 and max(speeds) <= 1.001
    # At its rate it is as far as its pace says, but for the time it took to get there.
    assert ways[800] - ways[400] == pytest.approx(10.0, abs=1e-6)
    changes = [abs(b - a) / PERIOD for a, b in pairwise(speeds)]
    assert max(changes) <= ACCELERATION
    assert ways[-1] == pytest.approx(6 * 2 * pi)


def test_late_periods_make_no_bumps() -> None:
    follower = square()
    for k in range(200):
        dt = PERIOD * (1.2 if k % 3 == 0 else 0.9)
        follower.step(on_it(follower), dt)
        if 70 < k < 95:
            assert follower.velocity.norm() == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("exact", [False, True])
def test_it_goes_on_from_its_progress_to_the_last_digit(exact: bool) -> None:
    def make() -> PathFollower:
        return PathFollower(*circle(1), ramp=1.0) if exact else square()

    first = make()
    for k in range(300):
        if k % 50 == 0:
            again = make()
            again.resume(json.loads(json.dumps(first.progress(), allow_nan=False)))
        seen = on_it(first)
        first.step(seen, PERIOD)
        again.step(seen, PERIOD)
        assert first.setpoint(0.5) == again.setpoint(0.5)
