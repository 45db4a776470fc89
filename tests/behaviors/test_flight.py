"""The mission frame, and what passes through it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, inf, isclose, nan, pi, radians
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors import Face, Flight, MissionFrame, NotInControl, Waypoint
from behaviors.channel import Channel
from fsm.values.functions import EvaluationError
from fsm.values.types import ANY, AREA, HEADING, POINT, ROUTE
from hal import Lights, Limits
from hal.fake import FakeVehicle
from hal.vehicle import (
    ACCEPTED,
    Attitude,
    Frame,
    Hold,
    Intrinsics,
    Position,
    Reading,
    Setpoint,
    Velocity,
)
from tests.behaviors.flying import airborne, observed
from vencejo.geometry import EARTH_RADIUS, Point, distance

coordinate = st.floats(-1e4, 1e4)
points = st.builds(Point, coordinate, coordinate, coordinate)
EAST = Point(1.0, 0.0, 0.0)
HOME = Point(10.0, -20.0, 1.0)
FRAME = MissionFrame(HOME, {"gate": Point(12.0, -20.0, 3.0)}, (40.0, -3.0, 600.0))


START = Point(1.0, 2.0, 5.0)


def seen(position: Point = START, yaw: float = pi / 2) -> Any:
    """An observation, mission frame."""
    return observed(FakeVehicle(at=position, yaw=yaw))


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
    ("given", "point"),
    [
        ({"x": 4.0, "y": 6.0}, (4, 6)),
        ({"x": 4.0}, (4, 2)),
        ({"x": 14.0, "y": -14.0, "frame": "world"}, (4, 6)),
        ({"forward": 4.0, "left": -3.0}, (4, 6)),
    ],
)
def test_a_height_above_the_ground_is_that_of_the_place(given: Any, point: Any) -> None:
    """Also after the world's origin has jumped, and wherever home is."""

    def hill(x: float, y: float) -> float:
        return 0.5 * x - 0.25 * y

    for shift in (Point(0.0, 0.0, 0.0), Point(30.0, -7.0, 2.0)):
        frame = MissionFrame(HOME.plus(shift), None, None, shift, hill)
        x, y = point
        ground = hill(x + HOME.x, y + HOME.y) - HOME.z
        found = frame.point({**given, "above_ground": 4.0}, seen())
        assert found == pytest.approx((x, y, ground + 4.0))


