"""The mission frame, and what passes through it."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, isclose, pi, radians
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors import Face, Flight, MissionFrame, Waypoint
from fsm.values.functions import EvaluationError
from fsm.values.types import ANY, AREA, HEADING, POINT, ROUTE
from hal.fake import FakeVehicle
from hal.vehicle import Frame, Hold, Intrinsics, Position, Velocity
from tests.behaviors.flying import airborne
from vencejo.geometry import EARTH_RADIUS, Point, distance

coordinate = st.floats(-1e4, 1e4)
points = st.builds(Point, coordinate, coordinate, coordinate)
EAST = Point(1.0, 0.0, 0.0)
HOME = Point(10.0, -20.0, 1.0)
FRAME = MissionFrame(HOME, {"gate": Point(12.0, -20.0, 3.0)}, (40.0, -3.0, 600.0))


START = Point(1.0, 2.0, 5.0)


def seen(position: Point = START, yaw: float = pi / 2) -> Any:
    """An observation, mission frame."""
    return FakeVehicle(at=position, yaw=yaw).observe()


@settings(derandomize=True)
@given(points, points)
def test_world_and_mission_frame_go_round(origin: Point, point: Point) -> None:
    frame = MissionFrame(origin)
    assert distance(frame.from_world(frame.to_world(point)), point) < 1e-8
    assert distance(frame.to_world(frame.from_world(point)), point) < 1e-8
    assert frame.to_world(Point(0.0, 0.0, 0.0)) == origin


@settings(derandomize=True)
@given(points, points)
def test_a_point_named_in_either_frame_is_the_same(origin: Point, point: Point) -> None:
    frame = MissionFrame(origin)
    world = dict(zip("xyz", frame.to_world(point), strict=True)) | {"frame": "world"}
    mission = dict(zip("xyz", point, strict=True)) | {"frame": "mission"}
    assert distance(frame.point(world, seen()), frame.point(mission, seen())) < 1e-8


@settings(derandomize=True)
@given(points, st.floats(-pi, pi), st.floats(-100, 100), st.floats(-100, 100))
def test_body_points_are_as_far_as_they_say(
    here: Point, yaw: float, forward: float, left: float
) -> None:
    start = seen(here, yaw)
    point = FRAME.point({"forward": forward, "left": left, "up": 2.0}, start)
    assert point.z == here.z + 2.0
    off = point.minus(here)
    assert isclose(off.x**2 + off.y**2, forward**2 + left**2, abs_tol=1e-6)
    assert off.x * cos(yaw) + off.y * cos(yaw - pi / 2) == pytest.approx(forward, abs=1e-6)


def test_body_points_count_from_the_pose_at_the_start() -> None:
    assert FRAME.point({"forward": 3.0}, seen()) == pytest.approx((1, 5, 5))
    assert FRAME.point({"left": 3.0}, seen()) == pytest.approx((-2, 2, 5))
    assert FRAME.point({"up": -1.0}, seen()) == pytest.approx((1, 2, 4))


@pytest.mark.parametrize(
    ("given", "point"),
    [
        ("home", (0, 0, 5)),
        ("gate", (2, 0, 2)),
        (Point(7.0, 8.0, 9.0), (7, 8, 9)),
        ({"x": 7.0, "y": 8.0}, (7, 8, 5)),
        ({"z": 9.0}, (1, 2, 9)),
        ({"x": 7.0, "frame": "world"}, (-3, 2, 5)),
        ({"z": 7.0, "frame": "world"}, (1, 2, 6)),
    ],
)
def test_the_forms_of_a_point(given: Any, point: tuple[float, float, float]) -> None:
    assert FRAME.point(given, seen()) == pytest.approx(point)


def test_latitude_and_longitude() -> None:
    step = radians(0.001) * EARTH_RADIUS
    there = FRAME.point({"lat": 40.001, "lon": -3.001, "above_home": 7.0}, seen())
    assert there == pytest.approx((-step * cos(radians(40)) - 10, step + 20, 7.0))
    assert FRAME.point({"lat": 40.0, "lon": -3.0}, seen()) == pytest.approx((-10, 20, 5))


@pytest.mark.parametrize(
    ("frame", "given", "message"),
    [
        (FRAME, "gata", "there is no place 'gata' here (known: home, gate)"),
        (FRAME, 3.0, "3 is not a point"),
        (MissionFrame(HOME), {"lat": 1.0, "lon": 2.0}, "no geographic position"),
    ],
)
def test_what_is_no_point(frame: MissionFrame, given: Any, message: str) -> None:
    with pytest.raises(EvaluationError) as raised:
        frame.point(given, seen())
    assert message in str(raised.value)


def test_values_become_what_behaviours_use() -> None:
    def resolved(type_: Any, given: Any) -> Any:
        return FRAME.resolve(type_, given, seen())

    assert resolved(POINT, "gate") == (2, 0, 2)
    assert resolved(HEADING, {"face": "gate"}) == Face(Point(2, 0, 2))
    assert resolved(HEADING, "travel") == "travel"
    assert resolved(HEADING, 1) == 1.0
    assert resolved(AREA, ["gate", {"z": 1.0}]) == [(2, 0, 2), (1, 2, 1)]
    assert resolved(ANY, {"lat": "as it is"}) == {"lat": "as it is"}
    assert resolved(POINT, None) is None
    long = {"at": "gate", "heading": {"face": "home"}, "speed": 2.0, "dwell": 1.0}
    assert resolved(ROUTE, ["home", long]) == [
        Waypoint(Point(0, 0, 5)),
        Waypoint(Point(2, 0, 2), Face(Point(0, 0, 5)), 2.0, 1.0),
    ]


def test_the_vehicle_is_observed_in_the_mission_frame_and_commanded_in_the_world_s() -> None:
    _, vehicle = airborne()
    vehicle.position = Point(12.0, -17.0, 4.0)
    flight = Flight(vehicle, FRAME, Random(0))
    assert flight.observation.position == (2, 3, 3)
    assert flight.observation.home == (-10, 20, -1)
    assert flight.world.position == (12, -17, 4)
    for setpoint, sent in (
        (Position(START, EAST, 0.5), Position(Point(11.0, -18.0, 6.0), EAST, 0.5)),
        (Velocity(1.0, 2.0), Velocity(1.0, 2.0)),
        (Hold(), Hold()),
    ):  # fmt: skip
        flight.command(setpoint)
        flight.send()
        assert vehicle.commands[-1] == sent
    vehicle.commands.clear()
    flight.observe()
    flight.send()
    assert vehicle.commands == []


def test_pictures_are_taken_in_the_mission_frame() -> None:
    picture = Frame(
        np.zeros((1, 1, 3), np.uint8), 7, 1.0, Intrinsics(1, 1, 1, 1, 0, 0),
        Point(12.0, -17.0, 4.0), (0.0, 0.0, 0.0, 1.0),
    )  # fmt: skip

    @dataclass
    class Camera:
        picture: Frame | None = None

        def latest(self) -> Frame | None:
            return self.picture

    camera = Camera()

    class Seeing(FakeVehicle):
        def camera(self, name: str) -> Camera:
            return camera

    through = Flight(Seeing(), FRAME, Random(0)).camera("front")
    assert through.latest() is None
    camera.picture = picture
    taken = through.latest()
    assert taken is not None
    assert (taken.position, taken.sequence) == ((2, 3, 3), 7)


def test_events_and_values_need_a_behaviour_at_work() -> None:
    flight = Flight(FakeVehicle(), FRAME, Random(0))
    with pytest.raises(RuntimeError):
        flight.raise_event("a.b", None)
    with pytest.raises(RuntimeError):
        flight.publish(None)
