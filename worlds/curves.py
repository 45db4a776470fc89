"""Smooth curves through points, in two or three dimensions, metres."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, dist

_STEP = 0.5
"""Curves are sampled about this densely, metres."""
_MOST = 64
"""Samples of one span at most."""

Coordinates = tuple[float, ...]


def smooth(points: Sequence[Coordinates], closed: bool = False) -> list[Coordinates]:
    """A centripetal Catmull-Rom spline through all points, sampled; a closed one ends as it began.

    Centripetal (knots a square root of the distance apart), since it makes no loops of its own:
    C. Yuksel et al., *Parameterization and applications of Catmull-Rom curves*, 2011.
    """
    if closed:
        around = [points[-1], *points, points[0], points[1]]
    else:
        # Beyond each end, the end's own span mirrored: the curve begins and ends unbent.
        around = [_mirrored(points[1], points[0]), *points, _mirrored(points[-2], points[-1])]
    curve = [tuple(points[0])]
    for k in range(1, len(around) - 2):
        curve.extend(_span(around[k - 1], around[k], around[k + 1], around[k + 2]))
    return curve


def _span(a: Coordinates, b: Coordinates, c: Coordinates, d: Coordinates) -> list[Coordinates]:
    """The curve from b (left out) to c, by the pyramid of Barry and Goldman."""
    samples = min(_MOST, max(1, ceil(dist(b, c) / _STEP)))
    t0, t1 = 0.0, dist(a, b) ** 0.5
    t2 = t1 + dist(b, c) ** 0.5
    t3 = t2 + dist(c, d) ** 0.5
    curve = []
    for k in range(1, samples):
        t = t1 + (t2 - t1) * k / samples
        ab, bc, cd = _mix(a, b, t0, t1, t), _mix(b, c, t1, t2, t), _mix(c, d, t2, t3, t)
        curve.append(_mix(_mix(ab, bc, t0, t2, t), _mix(bc, cd, t1, t3, t), t1, t2, t))
    return [*curve, tuple(c)]


def _mix(p: Coordinates, q: Coordinates, begin: float, end: float, t: float) -> Coordinates:
    share = (t - begin) / (end - begin)
    return tuple(u + (v - u) * share for u, v in zip(p, q, strict=True))


def _mirrored(p: Coordinates, at: Coordinates) -> Coordinates:
    return tuple(2 * v - u for u, v in zip(p, at, strict=True))


def without_repeats(points: Sequence[Coordinates]) -> list[Coordinates]:
    """The points without those that are the same as the one before."""
    return [points[0], *(b for a, b in pairwise(points) if a != b)]


def length(points: Sequence[Coordinates]) -> float:
    """Of a polyline."""
    return sum(dist(a, b) for a, b in pairwise(points))


def piece(points: Sequence[Coordinates], begin: float, end: float) -> list[Coordinates]:
    """The part of a polyline between two ways along it."""
    way, found = 0.0, list[Coordinates]()
    for a, b in pairwise(points):
        step = dist(a, b)
        if way + step > begin and way < end:
            if not found:
                found.append(_mix(a, b, way, way + step, max(begin, way)))
            found.append(_mix(a, b, way, way + step, min(end, way + step)))
        way += step
    return found


def every(points: Sequence[Coordinates], step: float) -> list[Coordinates]:
    """Places along a polyline, a step apart."""
    found, way = list[Coordinates](), 0.0
    for a, b in pairwise(points):
        end = way + dist(a, b)
        while len(found) * step < end:
            found.append(_mix(a, b, way, end, len(found) * step))
        way = end
    return found