@pytest.mark.parametrize(
    ("frame", "given", "message"),
    [
        (FRAME, {"x": 1.0, "above_ground": 4.0}, "the height of the ground is not known here"),
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
    session, vehicle = airborne()
    vehicle.position = Point(12.0, -17.0, 4.0)
    session.wait()
    channel = Channel(vehicle, FRAME, Random(0))
    assert channel.observation.position == (2, 3, 3)
    assert channel.observation.home == (-10, 20, -1)
    assert channel.world.position == (12, -17, 4)
    for setpoint, sent in (
        (Position(START, EAST, 0.5), Position(Point(11.0, -18.0, 6.0), EAST, 0.5)),
        (Velocity(1.0, 2.0), Velocity(1.0, 2.0)),
        (Attitude(0.1, 0.2), Attitude(0.1, 0.2)),
        (Hold(), Hold()),
    ):  # fmt: skip
        channel.setpoint = setpoint
        assert channel.send() == ACCEPTED
        assert vehicle.commands[-1] == sent
    vehicle.commands.clear()
    channel.observe()
    assert channel.send() == ACCEPTED
    assert vehicle.commands == []


def test_the_mission_frame_follows_when_the_world_s_origin_jumps() -> None:
    session, vehicle = airborne()
    channel = Channel(vehicle, MissionFrame(HOME, {"gate": HOME}), Random(0))
    before = channel.observation
    assert channel.jump is None
    for shift in (Point(3.0, -1.0, 0.5), Point(-1.0, 0.0, 0.0)):
        vehicle.jump(shift)
        session.wait()
        after = channel.observe()
        assert channel.jump is not None and channel.jump.offset == shift
        assert distance(after.position, before.position) < 1e-9
        assert distance(after.home, before.home) < 1e-9
        assert channel.frame.point("gate", after) == (0, 0, 0)
    session.wait()
    channel.observe()
    assert channel.jump is None
    assert channel.frame.origin == HOME.plus((2.0, -1.0, 0.5))


def test_what_people_write_down_is_in_the_world_frame_before_any_jump() -> None:
    frame = MissionFrame(HOME, {"gate": Point(12.0, -20.0, 3.0)}, (40.0, -3.0, 600.0))
    given = ("gate", {"x": 7.0, "frame": "world"}, {"lat": 40.001, "lon": -3.001}, {"left": 1.0})
    before = [frame.point(each, seen()) for each in given]
    frame.follow(Point(30.0, -20.0, 4.0))
    assert frame.follow(Point(31.0, -20.0, 5.0)) == (1.0, 0.0, 1.0)
    late = MissionFrame(frame.origin, {"gate": Point(12.0, -20.0, 3.0)}, (40.0, -3.0, 600.0),
                        Point(31.0, -20.0, 5.0))  # fmt: skip
    for each in (frame, late):
        for point, there in zip(given, before, strict=True):
            assert distance(each.point(point, seen()), there) < 1e-9
    begun = MissionFrame.at_start(
        seen(START)._replace(origin_shift=Point(1.0, 2.0, 3.0)), {"gate": START}
    )
    assert begun.point("gate", seen()) == (1.0, 2.0, 3.0)


def test_the_frame_begins_at_home_or_where_the_vehicle_is() -> None:
    here = seen(START)
    assert MissionFrame.at_start(here).origin == START
    stands = here._replace(home=START.plus((0.01, 0.0, 0.0)), flying=False)
    assert MissionFrame.at_start(stands).origin == stands.home
    assert MissionFrame.at_start(stands._replace(flying=True)).origin == START
    assert MissionFrame.at_start(stands._replace(home=HOME)).origin == START
    # What is within 5 cm of home stands on it.
    near, beside = (stands._replace(home=START.plus((0.0, y, 0.0))) for y in (0.049, 0.051))
    assert MissionFrame.at_start(near).origin == near.home
    assert MissionFrame.at_start(beside).origin == START


def test_limits_count_from_home() -> None:
    _, vehicle = airborne()
    channel = Channel(vehicle, MissionFrame(HOME), Random(0))
    channel.world = channel.world._replace(home=HOME)
    assert channel.configure(Limits(min_altitude=1.0, max_altitude=4.0, max_speed=2.0)) == ACCEPTED
    assert (vehicle.limits.min_altitude, vehicle.limits.max_altitude) == (2.0, 5.0)
    assert vehicle.limits.max_speed == 2.0


def test_pictures_are_taken_in_the_mission_frame() -> None:
    picture = Frame(
        np.zeros((1, 1, 3), np.uint8), 7, 1.0, Intrinsics(1, 1, 1, 1, 0, 0),
        Point(12.0, -17.0, 4.0), (0.0, 0.0, 0.0, 1.0),
    )  # fmt: skip
    looked: list[tuple[str, Frame]] = []
    source = Source()
    channel = Channel(watching(source), FRAME, Random(0))
    channel.on_frame = lambda name, frame: looked.append((name, frame))
    through = channel.camera("front")
    assert through.latest() is None and looked == []
    source.newest = picture
    taken = through.latest()
    assert taken is not None
    assert (taken.position, taken.sequence) == ((2, 3, 3), 7)
    assert looked == [("front", picture)]


def test_readings_are_told_where_they_become_visible() -> None:
    measured: list[tuple[str, Reading]] = []
    source = Source()
    channel = Channel(watching(source), FRAME, Random(0))
    channel.on_reading = lambda name, reading: measured.append((name, reading))
    through = channel.sensor("down")
    assert through.latest() is None and measured == []
    source.newest = Reading(1.0, {"range": 2.5})
    assert through.latest() == source.newest
    assert measured == [("down", source.newest)]


@dataclass
class Source:
    """A camera or a sensor, as a test wants it."""

    newest: Any = None

    def latest(self) -> Any:
        return self.newest


def watching(source: Source) -> FakeVehicle:
    """A vehicle whose every camera and sensor is this one."""

    class Watching(FakeVehicle):
        def camera(self, name: str) -> Source:
            return source

        def sensor(self, name: str) -> Source:
            return source

    vehicle = Watching()
    vehicle.advance(0.025)
    return vehicle


# -- the access of one behaviour ----------------------------------------------------------------


def flight(*controls: str) -> tuple[Flight, FakeVehicle]:
    _, vehicle = airborne()
    channel = Channel(vehicle, FRAME, Random(0))
    return Flight(channel, controls, lambda name, record: None, lambda record: None), vehicle


MOTION: dict[str, Callable[[Flight], Any]] = {
    "command": lambda f: f.command(Hold()),
    "arm": lambda f: f.arm(),
    "disarm": lambda f: f.disarm(),
    "takeoff": lambda f: f.takeoff(1.0),
    "land": lambda f: f.land(),
    "return_home": lambda f: f.return_home(),
    "reset": lambda f: f.reset(),
    "trim": lambda f: f.trim(),
}


@pytest.mark.parametrize("name", MOTION)
def test_to_command_belongs_to_those_who_control_motion(name: str) -> None:
    mine, vehicle = flight("motion")
    vehicle.verbs.clear()
    MOTION[name](mine)
    assert vehicle.verbs == ([] if name == "command" else [name])
    vehicle.verbs.clear()
    companion, other = flight("lights")
    other.verbs.clear()
    with pytest.raises(NotInControl, match="does not control motion"):
        MOTION[name](companion)
    assert other.verbs == []


def test_lights_belong_to_those_who_control_lights() -> None:
    mine, vehicle = flight("lights")
    assert mine.lights(Lights("solid", "red")).verb == "lights"
    vehicle.verbs.clear()
    with pytest.raises(NotInControl, match="does not control lights"):
        flight("motion")[0].lights(Lights("solid", "red"))


def test_reading_is_free() -> None:
    companion, vehicle = flight()
    assert companion.now == companion.observation.time == vehicle.observe().time
    assert companion.dt == 0.025 and companion.frame is FRAME
    assert companion.capabilities == vehicle.capabilities
    assert 0 <= companion.rng.random() < 1


def test_one_that_is_being_stopped_commands_nothing() -> None:
    mine, _ = flight("motion")
    mine.may_command = False
    with pytest.raises(NotInControl, match="being stopped"):
        mine.command(Hold())


@pytest.mark.parametrize(
    "setpoint", [Velocity(x=nan), Position(Point(0.0, inf, 0.0)), Attitude(nan)]
)
def test_a_set_point_without_finite_numbers_is_a_mistake(setpoint: Setpoint) -> None:
    mine, _ = flight("motion")
    with pytest.raises(ValueError, match="finite"):
        mine.command(setpoint)
