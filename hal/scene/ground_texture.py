"""The painted ground as one picture, to be laid over hills."""

from __future__ import annotations

from math import ceil, log2

import cv2
import numpy as np

from hal.scene.ground_tiles import FINEST, SIDE, Tiles
from hal.scene.textures import Painted

_TEXELS = 2048
"""Along the picture, at most."""


def drape(tiles: Tiles, size: float) -> Painted:
    """A square of the ground about the origin, north up; ``size``: its side, metres."""
    level = max(0, ceil(log2(size / _TEXELS / FINEST)))
    texel = FINEST * 2**level
    reach = ceil(size / 2 / (texel * SIDE))
    rows = [
        np.hstack([tiles.tile(level, column, row) for column in range(-reach, reach)])
        for row in range(-reach, reach)
    ]
    # Tiles go north; what of them lies beyond the square is left out.
    whole = np.vstack(rows)[::-1]
    count = max(1, round(size / texel))
    step = size / texel / count
    begin = reach * SIDE - size / texel / 2 + step / 2 - 0.5
    move = np.array([[step, 0.0, begin], [0.0, step, begin]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return Painted(np.asarray(cv2.warpAffine(whole, move, (count, count), flags=flags), np.uint8))
