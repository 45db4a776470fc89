"""Oriented roundels in images."""

from __future__ import annotations

from math import degrees, pi, radians

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors.perception.projection import ground_points, pixels_of
from behaviors.perception.roundel import Roundel, roundels
from hal.scene.arrays import Pixels
from hal.vehicle import Frame
from tests.behaviors.perception.frames import LENSES, seen_from, ventral
from vencejo.geometry import Point, Quaternion, bearing, distance, wrap
from worlds.loader import read_world
from worlds.world import World

SIZE = 0.3


def yard(text: str = "", heading: float = 0.0, ground: str = "grass") -> World:
    """A roundel in the origin, and other things."""
    roundel = f"roundels: {{r: {{at: [0, 0], size: {SIZE} m, heading: {degrees(heading)} deg}}}}"
    under = f"start: {{at: [9, 9]}}\nground: {{color: {ground}, size: 60 m}}"
    return read_world(f"world: w\n{under}\n{roundel}\n{text}", "w.yaml")


def only(image: Pixels) -> Roundel:
    (seen,) = roundels(image)
    return seen


def heading_of(frame: Frame, seen: Roundel) -> float:
    """The direction in which it points over the ground."""
    ahead = (seen.x + seen.ahead[0], seen.y + seen.ahead[1])
    centre, rim = ground_points(frame, [(seen.x, seen.y), ahead])
    return bearing(tuple(centre), tuple(rim))


def seen_at(world: World, height: float, attitude: Quaternion, lens: str) -> Frame:
    """The frame of a camera at that height that has the roundel a little off the middle."""
    middle = seen_from(world, Point(0, 0, height), attitude)
    x, y, _ = ground_points(middle, [(185, 105)])[0].tolist()
    return seen_from(world, Point(-x, -y, height), attitude, LENSES[lens])


@pytest.mark.parametrize("lens", LENSES)
@pytest.mark.parametrize(
    ("ground", "height", "attitude", "heading"),
    [
        ("grass", 0.7, ventral(), 0.0),
        ("concrete", 1.0, ventral(tilt=-0.2, yaw=-2.0), -0.5),
        ("black", 1.5, ventral(yaw=2.0), radians(100)),
        ("asphalt", 2.0, ventral(tilt=0.3, roll=-0.2, yaw=-1.0), pi),
        ("white", 3.0, ventral(yaw=0.7), 1.0),
    ],
)
def test_centre_size_and_direction(
    lens: str, ground: str, height: float, attitude: Quaternion, heading: float
) -> None:
    frame = seen_at(yard(heading=heading, ground=ground), height, attitude, lens)
    seen = only(frame.image)
    [pixel] = pixels_of(frame, [(0, 0, 0)])
    assert (seen.x, seen.y) == pytest.approx(pixel, abs=2.0)
    assert abs(wrap(heading_of(frame, seen) - heading)) < radians(4)
    if lens != "distorted":
        expected = frame.intrinsics.fx * SIZE / distance(frame.position, (0, 0, 0))
        assert seen.diameter == pytest.approx(expected, rel=0.06)


def test_its_angle_grows_clockwise_from_the_line_at_the_right() -> None:
    straight = seen_from(yard(), Point(0, 0, 1.5), ventral()).image
    assert abs(only(straight).angle) < radians(1)
    for quarters in (1, 2, 3):
        turned = np.ascontiguousarray(np.rot90(straight, -quarters))
        assert abs(wrap(only(turned).angle - quarters * pi / 2)) < radians(1)
    # A vehicle that has turned to the left sees it turned to the right.
    frame = seen_from(yard(), Point(0, 0, 1.5), ventral(yaw=radians(30)))
    assert only(frame.image).angle == pytest.approx(radians(30), abs=radians(1))


def test_its_corners_are_those_of_a_square_in_the_disc() -> None:
    frame = seen_from(yard(), Point(0, 0, 1), ventral(yaw=pi / 2))
    corners = ground_points(frame, only(frame.image).corners)
    side = SIZE / 2**0.5 / 2
    # It points east, so that its upper left corner is in the north-east.
    expected = [(side, side, 0), (side, -side, 0), (-side, -side, 0), (-side, side, 0)]
    assert corners == pytest.approx(np.array(expected), abs=0.01)


