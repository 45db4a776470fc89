"""Tags in frames: where in the world."""

from __future__ import annotations

from math import radians

import pytest

from behaviors.perception.tags import Place, Tag, TagFinder
from hal.vehicle import Frame
from tests.behaviors.perception.frames import LENSES, front, seen_from, ventral
from vencejo.geometry import Point, Quaternion, distance, wrap
from worlds.loader import read_world


def frame_of(things: str, at: Point, attitude: Quaternion, lens: str = "plain") -> Frame:
    ground = "start: {at: [90, 90]}\nground: {color: concrete, size: 60 m}"
    return seen_from(
        read_world(f"world: w\n{ground}\n{things}\n", "w.yaml"), at, attitude, LENSES[lens]
    )


def only(frame: Frame, size: float | None, dictionary: str = "4X4_50") -> Tag:
    (tag,) = TagFinder(dictionary, size=size).find(frame)
    return tag


@pytest.mark.parametrize("lens", LENSES)
@pytest.mark.parametrize("size", [0.3, None])
@pytest.mark.parametrize(
    ("thing", "kind"),
    [
        ("roundels: {r: {at: [0.3, 0.2], size: 30 cm, heading: 40 deg}}", "roundel"),
        ("markers: {m: {at: [0.3, 0.2], id: 5, size: 30 cm, heading: -50 deg}}", "4X4_50"),
    ],
)
def test_what_lies_below_a_tilted_camera(
    thing: str, kind: str, size: float | None, lens: str
) -> None:
    attitude = ventral(tilt=0.15, roll=-0.1, yaw=0.5)
    tag = only(frame_of(thing, Point(0.4, 0.1, 1.6), attitude, lens), size)
    assert tag.kind == kind and tag.position is not None and tag.heading is not None
    assert distance(tag.position, (0.3, 0.2, 0)) < 0.06
    # The top of a marker of heading -50 degrees is at 40.
    assert abs(wrap(tag.heading - radians(40))) < radians(4)
    assert tag.distance == pytest.approx(1.606, abs=0.06)


def test_a_roundel_lies_also_before_a_camera_that_looks_ahead() -> None:
    thing = "roundels: {r: {at: [2, 0.3], size: 30 cm, heading: 40 deg}}"
    frame = frame_of(thing, Point(0, 0, 1.6), front(tilt=0.35))
    for size in (0.3, None):
        tag = only(frame, size)
        assert tag.position is not None and distance(tag.position, (2, 0.3, 0)) < 0.08
        assert tag.heading is not None and abs(wrap(tag.heading - radians(40))) < radians(6)


@pytest.mark.parametrize("turn", [0, 20, -45])
@pytest.mark.parametrize("lean", [0, 20, -20])
def test_a_marker_that_is_held_out_askew(turn: int, lean: int) -> None:
    thing = (
        "markers: {m: {at: [2.5, 0.3, 1.5], id: 3, size: 25 cm, "
        f"faces: 200 deg, lean: {lean} deg, turn: {turn} deg}}}}"
    )
    frame = frame_of(thing, Point(0, 0, 1.4), front())
    tag = only(frame, 0.25)
    assert tag.position is not None and distance(tag.position, (2.5, 0.3, 1.5)) < 0.08
    assert tag.angle == pytest.approx(-radians(turn), abs=radians(8))
    assert tag.heading is not None and abs(wrap(tag.heading - radians(200))) < radians(25)
    unsized = only(frame, None)
    assert (unsized.position, unsized.distance, unsized.heading) == (None, None, None)


def test_ground_that_is_higher_than_home() -> None:
    thing = "roundels: {r: {at: [0, 0, 0.5], size: 30 cm}}"
    frame = frame_of(thing, Point(0.3, 0, 2.0), ventral())
    (tag,) = TagFinder().find(frame, 0.5)
    assert tag.position is not None and distance(tag.position, (0, 0, 0.5)) < 0.02


def test_only_what_is_asked_for() -> None:
    roundel = "roundels: {r: {at: [0.4, 0], size: 20 cm}}"
    things = roundel + "\nmarkers: {m: {at: [-0.4, 0], id: 5, size: 20 cm}}"
    frame = frame_of(things, Point(0, 0, 2.0), ventral())
    for finder, kinds in (
        (TagFinder(), ["4X4_50", "roundel"]),
        (TagFinder(roundels=False), ["4X4_50"]),
        (TagFinder(ids=[]), ["roundel"]),
        (TagFinder(ids=[4]), ["roundel"]),
        (TagFinder("DICT_5X5_50", roundels=False), []),
    ):
        assert [tag.kind for tag in finder.find(frame)] == kinds


def test_a_place_is_counted_from_the_middle_to_the_left_and_up() -> None:
    frame = frame_of("", Point(0, 0, 2.0), ventral())
    assert Place.of(frame, (159.5, 119.5)) == Place(0, 0, 0)
    assert Place.of(frame, (0, 239)) == Place(1, -1, pytest.approx(199.3, abs=0.1))
