"""Roads: painted on the ground along a line."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise, product
from math import dist
from typing import Any, NamedTuple

from worlds import curves
from worlds.colors import COLORS
from worlds.things import Color, Stripe
from worlds.values import (
    COLOR,
    COORDINATE,
    FLAG,
    FLAT_SPOT,
    SIZE,
    Field,
    Misfit,
    array,
    record,
)
from worlds.world import Road

XY = tuple[float, float]


class RoadPaint(NamedTuple):
    """The look of a road; metres."""

    width: float
    """Edge lines included."""
    color: Color
    edges: Color | None
    """The colour of edge lines; None for no lines."""
    edge_width: float


class RoadDraft(NamedTuple):
    """A road as written, its line sampled; the world gives it a name."""

    line: tuple[XY, ...]
    """The centre line, metres."""
    gaps: tuple[tuple[float, float], ...]
    """From and to, in metres along the line, in order."""
    paint: RoadPaint

    def road(self, name: str) -> Road:
        return Road(name, self.line, self.paint.width)


def _road(
    through: tuple[XY, ...],
    smooth: bool,
    loop: bool,
    crossing: bool,
    gaps: tuple[tuple[float, ...], ...],
    **paint: Any,
) -> RoadDraft:
    """The road of the values of ROAD. Raises Misfit."""
    points: Sequence[curves.Coordinates] = [*through, through[0]] if loop else through
    if len(curves.without_repeats(points)) < len(points):
        raise Misfit(
            "bad-path",
            "a point stands twice in a row in this road",
            "through",
            "a loop leads back by itself: leave its last point out" if loop else None,
        )
    if smooth:
        points = curves.smooth(through, loop)
    line = tuple((x, y) for x, y in points)
    crossed = None if crossing else crossing_of(line)
    if crossed is not None:
        raise Misfit(
            "road-crosses-itself",
            f"this road crosses itself near [{crossed[0]:.1f}, {crossed[1]:.1f}]",
            "through",
            "move its points, or write `crossing: true`",
        )
    painted = RoadPaint(**paint)
    if painted.edges is not None and 2 * painted.edge_width >= painted.width:
        raise Misfit("bad-size", "the edge lines leave nothing of the road", "edge_width")
    long = curves.length(line)
    for begin, end in gaps:
        if not 0 <= begin < end <= long:
            raise Misfit(
                "bad-gap",
                f"a gap from {begin:g} to {end:g} m; the road is {long:.1f} m long",
                "gaps",
                "a gap is [from, to] in metres along the road",
            )
    return RoadDraft(line, tuple((a, b) for a, b in sorted(gaps)), painted)


ROAD = record(
    "a road",
    {
        "through": Field(array("a road is a list of two places or more", FLAT_SPOT, 2)),
        "smooth": Field(FLAG, False),
        "loop": Field(FLAG, False),
        "crossing": Field(FLAG, False),
        "width": Field(SIZE, 3.0),
        "color": Field(COLOR, COLORS["asphalt"]),
        "edges": Field(COLOR, None),
        "edge_width": Field(SIZE, 0.15),
        "gaps": Field(
            array(
                "gaps are a list of [from, to] in metres along the road",
                array("a gap is [from, to] in metres along the road", COORDINATE, 2, 2),
                0,
            ),
            (),
        ),
    },
    _road,
)


def stripes_of(roads: Iterable[RoadDraft]) -> tuple[Stripe, ...]:
    """The stripes that paint some roads: first all edge lines, so that none lies across a road."""
    painted = [(line, road.paint) for road in roads for line in _pieces(road)]
    edges = [
        Stripe(line, paint.width, paint.edges) for line, paint in painted if paint.edges is not None
    ]
    surfaces = [
        Stripe(line, paint.width - (2 * paint.edge_width if paint.edges else 0.0), paint.color)
        for line, paint in painted
    ]
    return (*edges, *surfaces)


def _pieces(road: RoadDraft) -> list[tuple[XY, ...]]:
    """The parts of a road's line between its gaps."""
    if not road.gaps:
        return [road.line]
    ends = [0.0, *(end for gap in road.gaps for end in gap), curves.length(road.line)]
    spans = zip(ends[::2], ends[1::2], strict=True)
    pieces = [curves.piece(road.line, begin, end) for begin, end in spans if begin < end]
    return [tuple((x, y) for x, y in piece) for piece in pieces]


def crossing_of(line: Sequence[XY]) -> XY | None:
    """A place where a polyline crosses or touches itself; None for none. Its ends may meet."""
    legs = list(pairwise(line))
    corners = zip(legs, legs[1:] + legs[:1] if line[0] == line[-1] else legs[1:], strict=False)
    for (a, b), (_, c) in corners:
        # Legs that follow each other share their corner alone, unless the second turns right back.
        if (
            _side(a, b, c) == 0
            and (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0
        ):
            return b
    side = max(dist(a, b) for a, b in legs)
    # In a grid of cells as large as the longest leg, legs that meet begin at most two cells apart.
    cells: dict[tuple[int, int], list[int]] = {}
    places = [(int(a[0] // side), int(a[1] // side)) for a, _ in legs]
    for k, cell in enumerate(places):
        cells.setdefault(cell, []).append(k)
    around = list(product(range(-2, 3), repeat=2))
    for k, (i, j) in enumerate(places):
        for di, dj in around:
            for other in cells.get((i + di, j + dj), ()):
                closing = k == 0 and other == len(legs) - 1 and line[0] == line[-1]
                if other > k + 1 and not closing and legs_meet(*legs[k], *legs[other]):
                    return legs[other][0]
    return None


def legs_meet(a: XY, b: XY, c: XY, d: XY) -> bool:
    """Whether two straight legs have a point in common."""
    beside = any(
        max(a[k], b[k]) < min(c[k], d[k]) or max(c[k], d[k]) < min(a[k], b[k]) for k in (0, 1)
    )
    return (
        not beside and _side(a, b, c) * _side(a, b, d) <= 0 and _side(c, d, a) * _side(c, d, b) <= 0
    )


def _side(a: XY, b: XY, p: XY) -> float:
    """Above 0 where p is left of the line from a to b, 0 where it is on it."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