def test_speckles_of_a_tenth_of_the_pixels() -> None:
    frame = seen_from(yard(), Point(0, 0, 1.0), ventral(yaw=1.0))
    image, draw = frame.image.copy(), np.random.default_rng(1)
    chance = draw.random(image.shape[:2])
    image[chance < 0.05] = 0
    image[chance > 0.95] = 255
    seen = only(image)
    assert (seen.x, seen.y) == pytest.approx((159.5, 119.5), abs=1)
    assert seen.angle == pytest.approx(1.0, abs=radians(3))


def test_a_line_that_the_border_cuts_still_tells_the_direction() -> None:
    frame = seen_from(yard(), Point(0, 0, 0.7), ventral())
    seen = only(frame.image)
    low = np.ascontiguousarray(frame.image[: round(seen.y + 0.52 * seen.diameter)])
    assert abs(wrap(only(low).angle - seen.angle)) < radians(3)


@pytest.mark.parametrize(
    "others",
    [
        "markers: {m: {at: [0.8, 0], id: 3, size: 30 cm}}",
        "spheres: {s: {at: [0.7, 0.3], radius: 20 cm, color: black}}",
        "boxes: {b: {at: [0.7, 0], size: [0.2, 0.5, 0.1], color: black}}",
        "cylinders: {c: {at: [-0.7, 0], radius: 15 cm, height: 10 cm, color: black}}",
        "roads: {way: {through: [[-9, 1], [9, 1]], width: 50 cm, edges: white}}",
    ],
)
def test_only_roundels_are_found(others: str) -> None:
    frame = seen_from(yard(others), Point(0, 0, 2), ventral())
    assert (only(frame.image).x, only(frame.image).y) == pytest.approx((159.5, 119.5), abs=1)


def test_several_the_largest_first() -> None:
    second = "  s: {at: [0.9, 0.1], size: 20 cm, heading: 90 deg}"
    text = "world: w\nstart: {at: [9, 9]}\nroundels:\n  r: {at: [0, 0], size: 30 cm}\n"
    frame = seen_from(read_world(text + second, "w.yaml"), Point(0.4, 0, 2), ventral())
    large, small = roundels(frame.image)
    assert large.diameter > 1.3 * small.diameter
    assert large.angle == pytest.approx(0, abs=0.05)
    assert small.angle == pytest.approx(-pi / 2, abs=0.05)


def drawn(hole: tuple[int, int] | None = (18, 45), line: int | None = 63) -> Pixels:
    """A roundel with a disc of 90 pixels, or a part of one."""
    image = np.full((240, 320), 230, np.uint8)
    cv2.circle(image, (160, 120), 45, 20, cv2.FILLED)
    if hole:
        width, height = hole
        image[120 - height // 2 : 120 + height // 2, 160 - width // 2 : 160 + width // 2] = 230
    if line:
        image[66:174, 160 + line - 6 : 160 + line + 6] = 20
    return image


@pytest.mark.parametrize(
    "parts",
    [
        {"hole": None},
        {"line": None},
        {"hole": (40, 60)},
        {"line": 90},
        {"line": 50},
    ],
)
def test_what_lacks_a_part_is_none(parts: dict[str, tuple[int, int] | int | None]) -> None:
    assert roundels(drawn())
    assert roundels(drawn(**parts)) == []  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", [(240, 320, 3), (16, 16, 3), (16, 16), (1, 1, 3), (240, 3, 3)])
@pytest.mark.parametrize("grey", [0, 90, 255])
def test_pictures_of_one_colour_show_none(shape: tuple[int, ...], grey: int) -> None:
    assert roundels(np.full(shape, grey, np.uint8)) == []


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.integers(1, 60), st.floats(0, 6))
def test_noise_never_breaks_it(seed: int, height: int, width: int, blur: float) -> None:
    image = np.random.default_rng(seed).integers(0, 256, (height, width, 3), np.uint8)
    roundels(np.asarray(cv2.GaussianBlur(image, (0, 0), blur + 0.01), np.uint8))
