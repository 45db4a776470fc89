"""Lines of straight legs in a plane, and where they meet. Metres."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product
from math import dist

XY = tuple[float, float]


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
