"""Scan conversion: the pixels that convex polygons cover, exactly those whose centres lie inside.

OpenCV's own polygons are half a pixel too large all round and inexact at their edges; its fill is
fast, though, and exact for outlines on whole pixels. So the outline of the covered pixels is
computed here, for all polygons of an image at once, and OpenCV fills it.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np

from hal.scene.arrays import Float64s, Int32s, Int64s


@dataclass(frozen=True, eq=False)
class Scanlines:
    """Runs of pixels that polygons cover: one run per polygon and row.

    The runs of one polygon follow each other, from top to bottom.
    """

    polygon: Int64s
    """Index of the polygon, for each run."""
    y: Int64s
    """Row of the image."""
    left: Int64s
    """First column."""
    right: Int64s
    """Last column, itself covered."""

    def without(self, count: int) -> Scanlines:
        """Those of all polygons but the first ``count``, which are numbered anew."""
        first = int(np.searchsorted(self.polygon, count))
        return Scanlines(
            self.polygon[first:] - count, self.y[first:], self.left[first:], self.right[first:]
        )


@dataclass(frozen=True, eq=False)
class Outlines:
    """Outlines of covered pixels, to be filled by ``cv2.fillConvexPoly``.

    A thin polygon may have several outlines, or none.
    """

    points: Int32s
    """Columns and rows, (n, 2), of all outlines one after the other."""
    polygon: list[int]
    """Index of the polygon, for each outline."""
    start: list[int]
    """First point of each outline, and the number of points at the end."""

    def without(self, count: int) -> Outlines:
        """Those of all polygons but the first ``count``, which are numbered anew."""
        first = bisect_left(self.polygon, count)
        polygon = [number - count for number in self.polygon[first:]]
        return Outlines(self.points, polygon, self.start[first:])


def scan_convert(points: Float64s, starts: Int64s, width: int, height: int) -> Scanlines:
    """The pixels of an image of that size that convex polygons cover.

    ``points`` (n, 2) are x and y in pixels, where pixel centres are whole numbers; ``starts`` is
    the index of each polygon's first point, and the number of points at its end. The points go
    counter-clockwise as seen in the image (down the left side).
    """
    counts = np.diff(starts)
    first = starts[:-1]
    if not len(first):
        none = np.zeros(0, np.int64)
        return Scanlines(none, none, none, none)
    following = np.arange(1, len(points) + 1)
    following[starts[1:] - 1] = first
    x, y = points[:, 0], points[:, 1]
    # Every edge is followed from its upper to its lower end: so two faces that share it round
    # alike, and no pixel between them is covered twice or not at all.
    rising = y[following] < y
    upper, lower = np.arange(len(points)), following
    upper[rising], lower[rising] = lower[rising], upper[rising]
    # The rows that each edge crosses, and the first whole column at or right of each crossing.
    rows = np.minimum(np.maximum(np.ceil(y), 0), height).astype(np.int64)
    begin, number = rows[upper], rows[lower] - rows[upper]
    ends = np.cumsum(number)
    edge = np.repeat(np.arange(len(points)), number)
    row = np.arange(len(edge)) - (ends - number - begin)[edge]
    fall = y[lower] - y[upper]
    slope = (x[lower] - x[upper]) / np.where(fall > 0, fall, 1.0)
    crossing = (x[upper] - slope * y[upper])[edge] + slope[edge] * row
    crossing = np.ceil(np.minimum(np.maximum(crossing, -1.0), width + 1.0)).astype(np.int64)
    # A convex polygon has one edge on its left and one on its right in every row.
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
    return Scanlines(polygon[covered], ys[covered], left[covered], right[covered])


def outlines_of(scanlines: Scanlines) -> Outlines:
    """The outlines of covered pixels, through pixel centres, in level and upright steps."""
    polygon, y, left, right = scanlines.polygon, scanlines.y, scanlines.left, scanlines.right
    count = len(y)
    if not count:
        return Outlines(np.zeros((0, 2), np.int32), [], [0])
    # Rows of a polygon that touch each other share an outline; a thin one falls into pieces.
    joined = np.zeros(count + 1, bool)
    joined[1:-1] = (
        (polygon[1:] == polygon[:-1])
        & (y[1:] == y[:-1] + 1)
        & (left[1:] <= right[:-1])
        & (right[1:] >= left[:-1])
    )
    first = np.flatnonzero(~joined[:-1])
    sizes = np.diff(np.append(first, count))
    # Each row has four points: two on the way down its right side, two on the way up its left.
    base = np.repeat(4 * first, sizes)
    depth = 2 * (np.arange(count) - base // 4)
    end = base + np.repeat(4 * sizes, sizes)
    # Between a row and the next the outline steps within the row where both are covered.
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
