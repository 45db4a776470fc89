"""The painted ground about the origin as one image, for renderers without tiles and for hills."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log2

import cv2
import numpy as np

from hal.scene.arrays import Pixels
from hal.scene.ground_tiles import TILE_TEXELS, GroundTiles, texel_size
from hal.scene.textures import Bitmap

_MOST_TEXELS = 2048
"""Along a ground's image, at most."""


@dataclass(frozen=True, eq=False)
class Mosaic:
    """Whole tiles about the origin as one image."""

    pixels: Pixels
    """BGRA, north up."""
    half: float
    """Half of the side of the square that it shows, metres."""
    texel: float
    """Side of a texel, metres."""


def ground_mosaic(tiles: GroundTiles, size: float) -> Mosaic:
    """The tiles that cover a square about the origin; ``size`` is its side, metres."""
    level = max(0, ceil(log2(size / _MOST_TEXELS / texel_size(0))))
    side = texel_size(level) * TILE_TEXELS
    reach = ceil(size / 2 / side)
    rows = [
        np.hstack([tiles.tile(level, column, row) for column in range(-reach, reach)])
        for row in range(-reach, reach)
    ]
    # The rows of a tile go north.
    return Mosaic(np.vstack(rows)[::-1], reach * side, texel_size(level))


def ground_texture(tiles: GroundTiles, size: float) -> Bitmap:
    """The ground on exactly a square about the origin, north up; ``size`` is its side, metres."""
    mosaic = ground_mosaic(tiles, size)
    texel = mosaic.texel
    count = max(1, round(size / texel))
    step = size / texel / count
    begin = len(mosaic.pixels) / 2 - size / texel / 2 + step / 2 - 0.5
    to_mosaic = np.array([[step, 0.0, begin], [0.0, step, begin]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    cropped = cv2.warpAffine(mosaic.pixels, to_mosaic, (count, count), flags=flags)
    return Bitmap(np.asarray(cropped, np.uint8))
