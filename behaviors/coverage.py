"""Coverage: the lanes over an area from which a vehicle sees all of it.

For a direction the area is cut into strips, one lane in the middle of each (boustrophedon
decomposition: H. Choset, *Coverage of Known Spaces: The Boustrophedon Cellular Decomposition*,
2000). Where the area is concave or has holes a strip has several parts, and parts that follow each
other without a branch are a cell, which is flown to and fro. Cells are flown in an order that is
short, and between lanes the way leads round the corners of the area and its holes and never across
what lies outside. Of all directions that take the least time is chosen.

Metres over the ground, radians counter-clockwise from east.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, cos, dist, hypot, inf, pi, sin
from typing import Any

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Polygon
from shapely.geometry.polygon import orient

from behaviors.plan import Unflyable
from vencejo.geometry import rotate_xy
from vencejo.polylines import XY

_MOST_LANES = 10_000
_SMALL = 1e-6
"""Lengths, m, and areas, m², below this are none."""
_STEP = pi / 36
"""Directions that are tried, beside those of all sides of the area, are so far apart."""
_TRIED = 8
"""Directions whose whole way is worked out: the most promising ones."""
_CLEAR = 0.3
"""Distance at which a way passes a corner round which it leads, where there is room, metres."""
_TURN = 1.0
"""Seconds that a turn from one lane into the next costs beside its way."""


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


@dataclass(frozen=True)
class Lane:
    """A lane and the way to it."""

    approach: tuple[XY, ...]
    """The corners on the way from the end of the lane before; none where that is straight."""
    line: tuple[XY, ...]
    """The places of the lane in the order of flight, one or more; most have two."""


@dataclass(frozen=True)
class Lanes:
    """Lanes over an area, in the order of flight."""

    lanes: tuple[Lane, ...]
    axis: float
    """Their direction."""

    @property
    def places(self) -> list[XY]:
        """All places of the way, in order."""
        return [place for lane in self.lanes for place in (*lane.approach, *lane.line)]

    @property
    def length(self) -> float:
        """The way from the first place to the last one, metres."""
        return _length(self.places)


def area_of(corners: Sequence[XY], holes: Sequence[Sequence[XY]] = ()) -> Polygon | MultiPolygon:
    """The area inside corners without some holes; all outlines must be simple.

    Raises Unflyable for corners about nothing, and where the holes leave nothing.
    """
    area = Polygon(corners)
    if area.area <= _SMALL:
        raise Unflyable("this area has no extent", "area")
    for hole in holes:
        area = area.difference(Polygon(hole))
    parts = [part for part in _polygons(area) if part.area > _SMALL]
    if not parts:
        raise Unflyable("the holes leave nothing of this area", "holes")
    return parts[0] if len(parts) == 1 else MultiPolygon(parts)


def lanes_over(
    corners: Sequence[XY],
    holes: Sequence[Sequence[XY]],
    footprint: Footprint,
    speed: float,
    begin: XY | None = None,
    axis: float | None = None,
) -> Lanes:
    """The lanes over an area, less its holes, that take the least time at a ``speed``, m/s.

    ``begin`` is where the vehicle comes from; ``axis`` the direction of the lanes, None for the
    best one. Raises Unflyable for an area of too many lanes, and one that has no extent.
    """
    outlines = tuple(tuple(hole) for hole in holes)
    return _lanes_over(tuple(corners), outlines, footprint, speed, begin, axis)


@lru_cache(maxsize=32)
def _lanes_over(
    corners: tuple[XY, ...],
    holes: tuple[tuple[XY, ...], ...],
    footprint: Footprint,
    speed: float,
    begin: XY | None,
    axis: float | None,
) -> Lanes:
    area = area_of(corners, holes)
    turn = _TURN * speed
    axes = [axis] if axis is not None else _axes(area)
    plans = [_Strips(area, footprint, each) for each in axes]
    plans.sort(key=lambda plan: plan.estimate(turn))
    inside = _Inside(area)
    best, least = None, inf
    for plan in plans[:_TRIED]:
        lanes = _ordered(plan.cells(), plan.axis, inside, begin)
        start = 0.0 if begin is None else dist(begin, lanes.places[0])
        cost = lanes.length + start + turn * len(lanes.lanes)
        if cost < least - _SMALL:
            best, least = lanes, cost
    assert best is not None
    return best


def _axes(area: Polygon | MultiPolygon) -> list[float]:
    """The directions worth trying: those of the sides, of the hull's too, and some between."""
    found = [k * _STEP for k in range(round(pi / _STEP))]
    for outline in (*_outlines(area), area.convex_hull.exterior):
        for a, b in pairwise(outline.coords):
            found.append(float(np.arctan2(b[1] - a[1], b[0] - a[0])) % pi)
    # Those of long sides come first, so that of equal ones they are taken.
    return list(dict.fromkeys(round(angle, 6) for angle in reversed(found)))


