"""track_object."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import cos, hypot, pi, sin
from typing import Any

import numpy as np
import pytest

from behaviors.plan import UNKNOWN, PlanStart, Unflyable
from behaviors.track_object import TrackObject
from hal.scene.arrays import Pixels
from hal.vehicle import PERIOD, Position
from tests.behaviors.flying import Solo
from tests.behaviors.perception.markers import marker_of
from tests.behaviors.sighted import Look, shown, sighted
from tests.hal.scenes import ROAD, thing_of, world_of
from vencejo.geometry import Point, Pose, bearing, distance, wrap, yaw_quaternion
from worlds.figures import standing
from worlds.motion import pose_at
from worlds.things import Motion, Sphere, Thing

BALL = {"color": "red", "size": 0.4}
MARKER = {"id": 7, "size": 0.4}
START = PlanStart(Point(0.0, 0.0, 3.0), 0.0, True, 0.0, 15.0)


def ball(*through: tuple[float, float, float], speed: float = 0.8) -> Thing:
    """A red ball, still at one place or moving through several."""
    points = tuple(Point(*place) for place in through)
    still = thing_of("ball", Sphere(0.2), points[0], color=(210, 25, 25))
    if len(points) == 1:
        return still
    return replace(still, motion=Motion(points, speed, loop=False, turns=False))


def lying(number: int, x: float, y: float, heading: float = 0.0, speed: float = 0.0) -> Thing:
    """A marker on the ground, which may move to the east."""
    marker = marker_of("4X4_50", number, Point(x, y, 0.0), 0.4, yaw_quaternion(heading))
    path = Point(x, y, 0.0), Point(x + 100.0, y, 0.0)
    motion = Motion(path, speed, loop=False, turns=False) if speed else None
    return replace(marker, name=f"marker{number}", motion=motion)


def tracking(look: Look, values: dict[str, Any], height: float = 1.5) -> Solo:
    return Solo("track_object", values, vehicle=sighted(look, height))


def seen_of(*things: Thing) -> Look:
    return shown(world_of(*things, ground=ROAD))


def hidden(look: Look, when: Callable[[Pose, float], bool]) -> Look:
    """A look that is black at times."""

    def hide(pose: Pose, time: float) -> Pixels | None:
        image = look(pose, time)
        return np.zeros_like(image) if image is not None and when(pose, time) else image

    return hide


def test_it_stays_before_a_thing_at_its_distance() -> None:
    thing = ball((5, -2, 1.5), (5, 20, 1.5))
    solo = tracking(seen_of(thing), {"target": BALL, "distance": 2.5})
    solo.run(6)
    errors, turns = [], []
    for _ in range(200):
        solo.step()
        at, here = pose_at(thing, solo.time)[0], solo.vehicle.position
        errors.append(distance(at, here) - 2.5)
        turns.append(wrap(bearing(here, at) - solo.vehicle.yaw))
        assert here.z == pytest.approx(1.5, abs=0.02)
    assert hypot(*errors) / len(errors) ** 0.5 < 0.1 and max(map(abs, errors)) < 0.2
    assert max(map(abs, turns)) < 0.06
    told = solo.activity.published
    assert told.visible and told.age < 0.3
    assert told.distance == pytest.approx(2.5, abs=0.2) and abs(told.offset) < 0.15
    assert told.velocity.y == pytest.approx(0.8, abs=0.15)
    assert distance(told.position, pose_at(thing, solo.time)[0]) < 0.15


@pytest.mark.slow
def test_it_follows_up_and_down_when_it_is_told_a_height() -> None:
    solo = tracking(seen_of(ball((4, 0, 2.6))), {"target": BALL, "height": -0.2})
    solo.run(6)
    assert solo.vehicle.position.z == pytest.approx(2.4, abs=0.06)
    assert solo.activity.published.height == pytest.approx(-0.2, abs=0.06)


@pytest.mark.slow
def test_it_turns_round_until_it_sees_the_thing() -> None:
    solo = tracking(seen_of(ball((-4, 0.5, 1.5))), {"target": BALL, "patience": 15.0})
    solo.run(9)
    assert solo.outcome is None and solo.activity.published.visible
    assert abs(wrap(solo.vehicle.yaw - pi)) < 0.4


def test_it_is_lost_after_its_patience() -> None:
    solo = tracking(seen_of(), {"target": BALL, "patience": 3.0})
    began = solo.time
    solo.run(20)
    assert solo.word == "lost" and solo.time - began == pytest.approx(3.0, abs=0.06)
    assert distance(solo.vehicle.position, (0, 0, 1.5)) < 0.01


def test_it_sees_through_an_occlusion() -> None:
    """Hidden for a second, the thing is found again where it has gone on."""
    thing = ball((4, -2, 1.5), (4, 20, 1.5), speed=1.0)
    look = hidden(seen_of(thing), lambda _, time: 8.0 < time < 9.0)
    solo = tracking(look, {"target": BALL})
    solo.run(7.4)
    solo.run(1.6)
    at = pose_at(thing, solo.time)[0]
    assert distance(solo.activity.published.position, at) < 0.35
    solo.run(2.0)
    assert solo.activity.published.visible and solo.outcome is None


@pytest.mark.slow
def test_it_looks_where_the_thing_has_vanished() -> None:
    thing = ball((4, 0, 1.5), (4, -40, 1.5), speed=1.5)
    look = hidden(seen_of(thing), lambda _, time: time > 7.0)
    solo = tracking(look, {"target": BALL, "patience": 8.0})
    solo.run(7.0 - solo.time)
    yaw = solo.vehicle.yaw
    solo.run(4.0)
    assert wrap(solo.vehicle.yaw - yaw) < -0.8, "to the right"


@pytest.mark.slow
def test_a_look_alike_elsewhere_is_not_taken_for_it() -> None:
    decoy = replace(ball((5.5, -2.2, 1.5)), name="decoy")
    thing = ball((5, 0.3, 1.5), (5, 8, 1.5), speed=0.5)
    solo = tracking(seen_of(thing, decoy), {"target": BALL})
    solo.run(0.2)
    first = solo.activity.published.position
    solo.run(5.0)
    at = (decoy.at, pose_at(thing, solo.time)[0])[distance(first, decoy.at) > 1.5]
    assert distance(solo.activity.published.position, at) < 0.3


@pytest.mark.parametrize("align", [pytest.param(0.0, marks=pytest.mark.slow), -0.6])
def test_it_stays_before_the_face_of_a_marker(align: float) -> None:
    at = Point(4.0, 0.0, 1.5)
    marker = marker_of("4X4_50", 7, at, 0.4, standing(pi - 0.5))
    solo = tracking(seen_of(marker), {"target": MARKER, "distance": 2.0, "align": align})
    solo.run(12)
    side = pi - 0.5 + align
    there = at.plus((2.0 * cos(side), 2.0 * sin(side), 0.0))
    assert distance(solo.vehicle.position, there) < 0.15
    assert abs(wrap(solo.vehicle.yaw - side - pi)) < 0.06


def test_it_stays_above_a_moving_marker_and_turns_with_it() -> None:
    thing = lying(7, -1.2, 0.3, heading=-1.0, speed=0.8)
    values = {"target": MARKER, "camera": "ventral", "height": 2.5, "align": 0.0}
    solo = tracking(seen_of(thing), values, 3.0)
    solo.run(8)
    for _ in range(80):
        solo.step()
        at, here = pose_at(thing, solo.time)[0], solo.vehicle.position
        assert hypot(at.x - here.x, at.y - here.y) < 0.05
        assert here.z == pytest.approx(2.5, abs=0.05)
    assert wrap(solo.vehicle.yaw - (pi / 2 - 1.0)) == pytest.approx(0.0, abs=0.04)
    told = solo.activity.published
    assert told.distance < 0.05 and told.height == pytest.approx(2.5, abs=0.06)


def test_above_one_marker_the_nose_can_point_to_another() -> None:
    look = seen_of(lying(7, 0.2, 0.1), lying(3, -0.4, 0.7))
    values = {
        "target": MARKER,
        "camera": "ventral",
        "height": 3.0,
        "second": {"id": 3, "size": 0.4},
    }
    solo = tracking(look, values, 3.0)
    solo.run(8)
    assert solo.vehicle.position == pytest.approx((0.2, 0.1, 3.0), abs=0.04)
    assert wrap(solo.vehicle.yaw - 3 * pi / 4) == pytest.approx(0.0, abs=0.04)


def test_it_goes_on_where_it_was() -> None:
    look = seen_of(ball((4, -1, 1.5), (4, 20, 1.5)))
    solo = tracking(look, {"target": BALL})
    solo.run(4)
    progress = solo.activity.progress()
    assert json.loads(json.dumps(progress)) == progress
    solo.activity.stop()
    vehicle = solo.session, solo.vehicle
    again = Solo("track_object", {"target": BALL}, progress=progress, vehicle=vehicle)
    again.step()
    assert again.activity.published.velocity.y == pytest.approx(0.8, abs=0.3)


def pictures() -> dict[str, Callable[[Pixels], Pixels]]:
    noise = np.random.default_rng(1).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    return {
        "black": np.zeros_like,
        "white": lambda image: np.full_like(image, 255),
        "red": lambda image: np.full_like(image, (25, 25, 210)),
        "tiny": lambda image: np.ascontiguousarray(image[:16, :16]),
        "noise": lambda image: noise,
        "rotated": lambda image: np.ascontiguousarray(np.rot90(image)),
    }


@pytest.mark.parametrize(
    "kind",
    [k if k in ("black", "tiny") else pytest.param(k, marks=pytest.mark.slow) for k in pictures()],
)
def test_no_picture_makes_it_jump(kind: str) -> None:
    change, look = pictures()[kind], seen_of(ball((4, -1, 1.5), (4, 20, 1.5)))

    def changed(pose: Pose, time: float) -> Pixels | None:
        image = look(pose, time)
        return image if image is None or time % 1.0 < 0.5 else change(image)

    solo = tracking(changed, {"target": BALL})
    commanded = []
    for _ in range(160):
        setpoint = solo.step()
        assert isinstance(setpoint, Position) and setpoint.velocity is not None
        commanded.append(setpoint)
    for before, after in pairwise(commanded):
        assert before.velocity is not None and after.velocity is not None
        assert after.velocity.minus(before.velocity).norm() < 4.5 * PERIOD
        assert after.velocity.norm() < 3.1
        assert after.xyz.minus(before.xyz).norm() < 3.2 * PERIOD
        assert before.yaw is not None and after.yaw is not None
        assert abs(wrap(after.yaw - before.yaw)) <= 1.5 * PERIOD + 1e-9
    assert solo.word in (None, "lost")


@pytest.mark.parametrize(
    ("values", "parameter"),
    [
        ({"target": {"color": "red"}}, "target"),
        ({"target": {"id": 99, "size": 1.0}}, "target"),
        ({"target": MARKER, "second": {"size": 1.0}}, "second"),
    ],
)
def test_a_target_that_cannot_be_is_told_before_the_flight(
    values: dict[str, Any], parameter: str
) -> None:
    with pytest.raises(Unflyable) as error:
        TrackObject.plan(TrackObject.Params(**values), START)
    assert error.value.parameter == parameter
    failed = tracking(seen_of(), values)
    failed.step()
    assert failed.word == "failed"


def test_a_target_that_is_known_in_flight_only_may_be() -> None:
    for target in (UNKNOWN, {"color": UNKNOWN, "size": 0.4}, BALL):
        assert TrackObject.plan(TrackObject.Params(target=target), START) is None
