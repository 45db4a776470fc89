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
from functools import cached_property, lru_cache
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
_AT_LEAST = 0.8
"""Share of its estimate that a way takes at the least."""
_SPLITS = 3
"""How often a part of a strip that is forked is split into halves."""
_MISSED = 0.06
"""Area that may be missed in a part of a strip, in squares as wide as the strip."""
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
    turn = _TURN * speed
    best, least = None, inf
    for plan in _plans(tuple(corners), outlines, footprint, turn, axis):
        if _AT_LEAST * plan.estimate > least:
            break
        lanes = plan.ordered(begin)
        start = 0.0 if begin is None else dist(begin, lanes.places[0])
        cost = lanes.length + start + turn * len(lanes.lanes)
        if cost < least - _SMALL:
            best, least = lanes, cost
    assert best is not None
    return best


@lru_cache(maxsize=32)
def _plans(
    corners: tuple[XY, ...],
    holes: tuple[tuple[XY, ...], ...],
    footprint: Footprint,
    turn: float,
    axis: float | None,
) -> list[_Plan]:
    """The most promising directions, the best one first, with what is worked out for them."""
    area = area_of(corners, holes)
    inside = _Inside(area)
    axes = [axis] if axis is not None else _axes(area)
    strips = [_Strips(area, footprint, each) for each in axes]
    plans = [_Plan(each, each.estimate(turn), inside) for each in strips]
    return sorted(plans, key=lambda plan: plan.estimate)[:_TRIED]


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
        self._footprint = footprint
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
            if over + _SMALL < x < begin - _SMALL:  # else it is an end of a piece of the middle
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
        for piece in _polygons(cut):
            if piece.area > _SMALL:
                extent = piece.bounds[0], piece.bounds[2]
                lines += _lines(piece, extent, half, footprint, splits)
    return lines


def _towards(middle: float, bottom: float, top: float) -> float:
    """The number between two others that is nearest to a middle, with some room if there is."""
    room = min(_CLEAR, (top - bottom) / 2)
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
    long = [(bottom, top) for _, bottom, _, top in found if top - bottom > _SMALL]
    return long or [(bottom, top) for _, bottom, _, top in found]


# -- ways inside --------------------------------------------------------------------------------


class _Inside:
    """The shortest ways inside an area: straight, or round its inner corners.

    (The visibility graph: T. Lozano-Pérez, M. Wesley, *An Algorithm for Planning Collision-Free
    Paths Among Polyhedral Obstacles*, 1979.)
    """

    def __init__(self, area: Polygon | MultiPolygon) -> None:
        self._area = area.buffer(1e-4, join_style="mitre")
        shapely.prepare(self._area)
        self._known: dict[XY, Any] = {}
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
        if place not in self._known:
            self._known[place] = self._distances(place)
        return self._known[place]

    def _distances(self, place: XY) -> Any:
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


class _Plan:
    """The lanes of one direction, before their order is chosen."""

    def __init__(self, strips: _Strips, estimate: float, inside: _Inside) -> None:
        self.estimate = estimate
        """About what it costs (see :meth:`_Strips.estimate`)."""
        self._strips, self._inside = strips, inside

    @cached_property
    def _choices(self) -> list[list[_Flown]]:
        """Each cell, flown from each of its corners."""
        return [
            [
                _Flown(cell, upwards, eastwards, self._inside)
                for upwards in ((True, False) if len(cell) > 1 else (True,))
                for eastwards in (True, False)
            ]
            for cell in self._strips.cells()
        ]

    @cached_property
    def _ways(self) -> _Ways:
        return _Ways(self._choices, self._inside)

    def ordered(self, begin: XY | None) -> Lanes:
        """All lanes, cell by cell, in a short order for whoever comes from ``begin``."""
        choices, ways = self._choices, self._ways
        tours = (
            _greedy(choices, ways, (cell, turn))
            for cell, turns in enumerate(choices)
            for turn in range(len(turns))
        )
        tour = min(tours, key=lambda tour: ways.length(tour, begin))
        lanes: list[Lane] = []
        for cell, turn in _improved(tour, choices, ways, begin):
            first, *others = choices[cell][turn].lanes
            approach = self._inside.way(lanes[-1].line[-1], first.line[0]) if lanes else []
            lanes += [Lane(tuple(approach), first.line), *others]
        return Lanes(tuple(lanes), self._strips.axis)


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
