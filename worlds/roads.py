"""Roads: painted on the ground along a line."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from vencejo.polylines import crossing_of
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
