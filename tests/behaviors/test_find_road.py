"""find_road and watch_traffic on a vehicle without physics."""

from __future__ import annotations

import numpy as np
import pytest

from behaviors.find_road import RoadInPicture
from behaviors.watch_traffic import Traffic
from tests.behaviors.flying import Solo
from tests.behaviors.sighted import CAMERAS, Look, shown, sighted
from worlds.loader import read_world
from worlds.world import World

ROAD = (
    "world: r\nground: {color: grass}\n"
    "roads: {main: {through: [[-9, 0.5], [9, 0.5]], width: 1 m}}\n"
)


def world(more: str = "") -> World:
    return read_world(ROAD + more, "r.yaml")


def looked(
    name: str, look: Look, seconds: float = 0.2, height: float = 4.0, **values: object
) -> Solo:
    solo = Solo(name, values, vehicle=sighted(look, height))
    solo.run(seconds)
    return solo


def test_a_road_left_of_the_middle_is_left_in_the_picture() -> None:
    seen: RoadInPicture = looked("find_road", shown(world())).activity.published
    focal = CAMERAS["ventral"].intrinsics.fx
    assert seen.visible and seen.frames >= 3
    assert seen.x == pytest.approx(-0.5 / 3.96 * focal, abs=2)
    assert (seen.upper, seen.lower, seen.middle_at_edge) == (1, 1, False)
    assert seen.y == pytest.approx(119.5 - 50, abs=0.1)
    assert seen.angle < 0


@pytest.mark.parametrize("value", [0, 255, 72])
def test_one_colour_is_all_road_or_none(value: int) -> None:
    image = np.full((240, 320, 3), value, np.uint8)
    seen = looked("find_road", lambda pose, time: image).activity.published
    assert seen.visible == (value == 72)


def test_small_pictures_are_no_fault() -> None:
    for name in ("find_road", "watch_traffic"):
        solo = looked(name, lambda pose, time: np.full((16, 16, 3), 70, np.uint8))
        assert solo.outcome is None


def test_it_commands_nothing_and_tells_a_wrong_colour() -> None:
    solo = looked("find_road", shown(world()))
    assert solo.channel.setpoint is None
    solo = looked("find_road", shown(world()), color="asphlat")
    assert solo.word == "failed"


def test_the_speed_of_a_car_is_measured_from_above() -> None:
    moving = "cars: {c: {color: red, moves: {through: [[-30, 3], [30, 3]], speed: 5 m/s}}}\n"
    text = world(moving)
    # It passes below, on its way back, after 18 s.
    solo = Solo("watch_traffic", {}, vehicle=sighted(shown(text), 12.0))
    solo.run(19 - solo.time)
    (event,) = [fields for name, fields in solo.events if name == "car.seen"]
    assert event["speed"] == pytest.approx(5.0, rel=0.05)
    assert abs(event["heading"]) > 3.1 and event["color"] == "red"
    assert event["position"].y == pytest.approx(3, abs=0.3)
    published: Traffic = solo.activity.published
    assert published.seen == 1
