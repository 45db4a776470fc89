"""A depth buffer, for faces that no order of painting gets right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hal.scene.arrays import Box, Float32s, Float64s, Pixels
from hal.scene.scanlines import Scanlines


@dataclass(frozen=True, eq=False)
class DepthFaces:
    """The faces that are drawn with a depth buffer; what is said by number is by polygon."""

    scanlines: Scanlines
    """The pixels of each."""
    planes: Float64s
    """(n, 3): scalar product with (x, y, 1) is the inverse depth at a pixel, 1/m."""
    colors: Pixels
    """(n, 4), BGRA."""
    textured: Mapping[int, tuple[Box, Pixels]]
    """Faces that have a texture instead: its pixels as seen on a part of the image."""
    spheres: Mapping[int, tuple[Float64s, float]]
    """Faces that stand for a sphere: its centre in camera axes and its radius, metres."""
    to_rays: Float64s
    """(3, 3): turns (x, y, 1) into a ray in camera axes, of depth 1."""


def draw_with_depth_buffer(image: Pixels, faces: DepthFaces) -> None:
    """Draw faces into a BGRA image so that at each pixel the nearest shows."""
    scanlines = faces.scanlines
    lengths = scanlines.right - scanlines.left + 1
    ends = np.cumsum(lengths)
    if not len(ends):
        return
    row = np.repeat(np.arange(len(lengths)), lengths)
    polygon = scanlines.polygon[row]
    x = np.arange(int(ends[-1])) - (ends - lengths - scanlines.left)[row]
    y = scanlines.y[row]
    a, b, c = faces.planes[polygon].T
    nearness = (a * x + b * y + c).astype(np.float32)
    for number, (center, radius) in faces.spheres.items():
        mine = polygon == number
        rays = faces.to_rays @ np.stack([x[mine], y[mine], np.ones(int(mine.sum()))])
        nearness[mine] = _sphere_nearness(rays, center, radius)
    width = image.shape[1]
    place = y * width + x
    nearest = np.full(image.shape[0] * width, -np.inf, np.float32)
    np.maximum.at(nearest, place, nearness)
    shown = nearness >= nearest[place]
    polygon, place = polygon[shown], place[shown]
    pixels = image.reshape(-1, 4)
    pixels[place] = faces.colors[polygon]
    for number, ((left, top, _, _), texture) in faces.textured.items():
        mine = place[polygon == number]
        pixels[mine] = texture[mine // width - top, mine % width - left]


def _sphere_nearness(rays: Float64s, center: Float64s, radius: float) -> Float32s:
    """Inverse depth of a sphere where rays (3, n) of depth 1 first meet it.

    A ray that passes beside it, at its rim, counts where it comes nearest.
    """
    along, squares = center @ rays, (rays * rays).sum(0)
    rest = along * along - squares * (center @ center - radius * radius)
    depth = (along - np.sqrt(np.maximum(rest, 0.0))) / squares
    return np.asarray(1 / np.maximum(depth, 1e-6), np.float32)