def _polygons(geometry: Any) -> list[Polygon]:
    return [part for part in shapely.get_parts(geometry) if isinstance(part, Polygon)]


def _outlines(area: Polygon | MultiPolygon) -> Iterable[Any]:
    for part in _polygons(area):
        yield part.exterior
        yield from part.interiors


def _length(places: Sequence[XY]) -> float:
    return sum(dist(a, b) for a, b in pairwise(places))


# -- strips -------------------------------------------------------------------------------------


class _Strips:
    """An area cut into strips along one direction. Places are turned so that it is that of x."""

    def __init__(self, area: Polygon | MultiPolygon, footprint: Footprint, axis: float) -> None:
        self.axis = axis
        self._ahead, self._beside = footprint.ahead, footprint.beside
        area = shapely.transform(area, lambda places: _turned(places, -axis))
        west, low, east, high = area.bounds
        count = max(1, ceil((high - low) / footprint.across - 1e-9))
        if high - low < 1e-3 or count > _MOST_LANES:
            message = f"an area {high - low:.3g} m wide cannot be flown over in {count} lanes"
            raise Unflyable(message, "area")
        self._edges: list[float] = np.linspace(low, high, count + 1).tolist()
        boxes = shapely.box(west - 1, self._edges[:-1], east + 1, self._edges[1:])
        cut = shapely.intersection(area, boxes)
        self._parts = [[part for part in _polygons(each) if part.area > _SMALL] for each in cut]
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
            and width <= self._beside
            and any(self._has_lane_beside(other, part) for other in self._parts[number])
            for number, width in sides
        )

    def _has_lane_beside(self, other: Polygon, part: Polygon) -> bool:
        """Whether the lane of another part leads along the whole of a part."""
        (west, _, east, _), (begin, low, end, high) = part.bounds, other.bounds
        return begin <= west and east <= end and high - low > self._beside and _touch(part, other)

    def estimate(self, turn: float) -> float:
        """About what it costs: the lengths of all parts, and a turn with its way for each."""
        way = 0.0
        for parts in self._parts:
            for part in parts:
                west, _, east, _ = part.bounds
                way += max(0.0, east - west - 2 * self._ahead) + turn
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
                lane = self._lane(part, k)
                (before,) = joints[number] if len(joints[number]) == 1 else (None,)
                alone = before is not None and sum(before in each for each in joints) == 1
                if before is not None and alone:
                    cell = numbers[-1][before]
                    cells[cell].append(lane)
                else:
                    cell = len(cells)
                    cells.append([lane])
                row.append(cell)
            numbers.append(row)
        return [[self._back(lane) for lane in cell] for cell in cells]

    def _lane(self, part: Polygon, k: int) -> tuple[XY, ...]:
        """The places from which one part of a strip is seen, from west to east."""
        west, east = self._extent(part, k)
        first, last = west + self._ahead, east - self._ahead
        if first >= last:
            first = last = (west + east) / 2
        middle = (self._edges[k] + self._edges[k + 1]) / 2
        centre = LineString([(self._span[0], middle), (self._span[1], middle)])
        pieces = sorted(_intervals(part.intersection(centre)))
        line: list[XY] = []
        if not pieces or first < pieces[0][0]:
            line.append(_within(part, first))
        for begin, end in pieces:
            begin, end = max(begin, first), min(end, last)
            if begin <= end:
                line += [(begin, middle), (end, middle)]
        if not pieces or last > pieces[-1][1]:
            line.append(_within(part, last))
        return tuple(dict.fromkeys(line))

    def _extent(self, part: Polygon, k: int) -> XY:
        """From where to where a part must be seen from its own lane."""
        last = len(self._parts) - 1
        low = self._edges[k] + (self._beside if k > 0 else 0.0)
        high = self._edges[k + 1] - (self._beside if k < last else 0.0)
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
    return bool(a.intersection(b).length > _SMALL)


