"""Which pixels convex polygons cover: exactly those whose centres lie inside.

OpenCV's own polygons are half a pixel too large all round and inexact at their edges; its fill is
fast, though, and exact for outlines on whole pixels. So the outline of the covered pixels is
worked out here, for all polygons of a picture at once, and OpenCV fills it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Spans:
    """Rows of pixels that polygons cover, those of one polygon together and from top to bottom."""

    polygon: Ints
    """Index of the polygon, for each row."""
    y: Ints
    left: Ints
    """First pixel."""
    right: Ints
    """Last pixel."""


@dataclass(frozen=True, eq=False)
class Outlines:
    """Outlines of covered pixels, to be filled by ``cv2.fillConvexPoly``."""

    points: NDArray[np.int32]
    """(n, 2)."""
    polygon: list[int]
    """Whose outline it is; a thin polygon may have several, or none."""
    start: list[int]
    """First point of each, and the end of the last."""


def spans(points: Floats, starts: Ints, width: int, height: int) -> Spans:
    """The pixels of polygons in a picture.

    ``points`` (n, 2) are x and y, pixel centres being whole numbers; ``starts`` gives each
    polygon's first point, and the number of points at its end. The points go counter-clockwise
    as seen (down the left side).
    """
    counts = np.diff(starts)
    first = starts[:-1]
    if not len(first):
        none = np.zeros(0, np.int64)
        return Spans(none, none, none, none)
    following = np.arange(1, len(points) + 1)
    following[starts[1:] - 1] = first
    x, y = points[:, 0], points[:, 1]
    # Every edge from its upper to its lower end, so that faces that share it agree.
    rising = y[following] < y
    upper, lower = np.arange(len(points)), following
    upper[rising], lower[rising] = lower[rising], upper[rising]
    rows = np.minimum(np.maximum(np.ceil(y), 0), height).astype(np.int64)
    begin, number = rows[upper], rows[lower] - rows[upper]
    ends = np.cumsum(number)
    edge = np.repeat(np.arange(len(points)), number)
    row = np.arange(len(edge)) - (ends - number - begin)[edge]
    fall = y[lower] - y[upper]
    slope = (x[lower] - x[upper]) / np.where(fall > 0, fall, 1.0)
    crossing = (x[upper] - slope * y[upper])[edge] + slope[edge] * row
    crossing = np.ceil(np.minimum(np.maximum(crossing, -1.0), width + 1.0)).astype(np.int64)
    top = np.minimum.reduceat(rows, first)
    heights = np.maximum.reduceat(rows, first) - top
    row_ends = np.cumsum(heights)
    owner = np.repeat(np.arange(len(first)), counts)
    slot = row + (row_ends - heights - top)[owner][edge]
    left = np.zeros(int(row_ends[-1]), np.int64)
    right = np.full(len(left), -1)
    side = rising[edge]
    left[slot[~side]] = np.maximum(crossing[~side], 0)
    right[slot[side]] = np.minimum(crossing[side], width) - 1
    polygon = np.repeat(np.arange(len(first)), heights)
    ys = np.arange(len(left)) - (row_ends - heights - top)[polygon]
    covered = left <= right
    return Spans(polygon[covered], ys[covered], left[covered], right[covered])


def outlines(covered: Spans) -> Outlines:
    """The outlines of covered pixels, on whole pixels: steps that are level or upright."""
    polygon, y, left, right = covered.polygon, covered.y, covered.left, covered.right
    count = len(y)
    if not count:
        return Outlines(np.zeros((0, 2), np.int32), [], [0])
    joined = np.zeros(count + 1, bool)
    """Whether a row hangs together with the one before."""
    joined[1:-1] = (
        (polygon[1:] == polygon[:-1])
        & (y[1:] == y[:-1] + 1)
        & (left[1:] <= right[:-1])
        & (right[1:] >= left[:-1])
    )
    first = np.flatnonzero(~joined[:-1])
    sizes = np.diff(np.append(first, count))
    base = np.repeat(4 * first, sizes)
    depth = 2 * (np.arange(count) - base // 4)
    end = base + np.repeat(4 * sizes, sizes)
    # Between a row and the next the outline steps on the row where both are covered.
    below = np.minimum(np.arange(count) + joined[1:], count - 1)
    points = np.empty((4 * count, 2), np.int32)
    down, up = base + depth, end - depth
    points[down, 0] = right
    points[down + 1, 0] = np.minimum(right, right[below])
    points[down + 1, 1] = np.where(right[below] > right, y[below], y)
    points[up - 1, 0] = left
    points[up - 2, 0] = np.maximum(left, left[below])
    points[up - 2, 1] = np.where(left[below] < left, y[below], y)
    points[down, 1] = points[up - 1, 1] = y
    return Outlines(points, polygon[first].tolist(), [*(4 * first).tolist(), 4 * count])
