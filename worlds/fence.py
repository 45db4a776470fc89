"""The fence of a world: the space that vehicles are meant to stay in. World frame, metres."""

from __future__ import annotations

from itertools import pairwise
from math import hypot, inf

from vencejo.geometry import Point
from vencejo.polylines import crossing_of, legs_meet
from worlds.values import COORDINATE, FLAT_SPOT, Field, Misfit, array, record
from worlds.world import Fence

XY = tuple[float, float]


def surrounds(fence: Fence, x: float, y: float) -> bool:
    """Whether a place on the map is inside a fence or on its line, at whatever height."""
    sides = _sides(fence)
    if any(_distance((x, y), a, b) < 1e-6 for a, b in sides):
        return True
    crossed = (  # by the line from here to the east
        (a[1] > y) != (b[1] > y) and x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        for a, b in sides
    )
    return sum(crossed) % 2 == 1


def leaves(fence: Fence, a: Point, b: Point) -> bool:
    """Whether a straight way leads out of a fence over the map, its ends included."""
    shares = [0.0, 1.0]
    for c, d in _sides(fence):
        if legs_meet(a[:2], b[:2], c, d):
            shares.append(_share_where_crossed(a, b, c, d))
    shares = sorted(min(1.0, max(0.0, share)) for share in shares)
    middles = ((low + high) / 2 for low, high in pairwise(shares))
    return not all(
        surrounds(fence, a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share)
        for share in (0.0, *middles, 1.0)
    )


def _sides(fence: Fence) -> list[tuple[XY, XY]]:
    return [*pairwise((*fence.corners, fence.corners[0]))]


def _share_where_crossed(a: Point, b: Point, c: XY, d: XY) -> float:
    """The share of a way at which it crosses a side; 0 where the two are parallel."""
    wide, deep = d[0] - c[0], d[1] - c[1]
    across = (b.x - a.x) * deep - (b.y - a.y) * wide
    return ((c[0] - a.x) * deep - (c[1] - a.y) * wide) / across if across else 0.0


def _distance(place: XY, a: XY, b: XY) -> float:
    wide, deep = b[0] - a[0], b[1] - a[1]
    along = (place[0] - a[0]) * wide + (place[1] - a[1]) * deep
    share = min(1.0, max(0.0, along / (wide * wide + deep * deep)))
    return hypot(place[0] - a[0] - share * wide, place[1] - a[1] - share * deep)


def _fence(through: tuple[XY, ...], floor: float, ceiling: float) -> Fence:
    if floor >= ceiling:
        raise Misfit("bad-fence", "the floor of a fence is below its ceiling", "floor")
    corners = through[:-1] if through[0] == through[-1] else through
    closed = (*corners, corners[0])
    if any(a == b for a, b in pairwise(closed)) or len(corners) < 3:
        raise Misfit("bad-fence", "a corner stands twice in a row in this fence", "through")
    crossed = crossing_of(closed)
    if crossed is not None:
        raise Misfit(
            "bad-fence",
            f"this fence crosses itself near [{crossed[0]:.1f}, {crossed[1]:.1f}]",
            "through",
            "name its corners in order, as one walks round it",
        )
    return Fence(corners, floor, ceiling)


FENCE = record(
    "a fence",
    {
        "through": Field(array("a fence is a list of three places or more", FLAT_SPOT, 3)),
        "floor": Field(COORDINATE, -inf),
        "ceiling": Field(COORDINATE, inf),
    },
    _fence,
)
