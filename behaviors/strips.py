"""Strips: an area cut along one direction, and the lanes from which each strip is seen.

Where the area is concave or has holes a strip has several parts. Parts that follow each other
without a branch are a cell (boustrophedon decomposition: H. Choset, *Coverage of Known Spaces: The
Boustrophedon Cellular Decomposition*, 2000).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, inf, sin
from typing import Any

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Polygon

from behaviors.plan import Unflyable
from behaviors.polygons import ROOM, SMALL, polygons
from vencejo.geometry import rotate_xy
from vencejo.polylines import XY

_MOST_LANES = 10_000
_SPLITS = 3
"""How often a part of a strip that is forked is split into halves."""
_MISSED = 0.06
"""Area that may be missed in a part of a strip, in squares as wide as the strip."""


@dataclass(frozen=True)
class Footprint:
    """What is seen at once from a lane, metres."""

    across: float
    """Distance from lane to lane: so much is seen across them at least."""
    ahead: float
    """Distance ahead, and behind, up to which places count as seen. A lane ends that much before
    the edge of the area."""
    beside: float = 0.0
    """How much more than half of ``across`` is seen on either side. What is that near to another
    lane need not be seen from its own."""


class Strips:
    """An area cut into strips along one direction. Places are turned so that it is that of x."""

    def __init__(self, area: Polygon | MultiPolygon, footprint: Footprint, axis: float) -> None:
        self.axis = axis
        self._footprint = footprint
        area = shapely.transform(area, lambda places: _turned(places, -axis))
        west, low, east, high = area.bounds
        count = max(1, ceil((high - low) / footprint.across - 1e-9))
        if high - low < 1e-3 or count > _MOST_LANES:
            message = f"an area {high - low:.3g} m wide cannot be flown over in {count} lanes"
            raise Unflyable(message, "area")
        self._edges: list[float] = np.linspace(low, high, count + 1).tolist()
        boxes = shapely.box(west - 1, self._edges[:-1], east + 1, self._edges[1:])
        cut = shapely.intersection(area, boxes)
        self._parts = [[part for part in polygons(each) if part.area > SMALL] for each in cut]
        self._span = west - 1, east + 1
        if footprint.beside:
            self._parts = [
                [part for part in parts if not self._is_seen_beside(part, k)]
                for k, parts in enumerate(self._parts)
            ]

    def _is_seen_beside(self, part: Polygon, k: int) -> bool:
        """Whether a part is so thin that it is seen from a lane beside it."""
        _, low, _, high = part.bounds
        sides = [
            (k - 1, high - self._edges[k]),
            (k + 1, self._edges[k + 1] - low),
        ]
        return any(
            0 <= number < len(self._parts)
            and width <= self._footprint.beside
            and any(self._has_lane_beside(other, part) for other in self._parts[number])
            for number, width in sides
        )

    def _has_lane_beside(self, other: Polygon, part: Polygon) -> bool:
        """Whether the lane of another part leads along the whole of a part."""
        (west, _, east, _), (begin, low, end, high) = part.bounds, other.bounds
        return (
            begin <= west
            and east <= end
            and high - low > self._footprint.beside
            and _touch(part, other)
        )

    def estimate(self, turn: float) -> float:
        """About what it costs: the lengths of all parts, and a turn with its way for each."""
        way = 0.0
        for parts in self._parts:
            for part in parts:
                west, _, east, _ = part.bounds
                way += max(0.0, east - west - 2 * self._footprint.ahead) + turn
        return way + self._edges[-1] - self._edges[0]

    def cells(self) -> list[list[tuple[XY, ...]]]:
        """The lanes of each cell, from one side to the other, each from west to east."""
        numbers: list[list[int]] = []
        cells: list[list[tuple[XY, ...]]] = []
        for k, parts in enumerate(self._parts):
            below = self._parts[k - 1] if k else []
            joints = [[j for j, other in enumerate(below) if _touch(part, other)] for part in parts]
            row = []
            for number, part in enumerate(parts):
                lines = self._lines(part, k)
                (before,) = joints[number] if len(joints[number]) == 1 else (None,)
                alone = before is not None and sum(before in each for each in joints) == 1
                if before is not None and alone:
                    cell = numbers[-1][before]
                    cells[cell] += lines
                else:
                    cell = len(cells)
                    cells.append(lines)
                row.append(cell)
            numbers.append(row)
        return [[self._back(lane) for lane in cell] for cell in cells]

    def _lines(self, part: Polygon, k: int) -> list[tuple[XY, ...]]:
        """The lanes from which one part of a strip is seen, each from west to east."""
        strip = self._edges[k], self._edges[k + 1]
        return _lines(part, self._extent(part, k), strip, self._footprint)

    def _extent(self, part: Polygon, k: int) -> XY:
        """From where to where a part must be seen from its own lane."""
        last = len(self._parts) - 1
        low = self._edges[k] + (self._footprint.beside if k > 0 else 0.0)
        high = self._edges[k + 1] - (self._footprint.beside if k < last else 0.0)
        own = part.intersection(shapely.box(self._span[0], low, self._span[1], high))
        west, _, east, _ = (part if own.is_empty else own).bounds
        return west, east

    def _back(self, lane: tuple[XY, ...]) -> tuple[XY, ...]:
        return tuple(rotate_xy(x, y, self.axis) for x, y in lane)


def _turned(places: Any, angle: float) -> Any:
    c, s = cos(angle), sin(angle)
    return places @ np.array([[c, s], [-s, c]])


def _touch(a: Polygon, b: Polygon) -> bool:
    """Whether parts of two strips beside each other have more than a corner in common."""
    return bool(a.intersection(b).length > SMALL)


def _intervals(geometry: Any) -> list[XY]:
    """The intervals of x of the lines in a geometry."""
    lines = [part for part in shapely.get_parts(geometry) if isinstance(part, LineString)]
    return [(line.bounds[0], line.bounds[2]) for line in lines if line.length > SMALL]


def _lines(
    part: Polygon, extent: XY, strip: XY, footprint: Footprint, splits: int = _SPLITS
) -> list[tuple[XY, ...]]:
    """The lanes in a part of a strip, each from west to east: one along its middle where that is
    inside, else beside that. A part that is forked so that one lane does not see all
    of it is split into halves.

    ``extent`` is from where to where it must be seen along x, ``strip`` the edges of the strip.
    """
    ahead = footprint.ahead
    first, last = extent[0] + ahead, extent[1] - ahead
    if first >= last:
        first = last = (extent[0] + extent[1]) / 2
    middle = (strip[0] + strip[1]) / 2

    def nearest(pieces: list[XY]) -> float:
        """The place in any of the pieces that is nearest to the middle."""
        return min((_towards(middle, *each) for each in pieces), key=lambda y: abs(y - middle))

    west, _, east, _ = part.bounds
    centre = part.intersection(LineString([(west - 1, middle), (east + 1, middle)]))
    line: list[XY] = []
    is_forked, over = False, -inf
    for begin, end in [*sorted(_intervals(centre)), (inf, inf)]:
        for x in _stations(max(over, first), min(begin, last), ahead):
            if over + SMALL < x < begin - SMALL:  # else it is an end of a piece of the middle
                pieces = _pieces(part, x)
                is_forked = is_forked or len(pieces) > 1
                line.append((x, nearest(pieces)))
        if max(begin, first) <= min(end, last):
            line += [(max(begin, first), middle), (min(end, last), middle)]
        over = max(over, end)
    if not line:
        line.append((first, nearest(_pieces(part, first))))
    most = _MISSED * footprint.across**2
    if is_forked and splits and _missed(part, extent, line, footprint) > most:
        return _halves(part, strip, footprint, splits - 1)
    return [tuple(dict.fromkeys(line))]


def _missed(part: Polygon, extent: XY, line: list[XY], footprint: Footprint) -> float:
    """The area of a part that is not seen from a lane, square metres."""
    across, ahead = footprint.across / 2 + footprint.beside, footprint.ahead
    offsets = [(dx, dy) for dx in (-ahead, ahead) for dy in (-across, across)]
    seen = [
        shapely.MultiPoint([(x + dx, y + dy) for x, y in leg for dx, dy in offsets]).convex_hull
        for leg in ([*pairwise(line)] or [(line[0], line[0])])
    ]
    _, low, _, high = part.bounds
    wanted = part.intersection(shapely.box(extent[0], low, extent[1], high))
    return float(wanted.difference(shapely.union_all(seen)).area)


def _halves(part: Polygon, strip: XY, footprint: Footprint, splits: int) -> list[tuple[XY, ...]]:
    """The lanes of the two halves of a strip."""
    (low, high), (west, _, east, _) = strip, part.bounds
    middle = (low + high) / 2
    lines = []
    for half in ((low, middle), (middle, high)):
        cut = part.intersection(shapely.box(west, half[0], east, half[1]))
        for piece in polygons(cut):
            if piece.area > SMALL:
                extent = piece.bounds[0], piece.bounds[2]
                lines += _lines(piece, extent, half, footprint, splits)
    return lines


def _towards(middle: float, bottom: float, top: float) -> float:
    """The number between two others that is nearest to a middle, with some room if there is."""
    room = min(ROOM, (top - bottom) / 2)
    return min(max(middle, bottom + room), top - room)


def _stations(begin: float, end: float, apart: float) -> list[float]:
    """Places from a begin to an end, both included, no farther apart than that."""
    if end < begin:
        return []
    parts = ceil((end - begin) / apart) or 1
    return [begin + (end - begin) * k / parts for k in range(parts + 1)]


def _pieces(part: Polygon, x: float) -> list[XY]:
    """From where to where a polygon is cut at x, one or more times."""
    _, low, _, high = part.bounds
    cut = part.intersection(LineString([(x, low - 1), (x, high + 1)]))
    found = [each.bounds for each in shapely.get_parts(cut) if not each.is_empty]
    long = [(bottom, top) for _, bottom, _, top in found if top - bottom > SMALL]
    return long or [(bottom, top) for _, bottom, _, top in found]
