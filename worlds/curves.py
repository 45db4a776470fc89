"""Polylines and smooth curves through points, in two or three dimensions, metres."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import acos, ceil, dist, inf

_STEP = 0.5
"""Curves are sampled about this densely, metres."""
_MOST_SAMPLES = 64
"""Largest number of samples of one span."""

Coordinates = tuple[float, ...]


def smooth(
    points: Sequence[Coordinates], closed: bool = False, most_bend: float = inf
) -> list[Coordinates]:
    """Sample a centripetal Catmull-Rom spline through all points.

    A closed one ends at its first point. ``most_bend``: about the greatest bend between samples,
    radians. Centripetal: knots are a square root of the distance apart, so the curve makes no loops
    between points (C. Yuksel et al., *Parameterization and applications of Catmull-Rom curves*,
    2011).
    """
    if closed:
        around = [points[-1], *points, points[0], points[1]]
    else:
        # The span at each end is mirrored beyond it: so the curve is straight at its ends.
        around = [_mirrored(points[1], points[0]), *points, _mirrored(points[-2], points[-1])]
    curve = [tuple(points[0])]
    for k in range(1, len(around) - 2):
        controls = around[k - 1], around[k], around[k + 1], around[k + 2]
        samples = min(_MOST_SAMPLES, max(1, ceil(dist(around[k], around[k + 1]) / _STEP)))
        span = _span(*controls, samples)
        sharpest = _sharpest_bend([around[k], *span])
        if sharpest > most_bend:
            span = _span(*controls, samples * ceil(sharpest / most_bend))
        curve.extend(span)
    return curve


def _sharpest_bend(points: Sequence[Coordinates]) -> float:
    """The greatest bend of a polyline, radians."""
    sharpest = 0.0
    for (a, b), (_, c) in pairwise(pairwise(points)):
        along = sum((v - u) * (w - v) for u, v, w in zip(a, b, c, strict=True))
        share = along / (dist(a, b) * dist(b, c))
        sharpest = max(sharpest, acos(max(-1.0, min(1.0, share))))
    return sharpest


def _span(
    a: Coordinates, b: Coordinates, c: Coordinates, d: Coordinates, samples: int
) -> list[Coordinates]:
    """Sample the curve from b (left out) to c.

    P. J. Barry, R. N. Goldman, *A recursive evaluation algorithm for a class of Catmull-Rom
    splines*, SIGGRAPH 1988.
    """
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
    """Interpolate linearly between p at ``begin`` and q at ``end``."""
    share = (t - begin) / (end - begin)
    return tuple(u + (v - u) * share for u, v in zip(p, q, strict=True))


def _mirrored(p: Coordinates, at: Coordinates) -> Coordinates:
    """The point as far behind ``at`` as p is before it."""
    return tuple(2 * v - u for u, v in zip(p, at, strict=True))


def without_repeats(points: Sequence[Coordinates]) -> list[Coordinates]:
    """The points, without any that equals the one before it."""
    return [points[0], *(b for a, b in pairwise(points) if a != b)]


def length(points: Sequence[Coordinates]) -> float:
    """The length of a polyline."""
    return sum(dist(a, b) for a, b in pairwise(points))


def piece(points: Sequence[Coordinates], begin: float, end: float) -> list[Coordinates]:
    """The part of a polyline between two distances along it."""
    passed, found = 0.0, list[Coordinates]()
    for a, b in pairwise(points):
        leg = dist(a, b)
        if passed + leg > begin and passed < end:
            if not found:
                found.append(_mix(a, b, passed, passed + leg, max(begin, passed)))
            found.append(_mix(a, b, passed, passed + leg, min(end, passed + leg)))
        passed += leg
    return found


def every(points: Sequence[Coordinates], step: float) -> list[Coordinates]:
    """Places along a polyline from its beginning on, a step apart."""
    found, passed = list[Coordinates](), 0.0
    for a, b in pairwise(points):
        end = passed + dist(a, b)
        while len(found) * step < end:
            found.append(_mix(a, b, passed, end, len(found) * step))
        passed = end
    return found
