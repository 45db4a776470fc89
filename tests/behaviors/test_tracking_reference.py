"""The reference that follows a moving target: bounded whatever it is told."""

from __future__ import annotations

from math import cos, hypot, pi, sin

from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors.guidance import STILL
from behaviors.tracking_reference import Aim, TrackingReference
from hal.limits import Limits
from hal.vehicle import PERIOD, Observation
from tests.behaviors.flying import airborne
from vencejo.geometry import Point, distance, wrap

LIMITS = Limits(max_speed=5.0, max_climb=2.0, max_tilt=0.35, max_yaw_rate=1.75)


def observation() -> Observation:
    _, vehicle = airborne(3.0)
    return vehicle.observe()


START = observation()


def followed(reference: TrackingReference, aims: list[Aim]) -> list[Point]:
    """The places of a reference whose vehicle keeps up."""
    seen, places = START, []
    for aim in aims:
        reference.step(aim, seen, PERIOD)
        seen = seen._replace(position=reference.place, velocity=reference.velocity)
        places.append(reference.place)
    return places


def test_it_comes_to_rest_at_a_place() -> None:
    goal = Point(6.0, -3.0, 4.0)
    reference = TrackingReference(START, LIMITS, 3.0)
    places = followed(reference, [Aim(goal, STILL, STILL, 2.0, 0.0)] * 400)
    assert distance(places[-1], goal) < 0.01 and reference.velocity.norm() < 0.01
    assert abs(wrap(reference.yaw - 2.0)) < 0.01
    assert max(place.x for place in places) < 6.1, "it does not overshoot"


def test_it_stays_with_a_target_on_a_circle() -> None:
    """1.5 m/s at 72°/s."""
    rate = 0.4 * pi
    radius = 1.5 / rate
    aims = []
    for k in range(600):
        a = rate * k * PERIOD
        east, north = cos(a), sin(a)
        aims.append(
            Aim(
                Point(radius * east, radius * north, 3.0),
                Point(-1.5 * north, 1.5 * east, 0.0),
                Point(-1.5 * rate * east, -1.5 * rate * north, 0.0),
                wrap(a + pi),
                rate,
            )
        )
    reference = TrackingReference(START, LIMITS, 3.0)
    places = followed(reference, aims)
    assert all(distance(a.place, b) < 0.06 for a, b in list(zip(aims, places, strict=True))[200:])
    assert abs(wrap(reference.yaw - aims[-1].yaw)) < 0.1


numbers = st.floats(-1e6, 1e6)
points = st.builds(Point, numbers, numbers, numbers)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.builds(Aim, points, points, points, numbers, numbers), min_size=3, max_size=12))
def test_whatever_it_is_told_it_never_jumps(aims: list[Aim]) -> None:
    reference = TrackingReference(START, LIMITS, 3.0)
    seen, velocity, rate = START, START.velocity, 0.0
    for aim in [each for each in aims for _ in range(10)]:
        reference.step(aim, seen, PERIOD)
        change = reference.velocity.minus(velocity)
        assert hypot(change.x, change.y) <= 2.8 * PERIOD + 1e-9
        assert abs(change.z) <= 1.6 * PERIOD
        assert hypot(reference.velocity.x, reference.velocity.y) < 3.6
        assert abs(reference.yaw_rate - rate) <= 6.01 * PERIOD and abs(reference.yaw_rate) < 1.76
        velocity, rate = reference.velocity, reference.yaw_rate
        seen = seen._replace(position=reference.place, velocity=velocity)


def test_it_waits_for_a_vehicle_that_is_held_up() -> None:
    reference = TrackingReference(START, LIMITS, 3.0)
    for _ in range(200):
        reference.step(Aim(Point(50.0, 0.0, 3.0), STILL, STILL, 0.0, 0.0), START, PERIOD)
    assert distance(reference.place, START.position) < 0.8
