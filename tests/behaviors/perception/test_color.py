"""Ranges of colours and the pixels in them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors.perception.color import ColorRange, mask, named, range_of, read_color
from hal.scene.arrays import Pixels
from worlds.colors import COLORS

CHROMATIC = ("red", "orange", "yellow", "green", "cyan", "blue", "purple", "magenta")


def plain(rgb: tuple[int, int, int], size: int = 4) -> Pixels:
    return np.full((size, size, 3), rgb[::-1], np.uint8)


@pytest.mark.parametrize("name", COLORS)
def test_a_named_colour_holds_itself_in_sun_and_half_shade(name: str) -> None:
    for light in (1.0, 0.8):
        shaded = tuple(round(part * light) for part in COLORS[name])
        assert mask(plain(shaded), named(name)).all(), light


@pytest.mark.parametrize("name", CHROMATIC)
def test_bright_colours_are_told_from_each_other(name: str) -> None:
    seen = [
        other
        for other in (*CHROMATIC, "asphalt", "grass", "white", "black", "gray")
        if mask(plain(COLORS[other]), named(name)).all()
    ]
    assert seen == [name]


def test_what_has_no_colour_is_told_by_its_brightness() -> None:
    grays = ("black", "asphalt", "gray", "white")
    for name in grays:
        assert [g for g in grays if mask(plain(COLORS[g]), named(name)).all()] == [name]
    assert not mask(plain(COLORS["grass"]), named("asphalt")).any()


def test_ranges_as_people_write_them() -> None:
    assert read_color("red") == named("red")
    assert read_color(named("blue")) is named("blue")
    hsv = read_color({"hsv": [[170, 100, 80], [10, 255, 255]]})
    assert hsv == ColorRange((170, 100, 80), (10, 255, 255), "hsv")
    rgb = read_color({"rgb": [[90, 90, 90], [140.0, 140, 140]]})
    assert rgb == ColorRange((90, 90, 90), (140, 140, 140), "rgb")
    assert mask(plain((100, 139, 90)), rgb).all()
    assert not mask(plain((100, 141, 90)), rgb).any()
    assert mask(plain((90, 100, 139)), ColorRange((80, 95, 130), (95, 105, 140), "rgb")).all()


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("rde", "there is no colour 'rde' (did you mean 'red'?)"),
        (7, "a colour is a name, {hsv:"),
        ({}, "a colour is a name, {hsv:"),
        ({"hsl": [[0, 0, 0], [1, 1, 1]]}, "a colour is a name, {hsv:"),
        ({"hsv": [[0, 0, 0]]}, "hsv is the lowest and the highest triple"),
        ({"hsv": [[0, 0, 0], [180, 255, 255]]}, "from [0, 0, 0] to [179, 255, 255]"),
        ({"rgb": [[0, 0, 0], [1, 1, "x"]]}, "rgb is the lowest and the highest triple"),
        ({"rgb": [[0, 0, 0], [1, 1, True]]}, "rgb is the lowest and the highest triple"),
        ({"rgb": [[0, 0, 0.5], [1, 1, 1]]}, "rgb is the lowest and the highest triple"),
        ({"rgb": "abc"}, "rgb is the lowest and the highest triple"),
        ({"rgb": [[9, 0, 0], [1, 1, 1]]}, "of rgb [9, 0, 0] is not below [1, 1, 1]"),
        ({"hsv": [[9, 9, 0], [1, 1, 1]]}, "of hsv [9, 9, 0] is not below [1, 1, 1]"),
    ],
)
def test_what_is_no_colour_is_told(given: object, told: str) -> None:
    with pytest.raises(ValueError) as error:
        read_color(given)
    assert told in str(error.value)


@settings(deadline=None)
@given(st.tuples(*[st.integers(0, 255)] * 3), st.sampled_from(["hsv", "rgb"]))
def test_the_range_of_a_box_holds_the_box(rgb: tuple[int, int, int], space: str) -> None:
    image = plain(rgb, 8)
    found = range_of(image, (2, 2, 6, 6), space)
    assert found.space == space
    assert mask(image, found).all()


def test_the_range_of_a_red_thing_goes_over_hue_0() -> None:
    hsv = np.zeros((8, 8, 3), np.uint8)
    hsv[..., 0] = np.where(np.arange(64).reshape(8, 8) % 2, 176, 3)
    hsv[..., 1:] = 200
    image = np.asarray(cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR), np.uint8)
    found = range_of(image, (0, 0, 8, 8))
    assert found.low[0] > found.high[0]
    assert mask(image, found).all()
    assert not mask(plain(COLORS["green"]), found).any()


def test_a_box_beside_the_picture_is_told() -> None:
    with pytest.raises(ValueError, match="nothing of the picture, 4 x 4 pixels, is in the box"):
        range_of(plain((1, 2, 3)), (10, 10, 12, 12))