def _intervals(geometry: Any) -> list[XY]:
    """The intervals of x of the lines in a geometry."""
    lines = [part for part in shapely.get_parts(geometry) if isinstance(part, LineString)]
    return [(line.bounds[0], line.bounds[2]) for line in lines if line.length > _SMALL]


def _within(part: Polygon, x: float) -> XY:
    """A place of a polygon at x: the middle of the longest piece there."""
    _, low, _, high = part.bounds
    cut = part.intersection(LineString([(x, low - 1), (x, high + 1)]))
    pieces = [each for each in shapely.get_parts(cut) if not each.is_empty]
    longest = max(pieces, key=lambda piece: piece.length)
    return x, (longest.bounds[1] + longest.bounds[3]) / 2


# -- ways inside --------------------------------------------------------------------------------


class _Inside:
    """The shortest ways inside an area: straight, or round its inner corners.

    (The visibility graph: T. Lozano-Pérez, M. Wesley, *An Algorithm for Planning Collision-Free
    Paths Among Polyhedral Obstacles*, 1979.)
    """

    def __init__(self, area: Polygon | MultiPolygon) -> None:
        self._area = area.buffer(1e-4, join_style="mitre")
        shapely.prepare(self._area)
        self._corners = [
            self._cleared(*corner)
            for part in _polygons(area)
            for outline in (orient(part).exterior, *orient(part).interiors)
            for corner in _inner_corners([(x, y) for x, y in outline.coords[:-1]])
        ]
        count = len(self._corners)
        self._ways = np.full((count, count), inf)
        self._next = np.tile(np.arange(count), (count, 1))
        if not count:
            return
        np.fill_diagonal(self._ways, 0.0)
        for k, corner in enumerate(self._corners):
            self._ways[k] = np.minimum(self._ways[k], self._seen_from(corner))
        for k in range(count):  # Floyd and Warshall
            through = self._ways[:, k, None] + self._ways[None, k, :]
            shorter = through < self._ways - _SMALL
            self._ways = np.where(shorter, through, self._ways)
            self._next = np.where(shorter, self._next[:, k, None], self._next)

    def _cleared(self, corner: XY, away: XY) -> XY:
        """A place beside a corner, with some room if the area has it there."""
        for clear in (_CLEAR, _CLEAR / 3):
            place = (corner[0] + clear * away[0], corner[1] + clear * away[1])
            if shapely.covers(self._area, LineString([corner, place])):
                return place
        return corner

    def _seen_from(self, place: XY) -> Any:
        """The straight distances from a place to all corners; infinite where none is inside."""
        ends = np.array(self._corners)
        lines = shapely.linestrings(np.stack([np.broadcast_to(place, ends.shape), ends], axis=1))
        straight = np.hypot(*(ends - place).T)
        return np.where(shapely.covers(self._area, lines), straight, inf)

    def way(self, a: XY, b: XY) -> list[XY]:
        """The corners between two places; none where the way is straight, or nothing helps."""
        if dist(a, b) < _SMALL or shapely.covers(self._area, LineString([a, b])):
            return []
        if not self._corners:
            return []
        total = self._seen_from(a)[:, None] + self._ways + self._seen_from(b)[None, :]
        here, last = np.unravel_index(int(np.argmin(total)), total.shape)
        if total[here, last] == inf:
            return []
        found = [int(here)]
        while found[-1] != last:
            found.append(int(self._next[found[-1], last]))
        return [self._corners[k] for k in found]


def _inner_corners(outline: Sequence[XY]) -> Iterable[tuple[XY, XY]]:
    """The corners of an outline round which a way can lead, and the direction away from each.

    The area lies left of the outline.
    """
    for before, corner, after in zip(
        [outline[-1], *outline[:-1]], outline, [*outline[1:], outline[0]], strict=True
    ):
        ux, uy = _unit(before, corner)
        vx, vy = _unit(corner, after)
        if ux * vy - uy * vx < -_SMALL:
            away = (ux - vx, uy - vy)
            size = hypot(*away)
            yield corner, (away[0] / size, away[1] / size)


def _unit(a: XY, b: XY) -> XY:
    length = dist(a, b) or 1.0
    return (b[0] - a[0]) / length, (b[1] - a[1]) / length


# -- order --------------------------------------------------------------------------------------

_Cell = list[tuple[XY, ...]]


