"""Coverage: the lanes over an area from which a vehicle sees all of it.

For a direction the area is cut into strips, one lane in the middle of each, and these are joined to
cells, which are flown to and fro (see :mod:`behaviors.strips`). Cells are flown in an order that is
short, and between lanes the way leads round the corners of the area and its holes and never across
what lies outside. Of all directions that take the least time is chosen.

Metres over the ground, radians counter-clockwise from east.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from math import dist, inf, pi

import numpy as np
from shapely import MultiPolygon, Polygon

from behaviors.polygons import SMALL, area_of, outlines
from behaviors.strips import Footprint, Strips
from behaviors.ways_inside import WaysInside
from vencejo.polylines import XY

_STEP = pi / 36
"""Directions that are tried, beside those of all sides of the area, are so far apart."""
_TRIED = 8
"""Directions whose whole way is worked out: the most promising ones."""
_AT_LEAST = 0.8
"""Share of its estimate that a way takes at the least."""
_TURN = 1.0
"""Seconds that a turn from one lane into the next costs beside its way."""


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
    around = tuple(tuple(hole) for hole in holes)
    turn = _TURN * speed
    best, least = None, inf
    for plan in _plans(tuple(corners), around, footprint, turn, axis):
        if _AT_LEAST * plan.estimate > least:
            break
        lanes = plan.ordered(begin)
        start = 0.0 if begin is None else dist(begin, lanes.places[0])
        cost = lanes.length + start + turn * len(lanes.lanes)
        if cost < least - SMALL:
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
    inside = WaysInside(area)
    axes = [axis] if axis is not None else _axes(area)
    strips = [Strips(area, footprint, each) for each in axes]
    plans = [_Plan(each, each.estimate(turn), inside) for each in strips]
    return sorted(plans, key=lambda plan: plan.estimate)[:_TRIED]


def _axes(area: Polygon | MultiPolygon) -> list[float]:
    """The directions worth trying: those of the sides, of the hull's too, and some between."""
    found = [k * _STEP for k in range(round(pi / _STEP))]
    for outline in (*outlines(area), area.convex_hull.exterior):
        for a, b in pairwise(outline.coords):
            found.append(float(np.arctan2(b[1] - a[1], b[0] - a[0])) % pi)
    # Those of sides come first, so that of equal ones they are taken, and as they are: a millionth
    # of a radian makes an area wider, which can take one lane more.
    different: dict[float, float] = {}
    for angle in reversed(found):
        different.setdefault(round(angle, 6), angle)
    return list(different.values())


def _length(places: Sequence[XY]) -> float:
    return sum(dist(a, b) for a, b in pairwise(places))


_Cell = list[tuple[XY, ...]]


class _Flown:
    """A cell as it is flown from one of its four corners."""

    def __init__(self, cell: _Cell, upwards: bool, eastwards: bool, inside: WaysInside) -> None:
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


def _joined(line: tuple[XY, ...], inside: WaysInside) -> tuple[XY, ...]:
    """The places of a lane, with the corners round which it leads from one to the next."""
    joined = [line[0]]
    for a, b in pairwise(line):
        joined += [*inside.way(a, b), b]
    return tuple(joined)


class _Plan:
    """The lanes of one direction, before their order is chosen."""

    def __init__(self, strips: Strips, estimate: float, inside: WaysInside) -> None:
        self.estimate = estimate
        """About what it costs (see :meth:`Strips.estimate`)."""
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

    def __init__(self, choices: Sequence[Sequence[_Flown]], inside: WaysInside) -> None:
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
            if length < least - SMALL:
                tour, least, found = other, length, True
                break
    return tour


def _neighbours(tour: list[_Stop], choices: Sequence[Sequence[_Flown]]) -> Iterable[list[_Stop]]:
    for k, (cell, _) in enumerate(tour):
        others = tour[:k] + tour[k + 1 :]
        for place in range(len(tour)):
            for turn in range(len(choices[cell])):
                yield [*others[:place], (cell, turn), *others[place:]]
