"""A map of a flight in a terminal: eight dots to a character (Unicode braille), north up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby, pairwise
from math import ceil, isfinite, log10
from operator import itemgetter
from typing import NamedTuple

from rich.text import Text

XY = tuple[float, float]
"""East and north, metres."""
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
MIN_SPAN = 6.0
"""The map never shows less than this, metres: standing still is not zoomed in on."""
MARGIN = 0.15
"""When a path leaves the map, the map grows by this share more, so that it seldom has to."""
STEP = 0.05
"""Metres between the points that are kept of a path, at first."""
MAX_POINTS = 4000
"""Points kept of a path: when there are more, every second one is left out."""
LINE_STYLE, PATH_STYLE = "bright_black", "cyan"


class Mark(NamedTuple):
    """A sign at a place of the map, with a label where there is room."""

    place: XY
    sign: str
    style: str
    label: str = ""


class Path:
    """The places that a vehicle has been at, closer together the shorter its flight is."""

    def __init__(self) -> None:
        self.points: list[XY] = []
        self._step = STEP

    def add(self, place: XY) -> bool:
        """Go on to a place, unless it is too near to the last one; whether it was added."""
        last = self.points[-1] if self.points else None
        if last and not max(abs(place[0] - last[0]), abs(place[1] - last[1])) >= self._step:
            return False
        self.points.append(place)
        if len(self.points) > MAX_POINTS:
            del self.points[1:-1:2]
            self._step *= 2
        return True


class Sketch:
    """Collects lines of the world and paths of vehicles, and draws them from above."""

    def __init__(self) -> None:
        self._lines: list[Sequence[XY]] = []
        self._paths: dict[str, Path] = {}
        self._shown: tuple[XY, XY] | None = None
        """West and east, south and north ends of what the map shows; None for nothing yet."""
        self._canvas: _Canvas | None = None
        """What was drawn last, without what moves."""

    def line(self, points: Sequence[XY]) -> None:
        """Draw a line of the world; the map does not grow for it."""
        self._lines.append(points)
        self._canvas = None

    def go(self, vehicle: str, place: XY) -> None:
        """A vehicle has come to a place."""
        path = self._paths.setdefault(vehicle, Path())
        if not (isfinite(place[0] + place[1]) and path.add(place)):
            return
        self.include(place, MARGIN)
        if self._canvas is not None and len(path.points) > 1:
            self._canvas.line(self._canvas.path, *path.points[-2:])

    def include(self, place: XY, margin: float = 0.0) -> None:
        """Make the map large enough for a place, and larger by a share of its size."""
        (west, east), (south, north) = shown = self._shown or ((place[0],) * 2, (place[1],) * 2)
        more = margin * max(east - west, north - south)
        grown = _grown(west, east, place[0], more), _grown(south, north, place[1], more)
        if grown != shown or self._shown is None:
            self._shown = grown
            self._canvas = None

    def draw(
        self, columns: int, rows: int, marks: Iterable[Mark], moving: Iterable[Sequence[XY]] = ()
    ) -> list[Text]:
        """So many rows: a title with the scale, and the map below.

        ``marks`` stand over all lines, later ones over earlier ones; ``moving`` are the lines of
        the world that are elsewhere the next time.
        """
        if columns < 2 or rows < 2:
            return [Text() for _ in range(rows)]
        canvas = self._canvas
        if canvas is None or (canvas.columns, canvas.rows) != (columns, rows - 1):
            canvas = self._canvas = self._drawn(columns, rows - 1)
        return [canvas.title(), *canvas.text(marks, moving)]

    def _drawn(self, columns: int, rows: int) -> _Canvas:
        canvas = _Canvas(columns, rows, *(self._shown or ((0.0, 0.0), (0.0, 0.0))))
        for line in self._lines:
            canvas.lines(canvas.world, line)
        for path in self._paths.values():
            canvas.lines(canvas.path, path.points)
        return canvas


def _grown(low: float, high: float, value: float, more: float) -> XY:
    """A range that a value lies in: where it did not before, with ``more`` beyond it."""
    return value - more if value < low else low, value + more if value > high else high


def _joined(cells: Sequence[tuple[str, str]]) -> Text:
    """Characters with their styles as one text."""
    return Text.assemble(
        *(
            ("".join(letter for letter, _ in run), style)
            for style, run in groupby(cells, key=itemgetter(1))
        )
    )


Layer = list[list[int]]
"""The dots of each character, by row and column."""


class _Canvas:
    """A sheet of characters that shows a part of the ground."""

    def __init__(self, columns: int, rows: int, east: XY, north: XY) -> None:
        """``east`` and ``north``: the least and the largest that it shows."""
        self.columns, self.rows = columns, rows
        self._width, self._height = columns * 2 - 1, rows * 4 - 1
        spans = east[1] - east[0], north[1] - north[0]
        span = max(MIN_SPAN, spans[0] * 1.1, spans[1] * 1.1 * self._width / self._height)
        self._scale = self._width / span
        """Dots to a metre."""
        self._middle = (sum(east) / 2, sum(north) / 2)
        self.world: Layer = [[0] * columns for _ in range(rows)]
        self.path: Layer = [[0] * columns for _ in range(rows)]

    def _dot(self, place: XY) -> XY:
        """Place in dots from the left and the top."""
        x = self._width / 2 + (place[0] - self._middle[0]) * self._scale
        return x, self._height / 2 - (place[1] - self._middle[1]) * self._scale

    def lines(self, layer: Layer, points: Sequence[XY]) -> None:
        """Draw straight lines from point to point."""
        for a, b in pairwise(points):
            self.line(layer, a, b)

    def line(self, layer: Layer, a: XY, b: XY) -> None:
        """Draw the part of a straight line that is on the sheet (clipping of Liang and Barsky)."""
        (x, y), (x_end, y_end) = self._dot(a), self._dot(b)
        begin, end = 0.0, 1.0
        for start, way, last in ((x, x_end - x, self._width), (y, y_end - y, self._height)):
            if way == 0:
                if not 0 <= start <= last:
                    return
                continue
            first, second = sorted((-start / way, (last - start) / way))
            begin, end = max(begin, first), min(end, second)
        if begin > end:
            return
        steps = max(1, ceil(max(abs(x_end - x), abs(y_end - y)) * (end - begin)))
        for k in range(steps + 1):
            share = begin + (end - begin) * k / steps
            column, row = round(x + (x_end - x) * share), round(y + (y_end - y) * share)
            layer[row >> 2][column >> 1] |= _DOTS[row & 3][column & 1]

    def title(self) -> Text:
        """What the map shows, and its scale: a bar with the length that it stands for."""
        metres, columns = self._scale_bar()
        bar = f"├{'─' * (columns - 2)}┤ {metres:g} m"
        words = "from above, north up"
        if len(words) + 2 + len(bar) > self.columns:
            words = "north up"
        return Text.assemble((f"{words}  ", "dim"), bar)

    def _scale_bar(self) -> tuple[float, int]:
        """The longest round length that takes a quarter of the columns or less, and its columns."""
        metres = self.columns / 4 / self._scale * 2
        power = 10.0 ** int(log10(metres) // 1)
        length = max(n * power for n in (1, 2, 5) if n * power <= metres)
        return length, max(2, round(length * self._scale / 2))

    def text(self, marks: Iterable[Mark], moving: Iterable[Sequence[XY]]) -> list[Text]:
        """The rows of the sheet."""
        world = [row.copy() for row in self.world]
        for line in moving:
            self.lines(world, line)
        cells = [
            [
                (chr(0x2800 | dots | path), PATH_STYLE if path else LINE_STYLE)
                if dots or path
                else (" ", "")
                for dots, path in zip(*rows, strict=True)
            ]
            for rows in zip(world, self.path, strict=True)
        ]
        self._put(cells, list(marks))
        return [_joined(row) for row in cells]

    def _put(self, cells: list[list[tuple[str, str]]], marks: Sequence[Mark]) -> None:
        """Set the signs of marks, and their labels where these cover no other sign or label."""
        spots = [(mark, spot) for mark in marks if (spot := self._cell(mark.place)) is not None]
        taken = {spot for _, spot in spots}
        for mark, (row, column) in spots:
            for first in (column + 1, column - len(mark.label)):
                room = {(row, first + k) for k in range(len(mark.label))}
                if first >= 0 and first + len(mark.label) <= self.columns and not room & taken:
                    taken |= room
                    for k, letter in enumerate(mark.label):
                        cells[row][first + k] = (letter, mark.style)
                    break
        for mark, (row, column) in spots:
            cells[row][column] = (mark.sign, mark.style)

    def _cell(self, place: XY) -> tuple[int, int] | None:
        """Row and column of a place; None outside the sheet."""
        x, y = self._dot(place)
        if not (0 <= x <= self._width and 0 <= y <= self._height):
            return None
        return round(y) >> 2, round(x) >> 1