class _Flown:
    """A cell as it is flown from one of its four corners."""

    def __init__(self, cell: _Cell, upwards: bool, eastwards: bool, inside: _Inside) -> None:
        self.lanes: list[Lane] = []
        for number, lane in enumerate(cell if upwards else cell[::-1]):
            turned = lane[::-1]
            if number == 0:
                line = lane if eastwards else turned
            else:
                here = self.lanes[-1].line[-1]
                line = lane if dist(here, lane[0]) <= dist(here, turned[0]) else turned
            approach = inside.way(self.lanes[-1].line[-1], line[0]) if self.lanes else []
            self.lanes.append(Lane(tuple(approach), _joined(line, inside)))
        self.begin, self.end = self.lanes[0].line[0], self.lanes[-1].line[-1]
        self.length = _length([p for lane in self.lanes for p in (*lane.approach, *lane.line)])


def _joined(line: tuple[XY, ...], inside: _Inside) -> tuple[XY, ...]:
    """The places of a lane, with the corners round which it leads from one to the next."""
    joined = [line[0]]
    for a, b in pairwise(line):
        joined += [*inside.way(a, b), b]
    return tuple(joined)


def _ordered(cells: Sequence[_Cell], axis: float, inside: _Inside, begin: XY | None) -> Lanes:
    """All lanes, cell by cell, in a short order."""
    choices = [
        [
            _Flown(cell, upwards, eastwards, inside)
            for upwards in ((True, False) if len(cell) > 1 else (True,))
            for eastwards in (True, False)
        ]
        for cell in cells
    ]
    ways = _Ways(choices, inside)
    tours = (
        _greedy(choices, ways, (cell, turn))
        for cell, turns in enumerate(choices)
        for turn in range(len(turns))
    )
    tour = min(tours, key=lambda tour: ways.length(tour, begin))
    tour = _improved(tour, choices, ways, begin)
    lanes: list[Lane] = []
    for cell, turn in tour:
        first, *others = choices[cell][turn].lanes
        approach = inside.way(lanes[-1].line[-1], first.line[0]) if lanes else []
        lanes += [Lane(tuple(approach), first.line), *others]
    return Lanes(tuple(lanes), axis)


_Stop = tuple[int, int]
"""A cell, and how it is flown."""


class _Ways:
    """The lengths of ways between cells, each worked out once."""

    def __init__(self, choices: Sequence[Sequence[_Flown]], inside: _Inside) -> None:
        self._choices, self._inside = choices, inside
        self._known: dict[tuple[_Stop, _Stop], float] = {}

    def between(self, a: _Stop, b: _Stop) -> float:
        if (a, b) not in self._known:
            end, begin = self._choices[a[0]][a[1]].end, self._choices[b[0]][b[1]].begin
            self._known[a, b] = _length([end, *self._inside.way(end, begin), begin])
        return self._known[a, b]

    def length(self, tour: Sequence[_Stop], begin: XY | None) -> float:
        first = self._choices[tour[0][0]][tour[0][1]]
        way = 0.0 if begin is None else dist(begin, first.begin)
        way += sum(self._choices[cell][turn].length for cell, turn in tour)
        return way + sum(self.between(a, b) for a, b in pairwise(tour))


def _greedy(choices: Sequence[Sequence[_Flown]], ways: _Ways, first: _Stop) -> list[_Stop]:
    """Always to the cell that is nearest."""
    tour, left = [first], set(range(len(choices))) - {first[0]}
    while left:
        tour.append(
            min(
                ((cell, turn) for cell in sorted(left) for turn in range(len(choices[cell]))),
                key=lambda stop: ways.between(tour[-1], stop),
            )
        )
        left.discard(tour[-1][0])
    return tour


def _improved(
    tour: list[_Stop], choices: Sequence[Sequence[_Flown]], ways: _Ways, begin: XY | None
) -> list[_Stop]:
    """Move single cells, or turn how they are flown, as long as that makes the way shorter."""
    least = ways.length(tour, begin)
    found = True
    while found:
        found = False
        for other in _neighbours(tour, choices):
            length = ways.length(other, begin)
            if length < least - _SMALL:
                tour, least, found = other, length, True
                break
    return tour


def _neighbours(tour: list[_Stop], choices: Sequence[Sequence[_Flown]]) -> Iterable[list[_Stop]]:
    for k, (cell, _) in enumerate(tour):
        others = tour[:k] + tour[k + 1 :]
        for place in range(len(tour)):
            for turn in range(len(choices[cell])):
                yield [*others[:place], (cell, turn), *others[place:]]
