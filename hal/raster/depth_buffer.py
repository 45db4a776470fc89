"""Knots: faces that no order of painting gets right are drawn with depth per pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hal.scene.scanlines import Spans

Pixels = NDArray[np.uint8]


def draw_knot(
    image: Pixels,
    covered: Spans,
    planes: NDArray[np.floating[Any]],
    colors: NDArray[np.uint8],
    textured: dict[int, tuple[tuple[int, int, int, int], Pixels]],
    balls: dict[int, tuple[NDArray[np.float64], float]],
    to_rays: NDArray[np.floating[Any]],
) -> None:
    """Draw polygons so that at each pixel the nearest shows.

    ``planes`` (n, 3) give a polygon's inverse depth at (x, y, 1), ``colors`` (n, 4) its BGRA.
    ``textured`` polygons take their pixels from a picture of a box (left, top, …) instead.
    ``balls`` are polygons that stand for a sphere: its middle in camera axes, and its radius;
    ``to_rays`` (3, 3) turns (x, y, 1) into a ray of depth 1.
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
    for number, (middle, radius) in balls.items():
        mine = polygon == number
        nearness[mine] = _nearness_of_ball(x[mine], y[mine], to_rays, middle, radius)
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


def _nearness_of_ball(
    x: NDArray[np.int64],
    y: NDArray[np.int64],
    to_rays: NDArray[np.floating[Any]],
    middle: NDArray[np.float64],
    radius: float,
) -> NDArray[np.float32]:
    """Inverse depth of a sphere where rays first meet it (or come nearest, at its rim)."""
    rays = to_rays @ np.stack([x, y, np.ones(len(x))])
    along, squares = middle @ rays, (rays * rays).sum(0)
    rest = along * along - squares * (middle @ middle - radius * radius)
    depth = (along - np.sqrt(np.maximum(rest, 0.0))) / squares
    return np.asarray(1 / np.maximum(depth, 1e-6), np.float32)
