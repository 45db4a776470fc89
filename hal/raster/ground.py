"""The ground in an image: bands of equal detail, from the horizon to the camera's feet."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import floor, hypot, inf

import cv2
import numpy as np

from hal.raster.camera import PinholeCamera
from hal.scene.arrays import Box, Float64s, Pixels
from hal.scene.ground_tiles import LEVELS, TILE_TEXELS, GroundTiles, texel_size
from hal.scene.textures import uniform_image

_ANISOTROPY = 0.75
"""Between detail for the length of a pixel's footprint (1) and for its width (0)."""
_LEAST_HEIGHT = 10
"""Least height of a band, pixels."""
_WORTH_TRANSPOSING = 30_000
"""Pixels of a band from which on a transposed copy of its patch saves time."""
_MOST_TILES = 14
"""Along a patch."""

_Polygon = list[tuple[float, float, float]]
"""Corners: x and y in pixels, and how far a ray of depth 1 falls there, metres."""


@dataclass(frozen=True, eq=False)
class Band:
    """A part of an image that shows the ground at one level of detail."""

    polygon: _Polygon
    """Convex."""
    level: int | None
    """The level of detail of the tiles; None for ground of one colour, at the horizon."""

    @property
    def corners(self) -> Float64s:
        """(n, 2), pixels."""
        return np.array(self.polygon)[:, :2]


