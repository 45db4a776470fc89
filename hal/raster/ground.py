"""The ground in a picture: bands of equal detail, from the horizon to the camera's feet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import floor, hypot, inf

import cv2
import numpy as np
from numpy.typing import NDArray

from hal.scene.ground_tiles import FINEST, LEVELS, SIDE, Tiles, filled
from hal.scene.surfaces import Array

Pixels = NDArray[np.uint8]

_STRETCH = 0.75
"""Between detail for the length of a pixel's footprint (1) and for its width (0)."""
_THINNEST = 10
"""Pixels that a band is high at least."""
_WORTH_TURNING = 30_000
"""Pixels of a band from which on a turned copy of its patch saves time."""
_LARGEST = 14
"""Tiles along a patch at most."""


@dataclass(eq=False)
class _Patch:
    """Tiles of one level that lie together, as one picture."""

    column: int
    row: int
    columns: int
    rows: int
    texels: Pixels

    @cached_property
    def turned(self) -> Pixels:
        """With rows and columns changed about: reading along rows is more than twice as fast."""
        return np.ascontiguousarray(self.texels.transpose(1, 0, 2))

    def holds(self, west: int, south: int, east: int, north: int) -> bool:
        return (
            self.column <= west
            and self.row <= south
            and east < self.column + self.columns
            and north < self.row + self.rows
        )


_Polygon = list[tuple[float, float, float]]
"""Corners: x and y in pixels, and how far a ray of depth 1 falls there, metres."""


@dataclass(frozen=True, eq=False)
class Band:
    """A part of the picture that shows the ground at one level of detail."""

    polygon: _Polygon
    """Convex, in pixels."""
    level: int | None
    """None for the plain ground at the horizon."""

    @property
    def corners(self) -> Array:
        """(n, 2), pixels."""
        return np.array(self.polygon)[:, :2]


