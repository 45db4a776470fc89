"""A picture to draw on, by Pillow: smooth lines and areas, sharp text above them.

Lines and areas are drawn at twice the size and averaged, which is Pillow's way to smooth them. All
lengths are pixels of the finished picture, x to the right and y down.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from io import BytesIO
from itertools import pairwise
from math import hypot
from typing import Literal, NamedTuple

from PIL import Image, ImageDraw, ImageFont

_SCALE = 2
_COMPRESSION = 3
"""PNG's: 9 would take three times as long for a file smaller by a tenth."""
Color = tuple[int, int, int]
RED, DARK, WHITE = (214, 39, 40), (40, 40, 40), (255, 255, 255)
XY = tuple[float, float]
Anchor = Literal["lm", "mm", "rm", "lt", "mt", "mb"]
"""Where in a text its place is, in Pillow's letters: left, middle, right; top, middle, bottom."""


class Box(NamedTuple):
    """A rectangle of a picture."""

    left: float
    top: float
    right: float
    bottom: float

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.bottom - self.top

    def holds(self, place: XY) -> bool:
        return self.left <= place[0] <= self.right and self.top <= place[1] <= self.bottom


class Canvas:
    """A white picture, drawn upon in order; text comes last."""

    def __init__(self, width: int, height: int) -> None:
        self._image = Image.new("RGB", (width * _SCALE, height * _SCALE), "white")
        self._draw = ImageDraw.Draw(self._image)
        self._texts: list[tuple[XY, str, int, Color, Anchor]] = []

    def line(self, points: Sequence[XY], color: Color, width: float = 1.5) -> None:
        if len(points) > 1:
            places = [(x * _SCALE, y * _SCALE) for x, y in points]
            self._draw.line(places, color, round(width * _SCALE), joint="curve")

    def dashes(self, points: Sequence[XY], color: Color, width: float = 1.0) -> None:
        """A line of dashes, each 5 pixels long and 4 apart."""
        passed = 0.0
        dash: list[XY] = []
        for a, b in pairwise(points):
            length = hypot(b[0] - a[0], b[1] - a[1])
            done = 0.0
            while done < length:
                within = passed % 9.0
                part = min((5.0 if within < 5.0 else 9.0) - within, length - done)
                if within < 5.0:
                    ends = [_between(a, b, share / length) for share in (done, done + part)]
                    dash = [*dash, ends[1]] if dash else ends
                else:
                    self.line(dash, color, width)
                    dash = []
                # A little more than the part, lest rounding leaves none of it.
                done, passed = done + part + 1e-6, passed + part + 1e-6
        self.line(dash, color, width)

    def area(self, points: Sequence[XY], fill: Color, edge: Color | None = None) -> None:
        """A polygon, filled, with a thin edge if it is given a colour."""
        if len(points) > 2:
            places = [(x * _SCALE, y * _SCALE) for x, y in points]
            self._draw.polygon(places, fill, edge, _SCALE if edge else 1)

    def rectangle(self, box: Box, fill: Color | None, edge: Color | None = None) -> None:
        scaled = [side * _SCALE for side in box]
        self._draw.rectangle(scaled, fill, edge, _SCALE if edge else 1)

    def disc(self, place: XY, radius: float, fill: Color) -> None:
        x, y = place
        sides = (x - radius, y - radius, x + radius, y + radius)
        self._draw.ellipse([side * _SCALE for side in sides], fill)

    def text(
        self,
        place: XY,
        text: str,
        size: int = 12,
        color: Color = (40, 40, 40),
        anchor: Anchor = "lm",
    ) -> None:
        self._texts.append((place, text, size, color, anchor))

    def erase_outside(self, box: Box) -> None:
        """Make everything white again but a box: what is drawn later may lie outside of it."""
        width, height = (side / _SCALE for side in self._image.size)
        sides = (
            Box(0, 0, width, box.top),
            Box(0, box.bottom, width, height),
            Box(0, 0, box.left, height),
            Box(box.right, 0, width, height),
        )
        for side in sides:
            self.rectangle(side, (255, 255, 255))

    def png(self) -> bytes:
        """The picture, with its text."""
        image = self._image.reduce(_SCALE)
        draw = ImageDraw.Draw(image)
        for place, text, size, color, anchor in self._texts:
            draw.text(place, text, color, _font(size), anchor)
        data = BytesIO()
        image.save(data, "PNG", compress_level=_COMPRESSION)
        return data.getvalue()


def text_width(text: str, size: int = 12) -> float:
    """The width of a text, pixels."""
    return _font(size).getlength(text)


def fitted(text: str, width: float, size: int = 12) -> str:
    """A text, or as much of its begin as there is room for in so many pixels."""
    if text_width(text, size) <= width:
        return text
    while text and text_width(f"{text}…", size) > width:
        text = text[:-1]
    return f"{text}…"


def _between(a: XY, b: XY, share: float) -> XY:
    return a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share


@cache
def _font(size: int) -> ImageFont.FreeTypeFont:
    """The font that comes with Pillow."""
    font = ImageFont.load_default(size)
    assert isinstance(font, ImageFont.FreeTypeFont)
    return font
