"""A panel of a picture with two scales: coordinates to pixels, ticks, grid and labels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

from cli.plot.canvas import XY, Box, Canvas

GRID, FRAME, LABEL = (228, 228, 228), (120, 120, 120), (90, 90, 90)
_STEPS = (1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True)
class Scale:
    """A range of coordinates over a range of pixels."""

    low: float
    high: float
    first: float
    """The pixel of ``low``."""
    last: float
    """The pixel of ``high``."""

    def pixel(self, value: float) -> float:
        return self.first + (value - self.low) / (self.high - self.low) * (self.last - self.first)

    def ticks(self, spacing: float) -> list[float]:
        """Round coordinates, about ``spacing`` pixels apart and no nearer."""
        span = self.high - self.low
        least = spacing * span / abs(self.last - self.first)
        decade = 10.0 ** floor(log10(least))
        step = next(decade * step for step in _STEPS if decade * step >= least * (1 - 1e-9))
        first, last = ceil(self.low / step - 1e-9), floor(self.high / step + 1e-9)
        return [number * step for number in range(first, last + 1)]


@dataclass(frozen=True)
class Axes:
    """A panel: its box, and the scales of what is drawn in it."""

    box: Box
    x: Scale
    y: Scale

    def place(self, x: float, y: float) -> XY:
        return self.x.pixel(x), self.y.pixel(y)

    def places(self, points: Iterable[XY]) -> list[XY]:
        return [(self.x.pixel(x), self.y.pixel(y)) for x, y in points]

    def near(self, points: Iterable[XY], margin: float) -> list[XY]:
        """The places of points; of those far beyond the panel, the nearest that are ``margin``
        pixels beside it.
        """
        left, right = self.box.left - margin, self.box.right + margin
        top, bottom = self.box.top - margin, self.box.bottom + margin
        return [
            (max(left, min(right, x)), max(top, min(bottom, y))) for x, y in self.places(points)
        ]

    def grid(self, canvas: Canvas, *, x_spacing: float = 60, y_spacing: float = 30) -> None:
        """Lines at the ticks, to be drawn before anything else."""
        for value in self.x.ticks(x_spacing):
            ends = (self.x.pixel(value), self.box.top), (self.x.pixel(value), self.box.bottom)
            canvas.line(ends, GRID, 1)
        for value in self.y.ticks(y_spacing):
            ends = (self.box.left, self.y.pixel(value)), (self.box.right, self.y.pixel(value))
            canvas.line(ends, GRID, 1)

    def frame(self, canvas: Canvas, title: str) -> None:
        """The edge of the panel, and its title above."""
        canvas.rectangle(self.box, None, FRAME)
        canvas.text((self.box.left, self.box.top - 9), title)

    def label_x(self, canvas: Canvas, spacing: float = 60) -> None:
        """The numbers at the ticks, below the panel."""
        for value in self.x.ticks(spacing):
            place = (self.x.pixel(value), self.box.bottom + 5)
            canvas.text(place, _number(value), 11, LABEL, "mt")

    def label_y(self, canvas: Canvas, spacing: float = 30) -> None:
        """The numbers at the ticks, left of the panel."""
        for value in self.y.ticks(spacing):
            canvas.text((self.box.left - 5, self.y.pixel(value)), _number(value), 11, LABEL, "rm")


def axes_over(box: Box, x_range: tuple[float, float], y_range: tuple[float, float]) -> Axes:
    """Axes whose ranges fill the box."""
    return Axes(box, Scale(*x_range, box.left, box.right), Scale(*y_range, box.bottom, box.top))


def axes_from_above(box: Box, places: Sequence[XY], margin: float, least: float) -> Axes:
    """Axes with one scale for both directions, that show all places in the middle of the box.

    ``margin`` is a share of what they span; they show ``least`` metres at least.
    """
    low = [min(place[axis] for place in places) for axis in (0, 1)]
    high = [max(place[axis] for place in places) for axis in (0, 1)]
    spans = [(high[axis] - low[axis]) * (1 + 2 * margin) for axis in (0, 1)]
    span = max(least, spans[0], spans[1] * box.width / box.height)
    x, y = ((low[axis] + high[axis]) / 2 for axis in (0, 1))
    half, tall = span / 2, span / 2 * box.height / box.width
    return axes_over(box, (x - half, x + half), (y - tall, y + tall))


def _number(value: float) -> str:
    return f"{value + 0.0:.6g}"
