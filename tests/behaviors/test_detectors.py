"""The built-in detectors on rendered pictures with known truth, and what a mission may name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from math import cos, dist, pi, sin
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
import pytest

from behaviors import Sighting
from behaviors.detector import OwnDetector, describe_detector, detector
from behaviors.detectors import read_detectors
from behaviors.perception import ground_points
from behaviors.plan import Unflyable
from hal.raster import Raster
from hal.scene.arrays import Pixels
from hal.vehicle import Frame, Intrinsics
from vencejo.geometry import OPTICAL, Point, about_x, about_y, product, yaw_quaternion
from worlds import World, load_world

LENS = Intrinsics.from_field_of_view(320, 240, pi / 3)
WORLD = """\
world: yardstick
start: {at: [30, 30]}
people:
  lying: {at: [0, 0], heading: 20 deg, color: orange, lying: true}
  fallen: {at: [1.6, 1.6], heading: 120 deg, color: red, lying: true}
  upright: {at: [-1.4, 1.4], color: blue}
spheres:
  ball: {at: [0.5, -1.7], radius: 30 cm, color: orange}
markers:
  seven: {at: [-1.2, -1.3], id: 7, size: 50 cm, heading: 40 deg}
boxes:
  mat: {at: [-6, 0], size: [1.75, 0.5, 0.1], heading: 30 deg, color: orange}
  crate: {at: [-6, 2], size: [0.55, 0.55, 0.55], heading: 20 deg, color: orange}
  chest: {at: [-6, -2], size: [1.2, 0.7, 0.6], color: red}
  post: {at: [-8, 1], size: [0.4, 0.4, 1.7], color: blue}
