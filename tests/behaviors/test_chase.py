"""The reference that stays with a moving target."""

from __future__ import annotations

import json
from math import cos, hypot, pi, sin
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors.chase import ACCELERATION, JERK, Chase, turned_towards
from behaviors.guidance import MAX_LEAD
from hal.vehicle import PERIOD, Observation
from tests.behaviors.flying import airborne
from vencejo.geometry import Point, distance

STILL = Point(0.0, 0.0, 0.0)
coordinates = st.floats(-200, 200)
points = st.builds(Point, coordinates, coordinates, coordinates)


def observation() -> Observation:
    _, vehicle = airborne(3.0)
    return vehicle.observe()


START = observation()


def follow(chase: Chase, target, seconds: float, speed: float = 5.0, start: float = 0.0):  # type: ignore[no-untyped-def]
    """Let a chase follow ``target(time) -> (place, velocity)`` with a vehicle that keeps up."""
    seen, places = START, []
    for k in range(round(seconds / PERIOD)):
        place, velocity = target(start + k * PERIOD)
        chase.step(place, velocity, speed, seen, PERIOD)
        seen = seen._replace(position=chase.position, velocity=chase.velocity)
        places.append((chase.position, place))
    return places


def test_it_stops_at_a_target_that_stays_without_overshooting() -> None:
    goal = Point(6.0, -3.0, 4.0)
    places = follow(Chase(START), lambda _: (goal, STILL), 9.0)
    assert distance(places[-1][0], goal) < 0.005
    way = goal.minus(START.position)
    along = [
        sum(a * b for a, b in zip(place.minus(START.position), way, strict=True)) / way.norm()
        for place, _ in places
    ]
    assert max(along) < way.norm() + 0.01


def test_it_stays_with_a_target_on_a_line_exactly() -> None:
    def target(time: float) -> tuple[Point, Point]:
        return Point(3 + 2 * time, 1 - time, 3.0), Point(2.0, -1.0, 0.0)

    places = follow(Chase(START), target, 8.0)
    assert distance(*places[-1]) < 0.06  # of one period's way


def test_the_stiffer_the_nearer_it_stays_in_bends() -> None:
    def target(time: float) -> tuple[Point, Point]:
        angle = pi / 2 * time  # 1.5 m/s at 90°/s
        radius = 1.5 / (pi / 2)
        place = Point(radius * cos(angle), radius * sin(angle), 3.0)
        return place, Point(-1.5 * sin(angle), 1.5 * cos(angle), 0.0)

    soft, stiff = (
        max(distance(*pair) for pair in follow(Chase(START, k), target, 12.0)[-100:])
        for k in (1.0, 3.0)
    )
    assert stiff < 0.14 < soft < 0.7


@settings(deadline=None)
@given(st.lists(st.tuples(points, points), min_size=1, max_size=8), st.floats(0.1, 12))
def test_nothing_that_it_is_told_makes_it_jump(
    told: list[tuple[Point, Point]], speed: float
) -> None:
    chase, seen = Chase(START), START
    last, last_velocity, last_acceleration = chase.position, chase.velocity, chase.acceleration
    for target, velocity in told:
        for _ in range(10):
            chase.step(target, velocity, speed, seen, PERIOD)
            seen = seen._replace(position=chase.position, velocity=chase.velocity)
            assert distance(chase.position, last) <= speed * 1.5 * PERIOD + 0.1
            assert chase.velocity.minus(last_velocity).norm() <= ACCELERATION * PERIOD + 1e-9
            jerk = chase.acceleration.minus(last_acceleration).norm() / PERIOD
            assert jerk <= JERK + 1e-6
            last, last_velocity = chase.position, chase.velocity
            last_acceleration = chase.acceleration


def test_it_waits_for_a_vehicle_that_is_held_up() -> None:
    chase = Chase(START)
    for _ in range(400):
        chase.step(Point(50.0, 0.0, 3.0), STILL, 5.0, START, PERIOD)
    assert distance(chase.position, START.position) <= MAX_LEAD + 1e-9


def test_it_stops_where_it_comes_to_rest() -> None:
    chase = Chase(START._replace(velocity=Point(2.0, 0.0, 0.0)))
    seen = START
    for _ in range(200):
        chase.stop(seen, PERIOD)
        seen = seen._replace(position=chase.position)
    assert chase.velocity.norm() < 0.01
    assert 0.2 < hypot(*chase.position.minus(START.position)[:2]) < 2.0


def test_it_goes_on_from_its_progress() -> None:
    first, second = Chase(START), Chase(START)
    goal = Point(4.0, 4.0, 4.0)
    places = follow(first, lambda _: (goal, STILL), 1.0)
    second.go_on(json.loads(json.dumps(first.progress())))
    seen = START._replace(position=places[-1][0])
    for chase in (first, second):
        chase.step(goal, STILL, 5.0, seen, PERIOD)
    assert first.setpoint(0.0) == second.setpoint(0.0)


def test_yaws_turn_the_shorter_way_at_their_rate() -> None:
    random = Random(4)
    for _ in range(50):
        yaw, wanted = random.uniform(-pi, pi), random.uniform(-pi, pi)
        steps = 0
        while abs(yaw - wanted) > 1e-9:
            yaw = turned_towards(yaw, wanted, 1.0, PERIOD)
            steps += 1
        assert steps * PERIOD <= pi + PERIOD
    assert turned_towards(3.1, -3.1, 1.0, PERIOD) == pytest.approx(3.125)
