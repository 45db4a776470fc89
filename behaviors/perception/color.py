"""Colours: ranges by name, HSV or RGB, and the pixels of an image inside them."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import cv2
import numpy as np

from hal.scene.arrays import Box, Pixels
from vencejo.errors import nearest
from worlds.colors import COLORS

Space = Literal["hsv", "rgb"]
Triple = tuple[int, int, int]
_MOST: Mapping[Space, Triple] = {"hsv": (179, 255, 255), "rgb": (255, 255, 255)}
_GRAY = 51
"""Saturation, 0 to 255, up to which a colour has no hue."""
_HUE = 8
"""Half of the range of a named colour's hue, units of 2°."""
_MARGIN = 10
"""What a range taken from an image is wider on both sides, units of the space."""


@dataclass(frozen=True, slots=True)
class ColorRange:
    """The colours from ``low`` to ``high``, both included.

    In ``rgb`` each of red, green and blue is 0 to 255. In ``hsv``, as OpenCV has it, the hue is 0
    to 179 in units of 2° and saturation and value are 0 to 255; a low hue above the high one means
    the hues from there over 0 to it.
    """

    low: Triple
    high: Triple
    space: Space = "hsv"


def read_color(given: object) -> ColorRange:
    """The range of a colour as a person writes it: a name, a ColorRange, or a map of one key.

    That key is ``hsv`` or ``rgb``, and its value the lowest and the highest triple. Raises
    ValueError, with a message for that person.
    """
    if isinstance(given, ColorRange):
        return given
    if isinstance(given, str):
        return named(given)
    if isinstance(given, Mapping) and len(given) == 1:
        [(space, ends)] = given.items()
        if space in ("hsv", "rgb"):
            low, high = _ends(space, ends)
            return ColorRange(low, high, space)
    raise ValueError(
        "a colour is a name, {hsv: [[h, s, v], [h, s, v]]} or {rgb: [[r, g, b], [r, g, b]]}"
    )


def _ends(space: Space, ends: Any) -> tuple[Triple, Triple]:
    most = _MOST[space]
    found = [
        tuple(int(n) for n in triple)
        for triple in (ends if _is_list(ends, 2) else ())
        if _is_list(triple, 3) and all(_is_whole(n, m) for n, m in zip(triple, most, strict=True))
    ]
    if len(found) != 2:
        raise ValueError(
            f"{space} is the lowest and the highest triple, each from [0, 0, 0] to {list(most)}"
        )
    low, high = found
    # Only hues go round.
    first = 1 if space == "hsv" else 0
    if any(a > b for a, b in zip(low[first:], high[first:], strict=True)):
        raise ValueError(f"of {space} {list(low)} is not below {list(high)}")
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def _is_list(given: Any, length: int) -> bool:
    return isinstance(given, Sequence) and not isinstance(given, str) and len(given) == length


def _is_whole(given: Any, most: int) -> bool:
    number = isinstance(given, (int, float)) and not isinstance(given, bool)
    return number and given == int(given) and 0 <= given <= most


@cache
def named(name: str) -> ColorRange:
    """The range about a named colour: wide enough for sun and shade. Raises ValueError."""
    if name not in COLORS:
        raise ValueError(f"there is no colour '{name}' ({nearest(name, COLORS)})")
    hue, saturation, value = colorsys.rgb_to_hsv(*(part / 255 for part in COLORS[name]))
    h, s, v = round(180 * hue) % 180, round(255 * saturation), round(255 * value)
    if s <= _GRAY:
        brightest = 255 if v > 240 else v * 5 // 4 + 10
        return ColorRange((0, 0, v * 3 // 4), (179, s + _GRAY, min(255, brightest)))
    return ColorRange(
        ((h - _HUE) % 180, max(_GRAY, s * 55 // 100), v * 40 // 100),
        ((h + _HUE) % 180, 255, min(255, v * 5 // 4)),
    )


def mask(image: Pixels, wanted: ColorRange) -> Pixels:
    """The pixels of a BGR image (height, width, 3) in a range: 255 there, else 0."""
    if wanted.space == "rgb":
        return np.asarray(cv2.inRange(image, wanted.low[::-1], wanted.high[::-1]), np.uint8)
    return hsv_mask(np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), np.uint8), wanted)


def hsv_mask(image: Pixels, wanted: ColorRange) -> Pixels:
    """The pixels of an image in OpenCV's HSV that are in a range of ``hsv``: 255 there, else 0."""
    low, high = wanted.low, wanted.high
    if low[0] <= high[0]:
        return np.asarray(cv2.inRange(image, low, high), np.uint8)
    below = cv2.inRange(image, (0, *low[1:]), high)
    above = cv2.inRange(image, low, (179, *high[1:]))
    return np.asarray(cv2.bitwise_or(below, above), np.uint8)


def range_of(image: Pixels, box: Box, space: Space = "hsv") -> ColorRange:
    """The range of the colours in a box of a BGR image, of all but the outermost two per cent.

    Raises ValueError for a box with nothing of the image in it.
    """
    left, top, right, bottom = box
    part = image[max(0, top) : max(0, bottom), max(0, left) : max(0, right)]
    if part.size == 0:
        height, width = image.shape[:2]
        raise ValueError(f"nothing of the picture, {width} x {height} pixels, is in the box")
    if space == "rgb":
        channels = part.reshape(-1, 3)[:, ::-1].T.astype(int)
    else:
        channels = np.asarray(cv2.cvtColor(part, cv2.COLOR_BGR2HSV)).reshape(-1, 3).T.astype(int)
    most = _MOST[space]
    spans = [_span(values, most[k]) for k, values in enumerate(channels)]
    if space == "hsv":
        spans[0] = _hues(channels[0], channels[1])
    (a, b, c), (d, e, f) = zip(*spans, strict=True)
    return ColorRange((a, b, c), (d, e, f), space)


def _span(values: Any, most: int) -> tuple[int, int]:
    low, high = np.percentile(values, (1, 99))
    return max(0, round(low) - _MARGIN), min(most, round(high) + _MARGIN)


def _hues(hues: Any, saturations: Any) -> tuple[int, int]:
    """The range of hues, over 0 if need be; all of them where there is little colour."""
    if np.median(saturations) <= _GRAY:
        return 0, 179
    # Turned so that their mean direction is in the middle, hues do not go round.
    angles = hues * (np.pi / 90)
    middle = round(float(np.arctan2(np.sin(angles).mean(), np.cos(angles).mean())) * 90 / np.pi)
    turned = (hues - middle + 90) % 180
    low, high = np.percentile(turned, (1, 99))
    half = _MARGIN // 2
    if high - low + 2 * half >= 179:
        return 0, 179
    return (round(low) - half + middle - 90) % 180, (round(high) + half + middle - 90) % 180