"""
TRUE = {
    "person": [(0.0, 0.0), (1.6, 1.6), (-1.4, 1.4)],
    "ball": [(0.5, -1.7)],
    "marker": [(-1.2, -1.3)],
}
DETECT = [
    "people",
    {"color": {"color": "orange", "size": 0.6, "shape": "round", "kind": "ball"}},
    {"fiducials": {"ids": [3, 7]}},
]


@cache
def world() -> World:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "yardstick.yaml"
        path.write_text(WORLD)
        return load_world(path)


def frame_from(at: Point, *, yaw: float = 0.0, roll: float = 0.0, lens: Intrinsics = LENS) -> Frame:
    """What a camera that looks down sees, its upper edge to the front."""
    down = product(product(yaw_quaternion(yaw), about_y(pi / 2)), OPTICAL)
    attitude = product(
        product(yaw_quaternion(yaw), about_x(roll)), product(yaw_quaternion(-yaw), down)
    )
    image = Raster(world(), {}, False).render((at, attitude), lens, 0.0, {})
    return Frame(image, 0, 0.0, lens, at, attitude)


def seen(frame: Frame, detect: Any = DETECT) -> list[tuple[str, tuple[float, float]]]:
    """Kind and place of all that the detectors see."""
    found = [each for run in read_detectors(detect, {}) for each in run(frame, 0.0)]
    return [
        (each.kind, tuple(ground_points(frame, [each.pixel], each.height)[0][:2])) for each in found
    ]


def assert_true(found: list[tuple[str, tuple[float, float]]], within: float) -> None:
    """Each thing is seen once, where it is, and nothing else."""
    for kind, places in TRUE.items():
        left = [place for name, place in found if name == kind]
        assert len(left) == len(places), (kind, left)
        for place in places:
            assert min(dist(place, other) for other in left) < within, (kind, left)


@pytest.mark.parametrize(
    ("at", "yaw", "roll"),
    [
        (Point(0, 0, 6), 0.0, 0.0),
        (Point(0.4, -0.3, 8), 2.0, 0.0),
        (Point(0, 0.9, 8), 0.0, 0.12),
        (Point(-0.2, 0.1, 8), 0.7, 0.0),
    ],
)
def test_each_thing_is_seen_where_it_is(at: Point, yaw: float, roll: float) -> None:
    assert_true(seen(frame_from(at, yaw=yaw, roll=roll)), 0.15)


@pytest.mark.parametrize("aside", [2.2, 2.35, 2.5, 2.65])
def test_somebody_cut_by_the_edge_is_nowhere_else(aside: float) -> None:
    """The trunk of who lies at the origin leaves the picture at its lower edge."""
    found = seen(frame_from(Point(aside * cos(0.35), aside * sin(0.35), 6), yaw=0.35), ["people"])
    assert all(dist(place, (0.0, 0.0)) < 0.3 for _, place in found if dist(place, (0, 0)) < 1.2)


def noisy(image: Pixels) -> Pixels:
    rng = np.random.default_rng(1)
    blurred = cv2.GaussianBlur(image, (3, 3), 0).astype(np.float64)
    return np.clip(blurred + rng.normal(0, 6, image.shape), 0, 255).astype(np.uint8)


def salted(image: Pixels) -> Pixels:
    rng = np.random.default_rng(2)
    image = image.copy()
    image[rng.random(image.shape[:2]) < 0.02] = 255
    return image


@pytest.mark.parametrize("spoilt", [noisy, salted])
def test_noise_and_blur_hide_nothing(spoilt: Any) -> None:
    frame = frame_from(Point(0, 0, 6))
    people_and_balls = seen(replace(frame, image=spoilt(frame.image)), DETECT[:2])
    markers = seen(replace(frame, image=noisy(frame.image)), DETECT[2:])
    assert_true([*people_and_balls, *markers], 0.2)


def test_a_lens_that_distorts_moves_nothing() -> None:
    bent = Intrinsics(320, 240, LENS.fx, LENS.fy, LENS.cx, LENS.cy, (-0.15, 0.03, 0.0, 0.0, 0.0))
    straight = frame_from(Point(0, 0, 6))
    from hal.scene.distortion import rays_of

    pixels = np.stack(np.meshgrid(np.arange(320), np.arange(240)), -1).reshape(-1, 2)
    rays = rays_of(pixels.astype(np.float64), bent)
    maps = (rays * LENS.fx + (LENS.cx, LENS.cy)).reshape(240, 320, 2).astype(np.float32)
    image = cv2.remap(straight.image, maps, None, cv2.INTER_LINEAR)
    frame = Frame(np.asarray(image), 0, 0.0, bent, straight.position, straight.attitude)
    assert_true(seen(frame), 0.15)


@pytest.mark.parametrize("at", [Point(-6, 0, 6), Point(-7, 0.5, 7), Point(-5.2, 0.8, 6)])
def test_things_of_the_same_colours_are_not_taken_for_them(at: Point) -> None:
    assert [kind for kind, _ in seen(frame_from(at)) if kind != "marker"] == []


@pytest.mark.parametrize("size", [(240, 320), (16, 16), (1, 1)])
@pytest.mark.parametrize("value", [0, 255, (20, 130, 245), (150, 180, 225)])
def test_blank_pictures_show_nothing(size: tuple[int, int], value: Any) -> None:
    image = np.empty((*size, 3), np.uint8)
    image[:] = value
    lens = Intrinsics.from_field_of_view(size[1], size[0], pi / 3)
    down = product(about_y(pi / 2), OPTICAL)
    for at, attitude in (
        (Point(0, 0, 6), down),
        (Point(0, 0, 6), OPTICAL),
        (Point(0, 0, -1), down),
    ):
        assert seen(Frame(image, 0, 0.0, lens, at, attitude)) == []


def test_noise_alone_shows_nothing() -> None:
    rng = np.random.default_rng(3)
    image = rng.integers(0, 256, (240, 320, 3)).astype(np.uint8)
    down = product(about_y(pi / 2), OPTICAL)
    assert seen(Frame(image, 0, 0.0, LENS, Point(0, 0, 6), down)) == []


@pytest.mark.parametrize(
    ("given", "message", "hint"),
    [
        ([], "one or more", "such as"),
        ("people", "one or more", ""),
        (["peple"], "no detector 'peple'", "did you mean 'people'?"),
        ([{"people": {}, "color": {}}], "names no detector", "such as"),
        ([{"color": "orange"}], "names no detector", "such as"),
        ([{"people": {"sort": "a"}}], "no setting 'sort'", ""),
        ([{"color": {"colour": "orange"}}], "no setting 'colour'", "did you mean 'color'?"),
        ([{"color": {"color": "orange"}}], "needs 'size'", ""),
        ([{"color": {"color": "orang", "size": 1}}], "no colour 'orang'", ""),
        ([{"color": {"color": "red", "size": 0}}], "above 0", ""),
        ([{"color": {"color": "red", "size": 1, "shape": "oval"}}], "any or round", ""),
        ([{"fiducials": {"dictionary": "4X4"}}], "no marker dictionary", ""),
        ([{"fiducials": {"ids": [50]}}], "0 to 49", ""),
        ([{"fiducials": {"ids": 3}}], "is a list of whole numbers", ""),
        ([{"fiducials": {"ids": [1.5]}}], "whole numbers, not 1.5", ""),
        ([{"fiducials": {"ids": ["3", 4]}}], "whole numbers, not '3'", ""),
        ([{"fiducials": {"parameters": 3}}], "is a map of names", ""),
        ([{"fiducials": {"kind": "../../up"}}], "the kind of a thing is a word", ""),
        ([{"people": {"kind": ""}}], "the kind of a thing is a word", ""),
        ([{"color": {"color": "red", "size": 1, "kind": "a/b"}}], "the kind of a thing", ""),
        ([{"find": {"least": 3}}], "needs 'color'", ""),
        ([{"find": {"lest": 3}}], "no setting 'lest'", "did you mean 'least'?"),
        ([{"find": {"color": "red", "least": "much"}}], "much is not a number", ""),
        ([3], "names no detector", ""),
    ],
)
def test_what_is_no_detector_is_told(given: Any, message: str, hint: str) -> None:
    def find(frame: Frame, ground: float, color: str, least: float = 3.0) -> list[Sighting]:
        return []

    own = {"find": describe_detector(find)}
    with pytest.raises(Unflyable, match=message) as raised:
        read_detectors(given, own)
    assert raised.value.parameter == "detect" and raised.value.hint.startswith(hint)


@pytest.mark.parametrize(
    ("kind", "id_"),
    [("../up", ""), ("", ""), ("a b", ""), (None, ""), ("k" * 33, ""), ("k", "7/8"), ("k", 7)],
)
def test_a_thing_has_a_name_that_its_photo_can_have(kind: Any, id_: Any) -> None:
    with pytest.raises(ValueError, match="of a thing is a word"):
        Sighting(kind, (1.0, 2.0), 0.0, id_)


def test_a_detector_of_ones_own_is_given_frame_ground_and_settings() -> None:
    @detector
    def find(frame: Frame, ground: float, least: float = 3.0) -> list[Sighting]:
        return [Sighting("thing", (least, ground), 1.0)]

    own = describe_detector(find)
    frame = frame_from(Point(0, 0, 6))
    (run,) = read_detectors(["find"], {"find": own})
    assert run(frame, 2.0) == [Sighting("thing", (3.0, 2.0), 1.0)]
    (run,) = read_detectors([{"find": {"least": 5}}], {"find": own})
    assert run(frame, 2.0) == [Sighting("thing", (5.0, 2.0), 1.0)]
    # Taken on trust, it finds nothing, and takes any settings.
    (run,) = read_detectors([{"find": {"more": 5}}], {"find": OwnDetector("find")})
    assert run(frame, 2.0) == []


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ([(1, 2)], TypeError, "no Sighting"),
        (None, TypeError, "gave None, which is no list of Sighting"),
        ([Sighting("a", (1.0, 2.0, 3.0))], ValueError, "no finite pixel"),  # type: ignore[arg-type]
        ([Sighting("a", "ab")], ValueError, "no finite pixel"),  # type: ignore[arg-type]
        ([Sighting("a", (1.0, 2.0), None)], ValueError, "no finite pixel"),  # type: ignore[arg-type]
        ([Sighting("a", (float("nan"), 1.0))], ValueError, "no finite pixel"),
    ],
)
def test_what_it_gives_is_looked_at(given: Any, error: type[Exception], message: str) -> None:
    own: Mapping[str, OwnDetector] = {"find": OwnDetector("find", lambda frame, ground: given)}
    (run,) = read_detectors(["find"], own)
    with pytest.raises(error, match=message):
        run(frame_from(Point(0, 0, 6)), 0.0)


def test_a_function_that_cannot_be_called_so_is_no_detector() -> None:
    def alone(frame: Frame) -> list[Sighting]:
        return []

    async def later(frame: Frame, ground: float) -> list[Sighting]:
        return []

    with pytest.raises(TypeError, match=r"write `def alone\(frame, ground\)"):
        describe_detector(alone)
    with pytest.raises(TypeError, match="not `async`"):
        describe_detector(later)
