"""Roads: painted on the ground along a line."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise, product
from math import dist
from typing import NamedTuple

from worlds import curves
from worlds.colors import COLORS
from worlds.model import Road
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

XY = tuple[float, float]


class Draft(NamedTuple):
    """A road as written, its line sampled."""

    line: tuple[XY, ...]
    width: float
    color: Color
    edges: Color | None
    edge_width: float
    gaps: tuple[tuple[float, float], ...]

    def road(self, name: str) -> Road:
        return Road(name, self.line, self.width)


def _road(
    through: tuple[XY, ...],
    smooth: bool,
    loop: bool,
    crossing: bool,
    gaps: tuple[tuple[float, ...], ...],
    width: float,
    edge_width: float,
    color: Color,
    edges: Color | None,
) -> Draft:
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
    if edges is not None and 2 * edge_width >= width:
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
    return Draft(line, width, color, edges, edge_width, tuple((a, b) for a, b in sorted(gaps)))


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


def painted(roads: Iterable[Draft]) -> tuple[Stripe, ...]:
    """The stripes of some roads: first all edge lines, so that no road has one across it."""
    roads = list(roads)
    edges = [
        Stripe(line, road.width, road.edges)
        for road in roads
        if road.edges is not None
        for line in _pieces(road)
    ]
    surfaces = [
        Stripe(line, road.width - (2 * road.edge_width if road.edges else 0.0), road.color)
        for road in roads
        for line in _pieces(road)
    ]
    return (*edges, *surfaces)


def _pieces(road: Draft) -> list[tuple[XY, ...]]:
    """The line of a road without its gaps."""
    if not road.gaps:
        return [road.line]
    ends = [0.0, *(way for gap in road.gaps for way in gap), curves.length(road.line)]
    spans = zip(ends[::2], ends[1::2], strict=True)
    pieces = [curves.piece(road.line, begin, end) for begin, end in spans if begin < end]
    return [tuple((x, y) for x, y in piece) for piece in pieces]


def crossing_of(line: Sequence[XY]) -> XY | None:
    """A place where a polyline meets itself, beside its ends meeting."""
    legs = list(pairwise(line))
    corners = zip(legs, legs[1:] + legs[:1] if line[0] == line[-1] else legs[1:], strict=False)
    for (a, b), (_, c) in corners:
        # Legs that follow each other meet in their corner alone, but for those that turn back.
        if (
            _side(a, b, c) == 0
            and (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) < 0
        ):
            return b
    side = max(dist(a, b) for a, b in legs)
    # Legs that meet begin less than two sides apart: in cells that are next but one at most.
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
    """Above 0 when p is left of the line from a to b."""
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
