"""detect_tags, on rendered pictures without physics."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import degrees, pi, radians
from typing import Any

import numpy as np
import pytest

from behaviors.detect_tags import Tags
from hal.scene.arrays import Pixels
from tests.behaviors.flying import Solo
from tests.behaviors.sighted import CAMERAS, Look, shown, sighted
from vencejo.geometry import Point, Pose, about_y, distance
from worlds.loader import read_world

ROW = (
    "markers:\n  a: {at: [2, 0.3], id: 3, size: 30 cm}\n"
    "  b: {at: [4, -0.2], id: 7, size: 30 cm, heading: 40 deg}\n"
)
UPRIGHT = "markers: {a: {at: [4, 0.5, 3.2], id: 9, size: 30 cm, faces: 180 deg}}\n"
PAIR = (
    "roundels:\n  a: {at: [2, 0], size: 30 cm, heading: 90 deg}\n"
    "  b: {at: [4, 0], size: 30 cm, heading: 180 deg}\n"
)


def world_look(text: str) -> Look:
    start = "world: w\nstart: {at: [90, 90]}\nground: {color: concrete, size: 90 m}\n"
    return shown(read_world(start + text, "w.yaml"))


class Watcher:
    """detect_tags at work on a vehicle that a test moves."""

    def __init__(self, look: Look, height: float = 1.5, **values: Any) -> None:
        self.look = look
        self.covered = False
        session, self.vehicle = sighted(self._look, height)
        self.solo = Solo(
            "detect_tags", {"camera": "ventral", **values}, vehicle=(session, self.vehicle)
        )

    def _look(self, pose: Pose, time: float) -> Pixels | None:
        image = self.look(pose, time)
        return np.zeros_like(image) if self.covered and image is not None else image

    def at(self, x: float, y: float = 0.0, z: float = 1.5, periods: int = 2) -> Tags:
        """Let it look from a place for so many periods; what it publishes then."""
        self.vehicle.position = Point(x, y, z)
        for _ in range(periods):
            self.solo.step()
        published: Tags = self.solo.activity.published
        return published

    def fly(self, begin: float, end: float, speed: float = 1.0) -> None:
        """Look while moving along x."""
        steps = round(abs(end - begin) / speed / 0.025)
        for k in range(steps + 1):
            self.at(begin + (end - begin) * k / steps, periods=1)

    @property
    def seen(self) -> list[Mapping[str, Any]]:
        return [fields for name, fields in self.solo.events if name == "tag.seen"]


def test_what_is_published_of_a_tag_below() -> None:
    watcher = Watcher(world_look(ROW))
    tags = watcher.at(1.9, periods=8)
    assert (tags.count, tags.visible, tags.ids, tags.id, tags.kind) == (1, True, [3], 3, "4X4_50")
    # 30 cm to the left and 10 cm ahead, from 1.46 m above, at 277 pixels a radian.
    assert tags.offset_x * 159.5 == pytest.approx(277 * 0.3 / 1.46, abs=1.0)
    assert tags.offset_y * 119.5 == pytest.approx(277 * 0.1 / 1.46, abs=1.0)
    assert tags.radius == pytest.approx(277 * 0.1**0.5 / 1.46, abs=1.0)
    assert tags.nearest is not None and distance(tags.nearest, (2, 0.3, 0)) < 0.02
    assert tags.distance == pytest.approx((0.1 + 1.46**2) ** 0.5, abs=0.02)
    # Its top is north, which is to the left.
    assert tags.angle == pytest.approx(pi / 2, abs=0.02) and not tags.oriented
    assert tags.heading == pytest.approx(pi / 2, abs=0.02)
    assert not tags.centered and watcher.at(1.9, 0.2, periods=2).centered


def test_with_its_size_a_tag_is_placed_anywhere() -> None:
    watcher = Watcher(world_look(UPRIGHT), 3.0, camera="front", size=0.3)
    tags = watcher.at(0, 0, 3, periods=8)
    assert tags.nearest is not None and distance(tags.nearest, (4, 0.5, 3.2)) < 0.08
    assert tags.distance == pytest.approx(3.84, abs=0.08)
    assert tags.offset_x > 0 and tags.offset_y > 0
    assert abs(tags.angle) < 0.05 and tags.oriented
    assert tags.heading is not None and abs(abs(tags.heading) - pi) < 0.3
    unsized = Watcher(world_look(UPRIGHT), 3.0, camera="front").at(0, 0, 3, periods=8)
    assert (unsized.visible, unsized.nearest, unsized.distance) == (True, None, None)


def test_a_tag_comes_into_view_and_passes_nearest_to_the_middle() -> None:
    watcher = Watcher(world_look(ROW))
    watcher.fly(0.5, 3.2)
    first, nearest = watcher.seen
    assert (first["id"], nearest["id"]) == (3, 3)
    assert first["radius"] > 90 and not first["centered"]
    # 30 cm beside the middle of its way.
    assert nearest["radius"] == pytest.approx(277 * 0.3 / 1.46, abs=2)
    assert distance(nearest["position"], (2, 0.3, 0)) < 0.02
    watcher.fly(3.2, 6)
    assert [seen["id"] for seen in watcher.seen] == [3, 3, 7, 7]


def test_a_tag_that_it_hovers_above_is_seen_once() -> None:
    watcher = Watcher(world_look(ROW))
    watcher.at(2.0, 0.2, periods=80)
    assert len(watcher.seen) == 1
    # Away and back is a new approach.
    for y in (0.0, -0.2, -0.3, -0.2, 0.0, 0.2, 0.2):
        watcher.at(2.0, y, periods=16)
    assert len(watcher.seen) == 2
    # Out of sight and back is a new sighting.
    watcher.at(-3.0, periods=20)
    watcher.at(2.0, 0.2, periods=8)
    assert len(watcher.seen) == 3


def test_a_short_loss_does_not_show_and_a_long_one_does() -> None:
    watcher = Watcher(world_look(ROW))
    assert not watcher.at(2.0, periods=2).visible, "one picture is not enough"
    assert watcher.at(2.0, periods=6).visible
    watcher.covered = True
    assert watcher.at(2.0, periods=6).visible
    lost = watcher.at(2.0, periods=8)
    assert (lost.visible, lost.count, lost.ids) == (False, 0, [])
    assert lost.id == 3 and lost.nearest is not None, "where it was stays known"
    watcher.covered = False
    watcher.at(2.0, periods=8)
    assert len(watcher.seen) == 2


def test_while_it_is_missed_it_is_expected_where_it_moves() -> None:
    watcher = Watcher(world_look(ROW))
    watcher.fly(1.0, 1.8)
    before = watcher.at(1.8, periods=1)
    watcher.covered = True
    watcher.fly(1.8, 2.0)
    after = watcher.solo.activity.published
    assert after.visible
    # The last pictures before and after were taken up to 50 ms before those moments.
    moved = (before.offset_y - after.offset_y) * 119.5
    assert 277 * 0.15 / 1.46 - 2 < moved < 277 * 0.2 / 1.46 + 2


def test_it_keeps_to_one_of_several_as_the_nearest() -> None:
    side_by_side = (
        "markers:\n  a: {at: [2, 0.3], id: 3, size: 20 cm}\n"
        "  b: {at: [2, -0.3], id: 7, size: 20 cm}\n"
    )
    watcher = Watcher(world_look(side_by_side))
    assert watcher.at(2, 0.05, periods=8).id == 3
    assert watcher.at(2, -0.01, periods=2).id == 3
    tags = watcher.at(2, -0.1, periods=2)
    assert (tags.id, tags.ids, tags.count) == (7, [3, 7], 2)


def test_equal_markers_are_told_apart_by_their_places() -> None:
    equal = (
        "markers:\n  a: {at: [2, 0.3], id: 3, size: 20 cm}\n"
        "  b: {at: [2, -0.3], id: 3, size: 20 cm}\n"
    )
    watcher = Watcher(world_look(equal))
    tags = watcher.at(2, 0.0, periods=12)
    assert (tags.count, tags.ids) == (2, [3, 3])
    assert len(watcher.seen) == 2


def test_roundels_have_numbers_that_they_keep() -> None:
    watcher = Watcher(world_look(PAIR), size=0.3)
    tags = watcher.at(2, 0, periods=8)
    assert (tags.id, tags.kind) == (1, "roundel")
    assert degrees(tags.angle) == pytest.approx(90, abs=2)
    assert tags.heading == pytest.approx(pi / 2, abs=0.03)
    watcher.fly(2, 4)
    assert watcher.at(4, 0, periods=8).id == 2
    watcher.fly(4, 2)
    assert watcher.at(2, 0, periods=8).id == 1
    assert not Watcher(world_look(PAIR), roundels=False).at(2, periods=8).visible


def test_interrupted_it_knows_the_roundels_numbers() -> None:
    watcher = Watcher(world_look(PAIR), size=0.3)
    watcher.at(2, 0, periods=8)
    watcher.fly(2, 4)
    progress = json.loads(json.dumps(watcher.solo.activity.progress()))
    watcher.solo.activity.stop()
    given, vehicle = {"camera": "ventral", "size": 0.3}, (watcher.solo.session, watcher.vehicle)
    again = Solo("detect_tags", given, progress=progress, vehicle=vehicle)
    for _ in range(8):
        again.step()
    assert again.activity.published.id == 2


def test_only_the_ids_that_it_is_told() -> None:
    assert Watcher(world_look(ROW), ids=[7, 8]).at(2.0, periods=8).count == 0
    assert Watcher(world_look(ROW), ids=[3]).at(2.0, periods=8).ids == [3]
    assert Watcher(world_look(ROW), ids=[]).at(2.0, periods=8).count == 0


def test_pictures_of_a_tilted_vehicle_are_ignored_if_asked() -> None:
    watcher = Watcher(world_look(ROW), roll_pitch_thr=radians(5))
    assert watcher.at(2.0, periods=8).visible
    level, down = watcher.vehicle.observe, about_y(radians(10))
    watcher.vehicle.observe = lambda: level()._replace(attitude=down)  # type: ignore[method-assign]
    watcher.covered = True
    assert watcher.at(2.0, periods=20).visible, "what was seen before still counts"
    assert not watcher.at(2.0, periods=40).visible, "… but not for ever"


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"ids": [50]}, "4X4_50 has the markers 0 to 49, not 50"),
        ({"ids": ["a"]}, "the ids of markers are whole numbers"),
        ({"needed": 4, "of": 3}, "needed (4) is above of (3)"),
        ({"camera": "rear"}, "rear"),
    ],
)
def test_what_cannot_be_looked_for(values: dict[str, Any], told: str) -> None:
    watcher = Watcher(world_look(ROW), **values)
    watcher.solo.step()
    outcome = watcher.solo.outcome
    assert outcome is not None and outcome.word == "failed"
    assert told in outcome.fields["reason"]


@pytest.mark.parametrize("shape", [(240, 320, 3), (16, 16, 3)])
@pytest.mark.parametrize("grey", [0, 127, 255])
def test_pictures_of_one_colour_show_nothing(shape: tuple[int, ...], grey: int) -> None:
    watcher = Watcher(lambda pose, time: np.full(shape, grey, np.uint8))
    assert not watcher.at(0, periods=40).visible
    assert watcher.solo.outcome is None and watcher.solo.events == []


def test_what_it_sees_is_drawn_when_somebody_looks() -> None:
    watcher = Watcher(world_look(ROW))
    drawn: list[tuple[str, Pixels]] = []
    watcher.solo.channel.on_picture = lambda name, draw: drawn.append((name, draw()))
    watcher.at(2.0, 0.3, periods=8)
    green, blue = (60, 210, 60), (240, 120, 30)
    assert {name for name, _ in drawn} == {"detect_tags"}
    near = drawn[-1][1]
    assert (near == green).all(-1).any() and not (near == blue).all(-1).any()
    watcher.at(2.4, 0.3, periods=4)
    assert (drawn[-1][1] == blue).all(-1).any(), "a circle of another colour off the middle"
    before = len(drawn)
    watcher.covered = True
    watcher.at(2.4, 0.3, periods=40)
    assert len(drawn) > before and not drawn[-1][1].any()


def test_before_the_first_picture_there_is_nothing() -> None:
    watcher = Watcher(lambda pose, time: None)
    assert watcher.at(0, periods=40) == Tags()
    assert CAMERAS.keys() == {"front", "ventral"}