class GroundProjection:
    """The projection between an image and the flat ground at z = 0."""

    def __init__(self, camera: PinholeCamera) -> None:
        eye = camera.eye
        self.height = float(eye[2])
        """The camera's height above the ground, metres; at 0 and below it sees nothing of it."""
        rays = camera.rotation @ cv2.invert(camera.matrix)[1]
        self._fall = -rays[2]
        """Scalar product with (x, y, 1): the fall of a ray of depth 1 through a pixel, metres."""
        to_ground = np.stack(
            [
                eye[0] * rays[2] - self.height * rays[0],
                eye[1] * rays[2] - self.height * rays[1],
                rays[2],
            ]
        )
        self.to_ground: list[list[float]] = to_ground.tolist()
        """Homography (3 × 3, rows) from (x, y, 1) of a pixel to the world's x and y, metres."""
        self._focal = (camera.matrix[0, 0] + camera.matrix[1, 1]) / 2
        self._level_share = hypot(camera.rotation[2, 0], camera.rotation[2, 1])
        """Length of the image's axes in the vertical: 0 looking straight down, 1 looking ahead."""

    def bands(self, width: int, height: int) -> list[Band]:
        """The bands of an image of that size, from the horizon down."""
        if self.height <= 0:
            return []
        a, b, c = self._fall.tolist()
        corners = (-1.0, -1.0), (-1.0, float(height)), (float(width), float(height)), (width, -1.0)
        rest: _Polygon = [(x, y, a * x + b * y + c) for x, y in corners]
        steepest = max(fall for _, _, fall in rest)
        if steepest <= 0:
            return []
        found: list[Band] = []
        per_pixel = hypot(a, b)
        upper, coarsest = self.height / self._depth_of_level(LEVELS), LEVELS - 1
        _, rest = _split(rest, 0.0)
        plain, rest = _split(rest, upper)
        if len(plain) >= 3:
            found.append(Band(plain, None))
        for level in range(LEVELS - 1, -1, -1):
            near = self._depth_of_level(level) if level else 0.0
            lower = self.height / near if near else inf
            last = lower >= steepest
            # Towards the horizon several levels share a band: each costs time.
            if last or lower - upper > _LEAST_HEIGHT * per_pixel:
                band, rest = (rest, []) if last else _split(rest, lower)
                if len(band) >= 3:
                    found.append(Band(band, (level + coarsest + 1) // 2))
                upper, coarsest = lower, level - 1
            if last:
                break
        return found

    def _depth_of_level(self, level: int) -> float:
        """The depth where a pixel's footprint is half-way between a level and the finer one, m."""
        reach = texel_size(0) * 2 ** (level - 0.5) * self._focal
        stretched = self.height / max(self._level_share, 1e-9)
        if reach <= stretched:
            return float(reach)
        return float((reach * stretched**_ANISOTROPY) ** (1 / (1 + _ANISOTROPY)))


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


@dataclass(eq=False)
class _Patch:
    """Tiles of one level that lie together, as one image."""

    column: int
    """The column of its western tiles."""
    row: int
    """The row of its southern tiles."""
    columns: int
    rows: int
    texels: Pixels

    @cached_property
    def transposed(self) -> Pixels:
        """Rows and columns exchanged: to read along rows is more than twice as fast."""
        return np.ascontiguousarray(self.texels.transpose(1, 0, 2))

    def holds(self, west: int, south: int, east: int, north: int) -> bool:
        """Whether it has all tiles of these columns and rows, the last ones included."""
        return (
            self.column <= west
            and self.row <= south
            and east < self.column + self.columns
            and north < self.row + self.rows
        )


class GroundPainter:
    """Draws bands of a ground; keeps the last patch of each level."""

    def __init__(self, tiles: GroundTiles) -> None:
        self._tiles = tiles
        self._patches: dict[int, _Patch] = {}

    def draw(
        self, ground: GroundProjection, band: Band, box: Box, into: Pixels | None = None
    ) -> Pixels:
        """The BGRA pixels of a box of the image, all of which show the band.

        They are drawn into an image of the box's size, if one is given.
        """
        left, top, right, bottom = box
        if band.level is None:
            plain = uniform_image(right - left, bottom - top, self._tiles.color_beyond)
            if into is not None:
                into[:] = plain
            return plain
        patch = self._patch(ground, band, band.level)
        # From a pixel of the box to the ground, and on to the texel of the patch.
        texel, (g, h, i) = texel_size(band.level), ground.to_ground[2]
        i += g * left + h * top
        rows = []
        for (a, b, c), begin in zip(
            ground.to_ground,
            (patch.column * TILE_TEXELS + 0.5, patch.row * TILE_TEXELS + 0.5),
            strict=False,
        ):
            c = (c + a * left + b * top) / texel - begin * i
            rows.append([a / texel - begin * g, b / texel - begin * h, c])
        to_texels, texels = np.array([*rows, [g, h, i]]), patch.texels
        x, y, w = (to_texels @ ((right - left) / 2, (bottom - top) / 2, 1.0)).tolist()
        large = (right - left) * (bottom - top) > _WORTH_TRANSPOSING
        down = abs(to_texels[1, 0] * w - y * to_texels[2, 0])
        if large and down > abs(to_texels[0, 0] * w - x * to_texels[2, 0]):
            to_texels, texels = to_texels[[1, 0, 2]], patch.transposed
        return np.asarray(
            cv2.warpPerspective(
                texels,
                to_texels,
                (right - left, bottom - top),
                into,
                flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                borderMode=cv2.BORDER_REPLICATE,
            ),
            np.uint8,
        )

    def _patch(self, ground: GroundProjection, band: Band, level: int) -> _Patch:
        """A patch that has all the tiles which a band shows."""
        side = texel_size(level) * TILE_TEXELS
        (a, b, c), (d, e, f), (g, h, i) = ground.to_ground
        places = [
            ((a * x + b * y + c) / w, (d * x + e * y + f) / w)
            for x, y, _ in band.polygon
            for w in [(g * x + h * y + i) * side]
        ]
        x, y = [place[0] for place in places], [place[1] for place in places]
        margin = 1 / TILE_TEXELS
        west, east = floor(min(x) - margin), floor(max(x) + margin)
        south, north = floor(min(y) - margin), floor(max(y) + margin)
        patch = self._patches.get(level)
        if patch is None or not patch.holds(west, south, east, north):
            patch = self._patches[level] = self._assemble(level, west, south, east, north)
        return patch

    def _assemble(self, level: int, west: int, south: int, east: int, north: int) -> _Patch:
        columns, rows = east - west + 1, north - south + 1
        # Of a patch that would be too large the far tiles are left out, and its rim drawn on there.
        kept_columns, kept_rows = min(columns, _MOST_TILES), min(rows, _MOST_TILES)
        side = TILE_TEXELS
        texels = np.empty((kept_rows * side, kept_columns * side, 4), np.uint8)
        for r in range(kept_rows):
            for c in range(kept_columns):
                tile = self._tiles.tile(level, west + c, south + r)
                texels[r * side : (r + 1) * side, c * side : (c + 1) * side] = tile
        return _Patch(west, south, columns, rows, texels)
