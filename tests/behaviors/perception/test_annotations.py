"""What is drawn on images, pixel by pixel where it matters."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, pi

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from behaviors.perception import Blob, annotations, blobs, pixels_of
from behaviors.perception.annotations import BLUE, GREEN, RED, YELLOW, Color
from hal.scene.arrays import Pixels
from hal.vehicle import Frame, Intrinsics
from tests.behaviors.perception.frames import frame_of, front, ventral
from vencejo.geometry import Point, yaw_quaternion

GREY = np.full((240, 320, 3), 90, np.uint8)
DISTORTED = Intrinsics.from_field_of_view(320, 240, pi / 3, (-0.28, 0.09, 0.0, 0.0, 0.0))


def is_drawn(image: Pixels, pixel: tuple[float, float], color: Color) -> bool:
    """Whether a pixel, or one beside it, has that colour on the grey, half covered or more."""
    x, y = round(pixel[0]), round(pixel[1])
    change = image[max(0, y - 1) : y + 2, max(0, x - 1) : x + 2].reshape(-1, 3) - 90.0
    whole = np.array(color) - 90.0
    share = change @ whole / (whole @ whole)
    rest = np.abs(change - share[:, None] * whole).max(1)
    return bool(((share > 0.4) & (rest < 30)).any())


def square_blob() -> Blob:
    mask = np.zeros((240, 320), np.uint8)
    mask[60:100, 200:240] = 255
    return blobs(mask)[0]


BLOB = square_blob()
SQUARE = np.array([(150.0, 140.0), (210.0, 140.0), (210.0, 200.0), (150.0, 200.0)])
DOWN = frame_of(GREY, (Point(1.0, 2.0, 3.0), ventral()))
DRAWN: dict[str, Callable[[Pixels], Pixels]] = {
    "text_line": lambda image: annotations.text_line(image, "lost: 12° to the left", 2),
    "section": lambda image: annotations.section(image, (40, 200), (120, 204), (80, 202)),
    "blob": lambda image: annotations.blob(image, BLOB, "red"),
    "marker": lambda image: annotations.marker(image, SQUARE, "7"),
    "rejected": lambda image: annotations.rejected(image, [SQUARE, SQUARE[:3] + 30]),
    "circle": lambda image: annotations.circle(image, (60, 100), 20, BLUE, "3 m"),
    "path": lambda image: annotations.path(image, DOWN, [(1, 2, 0), (1, 3, 0), (2, 3, 0)]),
    "axes": lambda image: annotations.axes(image, DOWN, (1, 2, 0), yaw_quaternion(0.5), 0.5),
}


@pytest.mark.parametrize("name", DRAWN)
def test_the_image_given_stays_as_it_is(name: str) -> None:
    before = GREY.copy()
    drawn = DRAWN[name](GREY)
    assert (before == GREY).all()
    assert (drawn.shape, drawn.dtype) == (GREY.shape, GREY.dtype)
    assert 10 < (drawn != GREY).any(2).sum() < 8000


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("size", [(16, 16), (1, 1), (2000, 7), (720, 1280)])
def test_every_size_of_image_is_drawn_on(size: tuple[int, int], name: str) -> None:
    image = np.full((*size, 3), 255, np.uint8)
    assert DRAWN[name](image).shape == image.shape


def test_a_section_shows_its_ends_and_the_reference_point() -> None:
    drawn = DRAWN["section"](GREY)
    for pixel in ((40, 200), (40, 197), (120, 204), (60, 201)):
        assert is_drawn(drawn, pixel, BLUE)
    assert is_drawn(drawn, (80, 202), RED)
    assert not is_drawn(annotations.section(GREY, (40, 200), (120, 204)), (80, 202), RED)


def test_a_blob_shows_its_contour_its_box_its_centroid_and_its_label() -> None:
    flat = np.zeros((240, 320), np.uint8)
    flat[60:100, 200:240] = 255
    flat[60:80, 200:220] = 0
    (found,) = blobs(flat)
    drawn = annotations.blob(GREY, found)
    assert is_drawn(drawn, (200, 60), YELLOW)
    assert is_drawn(drawn, (219, 70), GREEN)
    assert is_drawn(drawn, (found.x, found.y), RED)
    labelled = annotations.blob(GREY, found, "red")
    changed = (labelled != drawn).any(2)
    assert changed[44:58, 200:230].any() and not changed[60:].any()


def test_a_marker_shows_its_outline_its_first_corner_and_its_axes() -> None:
    turned = np.roll(SQUARE, -1, 0)  # its own upper left is at the upper right of the image
    drawn = annotations.marker(GREY, turned)
    assert is_drawn(drawn, (210, 140), YELLOW)
    for pixel in ((180, 140), (150, 170), (160, 200)):
        assert is_drawn(drawn, pixel, GREEN)
    assert is_drawn(drawn, (180, 199), RED)
    assert is_drawn(drawn, (195, 170), GREEN)
    assert not is_drawn(drawn, (165, 170), RED)


def test_the_axes_of_a_marker_follow_its_perspective() -> None:
    narrow = np.array([(140.0, 100.0), (180.0, 100.0), (220.0, 200.0), (100.0, 200.0)])
    drawn = annotations.marker(GREY, narrow)
    # The diagonals meet above the middle, at 1/4 of the height.
    assert is_drawn(drawn, (170, 125), RED) and is_drawn(drawn, (160, 113), GREEN)


@pytest.mark.parametrize("lens", [DOWN.intrinsics, DISTORTED])
def test_a_path_is_drawn_where_the_camera_sees_the_places(lens: Intrinsics) -> None:
    frame = frame_of(GREY, (Point(1.0, 2.0, 3.0), ventral(tilt=0.2, roll=-0.1, yaw=1.0)), lens)
    places = np.array([(0.7, 1.7, 0.0), (1.4, 2.3, 0.0), (1.2, 1.6, 0.0)])
    drawn = annotations.path(GREY, frame, places)
    on_it = [*places, (places[0] + places[1]) / 2, 0.3 * places[1] + 0.7 * places[2]]
    for pixel in pixels_of(frame, on_it):
        assert is_drawn(drawn, (pixel[0], pixel[1]), YELLOW)


def test_a_path_that_leads_behind_the_camera_is_drawn_as_far_as_it_is_seen() -> None:
    frame = frame_of(GREY, (Point(0.0, 0.0, 1.0), front()))
    drawn = annotations.path(GREY, frame, [(3.0, 0.0, 0.0), (-3.0, 0.0, 0.0)])
    (pixel,) = pixels_of(frame, [(3.0, 0.0, 0.0)])
    assert is_drawn(drawn, (pixel[0], pixel[1]), YELLOW)
    assert not (drawn[:100] != GREY[:100]).any()


def test_axes_point_where_they_lead_in_the_world() -> None:
    length = 0.5
    drawn = annotations.axes(GREY, DOWN, (1.2, 2.1, 0.0), yaw_quaternion(pi / 2), length)
    tips = [(1.2, 2.1 + length, 0.0), (1.2 - length, 2.1, 0.0), (1.2, 2.1, length)]
    seen = pixels_of(DOWN, tips)
    for pixel, color in zip(seen, (RED, GREEN, BLUE), strict=True):
        assert is_drawn(drawn, (pixel[0], pixel[1]), color)


def test_a_circle_has_its_color_and_radius() -> None:
    drawn = annotations.circle(GREY, (60, 100), 20, BLUE)
    for pixel in ((80, 100), (40, 100), (60, 80), (60, 120)):
        assert is_drawn(drawn, pixel, BLUE)
    assert not is_drawn(drawn, (60, 100), BLUE)


def test_lines_of_text_stand_below_each_other() -> None:
    rows = [
        np.flatnonzero((annotations.text_line(GREY, "gap", row) != GREY).any((1, 2)))
        for row in (0, 1, 2)
    ]
    assert rows[0][0] == 0
    assert rows[0][-1] < rows[1][0] and rows[1][-1] < rows[2][0]


def test_a_label_at_the_edge_is_moved_into_the_image() -> None:
    drawn = annotations.circle(GREY, (318, 236), 3, GREEN, "far away")
    assert (drawn[224:, 260:300] != GREY[224:, 260:300]).any()


numbers = st.floats() | st.integers(-(2**70), 2**70).map(float) | st.floats(-400, 400)
pairs = st.tuples(numbers, numbers)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(pairs, min_size=4, max_size=4), numbers, st.integers(1, 40), st.text(max_size=8))
@example([(0.0, 0.0)] * 4, inf, 1, "")
@example([(0.0, 0.0)] * 4, 1.2e307, 1, "")
@example([(1.7e308, -1.7e308), (-1.7e308, 1.7e308)] * 2, -1.7e308, 1, "")
def test_nothing_that_was_found_is_too_wrong_to_draw(
    corners: list[tuple[float, float]], size: float, height: int, words: str
) -> None:
    image = np.zeros((height, 30, 3), np.uint8)
    frame: Frame = frame_of(image, (Point(0.0, 0.0, 1.0), front()))
    annotations.text_line(image, words, height - 20)
    annotations.section(image, corners[0], corners[1], corners[2])
    annotations.marker(image, corners, words)
    annotations.rejected(image, [corners])
    annotations.circle(image, corners[0], size, label=words)
    annotations.path(image, frame, [(*corners[0], size), (*corners[1], size), (1, 0, 0)])
    annotations.axes(image, frame, (*corners[0], size), (0.0, 0.0, 0.0, 1.0), size)
