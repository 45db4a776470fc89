"""A depth buffer, for faces that no order of painting gets right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hal.scene.arrays import Box, Float32s, Float64s, Int64s, Pixels
from hal.scene.scanlines import Scanlines


@dataclass(frozen=True, eq=False)
class Foliage:
    """The light on spheres of leaves."""

    sun: Float64s
    """Unit vector to the sun, world frame."""
    rotation: Float64s
    """(3, 3), camera axes to world."""
    tones: Mapping[int, Pixels]
    """Of each such face (m, 4), BGRA: from leaves that are turned away from the sun to those that
    face it; as many of all."""

    def tone(self, normals: Float32s) -> Int64s:
        """The tone of leaves whose surface has these unit normals (3, n), in camera axes.

        It is the lighter the more they face the sun, and lighter and darker in patches.
        """
        world = self.rotation.astype(np.float32) @ normals
        waves = np.sin(_PATCHES @ world + _SHIFTS)
        light = (1 + self.sun.astype(np.float32) @ world) / 2
        light += _VARIETY * waves[0] * waves[1] * waves[2]
        last = len(next(iter(self.tones.values()))) - 1
        return np.asarray(np.clip(light * last + 0.5, 0, last), np.int64)


_PATCHES = np.array([[13.0, 4.0, 0.0], [-5.0, 12.0, 3.0], [2.0, -4.0, 14.0]], np.float32)
"""Waves over the unit sphere, whose product makes patches a seventh of its radius wide."""
_SHIFTS = np.array([[0.4], [1.3], [2.2]], np.float32)
_VARIETY = np.float32(0.14)
"""The most that a patch is lighter or darker, as a share of all tones."""


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
    foliage: Foliage
    to_rays: Float64s
    """(3, 3): turns (x, y, 1) into a ray in camera axes, of depth 1."""

    def rays(self, x: Int64s, y: Int64s) -> Float64s:
        """The rays (3, n) through pixels."""
        return np.asarray(self.to_rays @ np.stack([x, y, np.ones(len(x))]), np.float64)


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
        nearness[mine] = _sphere_nearness(faces.rays(x[mine], y[mine]), center, radius)
    width = image.shape[1]
    place = y * width + x
    nearest = np.full(image.shape[0] * width, -np.inf, np.float32)
    np.maximum.at(nearest, place, nearness)
    shown = nearness >= nearest[place]
    x, y, nearness, polygon, place = (each[shown] for each in (x, y, nearness, polygon, place))
    pixels = image.reshape(-1, 4)
    pixels[place] = faces.colors[polygon]
    if faces.foliage.tones:
        is_leafy = np.zeros(len(faces.colors), bool)
        is_leafy[list(faces.foliage.tones)] = True
        leaves = np.flatnonzero(is_leafy[polygon])
        colors = _leaves(faces, polygon[leaves], x[leaves], y[leaves], nearness[leaves])
        pixels[place[leaves]] = colors
    for number, ((left, top, _, _), texture) in faces.textured.items():
        inside = place[polygon == number]
        pixels[inside] = texture[inside // width - top, inside % width - left]


def _leaves(faces: DepthFaces, polygon: Int64s, x: Int64s, y: Int64s, nearness: Float32s) -> Pixels:
    """The colours (n, 4) of pixels that show leaves, of these polygons and inverse depths."""
    numbers = sorted(faces.foliage.tones)
    owner = np.searchsorted(numbers, polygon)
    centers = np.stack([faces.spheres[number][0] for number in numbers], 1).astype(np.float32)
    radii = np.array([faces.spheres[number][1] for number in numbers], np.float32)
    rays = faces.rays(x, y).astype(np.float32)
    normals = (rays / nearness - centers[:, owner]) / radii[owner]
    tones = np.stack([faces.foliage.tones[number] for number in numbers])
    return np.asarray(tones[owner, faces.foliage.tone(normals)], np.uint8)


def _sphere_nearness(rays: Float64s, center: Float64s, radius: float) -> Float32s:
    """Inverse depth of a sphere where rays (3, n) of depth 1 first meet it.

    A ray that passes beside it, at its rim, counts where it comes nearest.
    """
    along, squares = center @ rays, (rays * rays).sum(0)
    rest = along * along - squares * (center @ center - radius * radius)
    depth = (along - np.sqrt(np.maximum(rest, 0.0))) / squares
    return np.asarray(1 / np.maximum(depth, 1e-6), np.float32)
