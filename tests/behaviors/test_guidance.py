"""The reference: how it moves, whatever it is asked."""

from __future__ import annotations

from math import pi, sqrt

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors import Face
from behaviors.guidance import (
    ACCELERATION,
    BRAKING,
    MAX_LEAD,
    SMOOTHING,
    STILL,
    Reference,
    acceleration_at,
    yaw_towards,
)
from hal.fake import FakeVehicle
from hal.vehicle import PERIOD, Observation
from tests.behaviors.flying import observed
from vencejo.geometry import Point, distance

SEEN = observed(FakeVehicle())
coordinate = st.floats(-20, 20)
points = st.builds(Point, coordinate, coordinate, coordinate)
component = st.floats(-3, 3)
velocities = st.builds(Point, component, component, component)
speeds = st.floats(0.2, 8)


def follow(reference: Reference) -> Observation:
    """A vehicle that is right where the reference is."""
    return SEEN._replace(position=reference.position, velocity=reference.velocity)


def step(reference: Reference, target: Point, speed: float) -> None:
    reference.step(target, speed, follow(reference), PERIOD)


def change(after: Point, before: Point) -> float:
    return distance(after, before)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(points, points, speeds)
def test_from_rest_it_arrives_straight_in_time_and_never_past(
    start: Point, target: Point, speed: float
) -> None:
    reference = Reference(start, STILL)
    way = distance(start, target)
    # Time at speed, plus half of speeding up and slowing down, plus the wait for a vehicle.
    ramp = speed / acceleration_at(speed)
    periods = round((way / speed + ramp + ramp / BRAKING + 0.5) / PERIOD) + 2 + SMOOTHING
    left = way
    for _ in range(periods):
        before = reference.velocity
        step(reference, target, speed)
        assert reference.velocity.norm() <= speed + 1e-9
        assert change(reference.velocity, before) <= ACCELERATION * PERIOD + 1e-9
        now_left = distance(reference.position, target)
        assert now_left <= left + 1e-9
        # Straight: on the line between start and target, and so never past it either.
        assert distance(start, reference.position) + now_left == pytest.approx(way, abs=1e-6)
        left = now_left
    assert left < 1e-6
    assert reference.velocity.norm() < 1e-6


@settings(max_examples=60, deadline=None, derandomize=True)
@given(points, velocities, points, speeds)
def test_whatever_it_did_before_it_arrives_without_a_jerk(
    start: Point, velocity: Point, target: Point, speed: float
) -> None:
    reference = Reference(start, velocity)
    fastest = max(speed, velocity.norm())
    most = sqrt(2) * ACCELERATION * PERIOD + 1e-9
    way = distance(start, target) + fastest * fastest / (BRAKING * acceleration_at(speed))
    step(reference, target, speed)
    for _ in range(round((way / speed + 4 * fastest + 6) / PERIOD)):
        place, before = reference.position, reference.velocity
        step(reference, target, speed)
        assert change(reference.velocity, before) <= most
        # It says how it moves until the next period.
        moved = distance(reference.position, place)
        assert moved == pytest.approx(before.norm() * PERIOD, abs=1e-9)
        assert reference.velocity.norm() <= fastest + 1e-9
    assert distance(reference.position, target) < 1e-6
    assert reference.velocity.norm() < 1e-6


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.lists(st.tuples(points, speeds, st.integers(1, 80)), min_size=2, max_size=6))
def test_targets_and_speeds_that_change_on_the_way_make_no_jump(
    wishes: list[tuple[Point, float, int]],
) -> None:
    reference = Reference(STILL, STILL)
    most = sqrt(2) * ACCELERATION * PERIOD + 1e-9
    fastest = 0.0
    for target, speed, periods in wishes:
        fastest = max(fastest, speed)
        for _ in range(periods):
            before, led = reference.velocity, reference.acceleration
            step(reference, target, speed)
            assert change(reference.velocity, before) <= most
            assert reference.velocity.norm() <= fastest + 1e-9
            # Nor does its acceleration.
            assert change(reference.acceleration, led) <= 2 * most / PERIOD / SMOOTHING


def test_a_stop_is_even_and_takes_the_way_it_should() -> None:
    reference = Reference(STILL, Point(2.0, 0.0, 0.0))
    for _ in range(80):
        reference.stop(follow(reference), PERIOD)
    assert reference.velocity == STILL
    way = 2**2 / (2 * ACCELERATION) + 2 * SMOOTHING * PERIOD / 2
    assert reference.position == pytest.approx((way, 0, 0), abs=0.06)


def test_it_waits_for_a_vehicle_that_does_not_follow() -> None:
    reference = Reference(STILL, STILL)
    for _ in range(400):
        reference.step(Point(50.0, 0.0, 0.0), 5.0, SEEN, PERIOD)
    assert reference.position.x == pytest.approx(MAX_LEAD, abs=0.05)
    assert reference.velocity.norm() < 0.01


@pytest.mark.parametrize("most", [0.5, 2.0])
def test_it_settles_to_the_speed_of_a_slow_vehicle(most: float) -> None:
    reference, place = Reference(STILL, STILL), STILL
    for period in range(800):
        ahead = reference.position.x - place.x
        flown = min(most, reference.velocity.x + 2.0 * ahead)
        place = Point(place.x + flown * PERIOD, 0.0, 0.0)
        seen = SEEN._replace(position=place, velocity=Point(flown, 0.0, 0.0))
        reference.step(Point(500.0, 0.0, 0.0), 20.0, seen, PERIOD)
        if period > 400:
            # No swinging about that speed.
            assert reference.velocity.x == pytest.approx(most, abs=0.05)
            assert reference.position.x - place.x == pytest.approx(MAX_LEAD, abs=0.05)


def test_what_moves_it_off_its_line_goes_first() -> None:
    reference = Reference(STILL, Point(0.0, 0.0, 0.2))
    for _ in range(80):
        step(reference, Point(20.0, 0.0, 0.0), 2.0)
    # v²/2a, and not the longer way of a common limit for both directions; smoothly.
    assert reference.position.z < 0.2**2 / (2 * ACCELERATION) + 0.2 * SMOOTHING * PERIOD / 2


HERE, AHEAD = Point(0.0, 0.0, 2.0), Point(0.0, 9.0, 2.0)


@pytest.mark.parametrize(
    ("heading", "target", "yaw"),
    [
        ("keep", AHEAD, 0.5),
        ("travel", AHEAD, pi / 2),
        ("travel", Point(0.1, 0.1, 9.0), 0.7),
        (Face(Point(-3.0, 0.0, 0.0)), AHEAD, pi),
        (Face(Point(0.0, 0.2, 0.0)), AHEAD, 0.7),
        # Less than 0.3 m away nothing has a direction.
        ("travel", Point(0.0, 0.29, 2.0), 0.7),
        ("travel", Point(0.0, 0.31, 2.0), pi / 2),
        (Face(Point(-0.29, 0.0, 0.0)), AHEAD, 0.7),
        (Face(Point(-0.31, 0.0, 0.0)), AHEAD, pi),
        (4.0, AHEAD, 4.0 - 2 * pi),
    ],
)
def test_headings(heading: float | str | Face, target: Point, yaw: float) -> None:
    assert yaw_towards(heading, HERE, target, 0.5, 0.7) == pytest.approx(yaw)