class GroundView:
    """How a camera sees the ground at one moment."""

    def __init__(self, eye: Array, turn: Array, matrix: Array, height: float) -> None:
        """``turn`` rotates optical axes into the world, ``matrix`` is the camera's 3 × 3.

        ``height`` is the camera's above the ground; at or below 0 nothing of the ground is seen.
        """
        self.height = height
        rays = turn @ cv2.invert(matrix)[1]
        # A ray's fall is a linear function of the pixel, and the inverse of its depth.
        self.fall = -rays[2]
        self.to_ground = np.stack(
            [
                eye[0] * rays[2] - height * rays[0],
                eye[1] * rays[2] - height * rays[1],
                rays[2],
            ]
        )
        self.to_ground_rows: list[list[float]] = self.to_ground.tolist()
        self._focal = (matrix[0, 0] + matrix[1, 1]) / 2
        self._tilt = hypot(turn[2, 0], turn[2, 1])

    def bands(self, width: int, height: int) -> list[Band]:
        """The bands of a picture, from the horizon down."""
        if self.height <= 0:
            return []
        a, b, c = self.fall.tolist()
        corners = (-1.0, -1.0), (-1.0, float(height)), (float(width), float(height)), (width, -1.0)
        rest: _Polygon = [(x, y, a * x + b * y + c) for x, y in corners]
        steepest = max(fall for _, _, fall in rest)
        if steepest <= 0:
            return []
        found: list[Band] = []
        per_pixel = hypot(a, b)
        upper, coarsest = self.height / self._depth(LEVELS), LEVELS - 1
        _, rest = _split(rest, 0.0)
        plain, rest = _split(rest, upper)
        if len(plain) >= 3:
            found.append(Band(plain, None))
        for level in range(LEVELS - 1, -1, -1):
            near = self._depth(level) if level else 0.0
            lower = self.height / near if near else inf
            last = lower >= steepest
            # Towards the horizon several levels share a band: each costs time.
            if last or lower - upper > _THINNEST * per_pixel:
                band, rest = (rest, []) if last else _split(rest, lower)
                if len(band) >= 3:
                    found.append(Band(band, (level + coarsest + 1) // 2))
                upper, coarsest = lower, level - 1
            if last:
                break
        return found

    def _depth(self, level: int) -> float:
        """Depth at which the footprint of a pixel is half-way between two levels."""
        reach = FINEST * 2 ** (level - 0.5) * self._focal
        stretched = self.height / max(self._tilt, 1e-9)
        if reach <= stretched:
            return float(reach)
        return float((reach * stretched**_STRETCH) ** (1 / (1 + _STRETCH)))


def _split(polygon: _Polygon, bound: float) -> tuple[_Polygon, _Polygon]:
    """The parts of a convex polygon below and above a value of its third coordinate."""
    below: _Polygon = []
    above: _Polygon = []
    for k, (x, y, f) in enumerate(polygon):
        px, py, pf = polygon[k - 1]
        if (f >= bound) != (pf >= bound):
            share = (bound - pf) / (f - pf)
            point = (px + share * (x - px), py + share * (y - py), bound)
            below.append(point)
            above.append(point)
        (above if f >= bound else below).append((x, y, f))
    return below, above


class GroundPainter:
    """Draws bands of a ground."""

    def __init__(self, tiles: Tiles) -> None:
        self._tiles = tiles
        self._patches: dict[int, _Patch] = {}

    def draw(
        self,
        view: GroundView,
        band: Band,
        box: tuple[int, int, int, int],
        into: Pixels | None = None,
    ) -> Pixels:
        """The pixels of a box (left, top, right, bottom; the last ones outside) of a band.

        They are drawn into a picture of the box's size, if one is given.
        """
        left, top, right, bottom = box
        if band.level is None:
            plain = filled(right - left, bottom - top, self._tiles.beyond)
            if into is not None:
                into[:] = plain
            return plain
        patch = self._patch(view, band, band.level)
        # From a pixel of the box to the ground, and on to the texel of the patch.
        texel, (g, h, i) = FINEST * 2**band.level, view.to_ground_rows[2]
        i += g * left + h * top
        rows = []
        for (a, b, c), begin in zip(
            view.to_ground_rows, (patch.column * SIDE + 0.5, patch.row * SIDE + 0.5), strict=False
        ):
            c = (c + a * left + b * top) / texel - begin * i
            rows.append([a / texel - begin * g, b / texel - begin * h, c])
        way, texels = np.array([*rows, [g, h, i]]), patch.texels
        x, y, w = (way @ ((right - left) / 2, (bottom - top) / 2, 1.0)).tolist()
        large = (right - left) * (bottom - top) > _WORTH_TURNING
        if large and abs(way[1, 0] * w - y * way[2, 0]) > abs(way[0, 0] * w - x * way[2, 0]):
            way, texels = way[[1, 0, 2]], patch.turned
        return np.asarray(
            cv2.warpPerspective(
                texels,
                way,
                (right - left, bottom - top),
                into,
                flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                borderMode=cv2.BORDER_REPLICATE,
            ),
            np.uint8,
        )

    def _patch(self, view: GroundView, band: Band, level: int) -> _Patch:
        side = FINEST * 2**level * SIDE
        (a, b, c), (d, e, f), (g, h, i) = view.to_ground_rows
        places = [
            ((a * x + b * y + c) / w, (d * x + e * y + f) / w)
            for x, y, _ in band.polygon
            for w in [(g * x + h * y + i) * side]
        ]
        x, y = [place[0] for place in places], [place[1] for place in places]
        room = 1 / SIDE
        west, east = floor(min(x) - room), floor(max(x) + room)
        south, north = floor(min(y) - room), floor(max(y) + room)
        patch = self._patches.get(level)
        if patch is None or not patch.holds(west, south, east, north):
            patch = self._patches[level] = self._assemble(level, west, south, east, north)
        return patch

    def _assemble(self, level: int, west: int, south: int, east: int, north: int) -> _Patch:
        columns, rows = east - west + 1, north - south + 1
        held = min(columns, _LARGEST), min(rows, _LARGEST)
        texels = np.empty((held[1] * SIDE, held[0] * SIDE, 4), np.uint8)
        for r in range(held[1]):
            for c in range(held[0]):
                texels[r * SIDE : (r + 1) * SIDE, c * SIDE : (c + 1) * SIDE] = self._tiles.tile(
                    level, west + c, south + r
                )
        return _Patch(west, south, columns, rows, texels)
