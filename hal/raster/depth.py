"""Knots: faces that no order of painting gets right are drawn with depth per pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hal.raster.spans import Spans

Pixels = NDArray[np.uint8]


def draw_knot(
    image: Pixels,
    covered: Spans,
    planes: NDArray[np.float64],
    colors: NDArray[np.uint8],
    textured: dict[int, tuple[tuple[int, int, int, int], Pixels]],
) -> None:
    """Draw polygons so that at each pixel the nearest shows.

    ``planes`` (n, 3) give a polygon's inverse depth at (x, y, 1), ``colors`` (n, 4) its BGRA.
    ``textured`` polygons take their pixels from a picture of a box (left, top, …) instead.
    """
    lengths = covered.right - covered.left + 1
    ends = np.cumsum(lengths)
    if not len(ends):
        return
    row = np.repeat(np.arange(len(lengths)), lengths)
    polygon = covered.polygon[row]
    x = np.arange(int(ends[-1])) - (ends - lengths - covered.left)[row]
    y = covered.y[row]
    a, b, c = planes[polygon].T
    nearness = (a * x + b * y + c).astype(np.float32)
    width = image.shape[1]
    place = y * width + x
    nearest = np.full(image.shape[0] * width, -np.inf, np.float32)
    np.maximum.at(nearest, place, nearness)
    shown = nearness >= nearest[place]
    polygon, place = polygon[shown], place[shown]
    pixels = image.reshape(-1, 4)
    pixels[place] = colors[polygon]
    for number, ((left, top, _, _), picture) in textured.items():
        mine = place[polygon == number]
        pixels[mine] = picture[mine // width - top, mine % width - left]
