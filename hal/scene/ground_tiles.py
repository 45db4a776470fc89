"""The ground as painted tiles, at the levels of detail and in the places that are looked at."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from itertools import pairwise
from math import cos, pi, sin

import cv2
import numpy as np
from numpy.typing import NDArray

from hal.scene.scanlines import outlines, spans
from hal.scene.textures import Picture, load_picture
from vencejo.seeds import generator
from worlds.model import Ground
from worlds.things import Color, Stripe

SIDE = 256
"""Texels along a tile."""
FINEST = 0.01
"""Metres of a texel of level 0; each level doubles it."""
LEVELS = 12
_KEPT = 600
"""Tiles kept, 256 KiB each."""
_ROUGHNESS = 5.0
"""Largest brightness that each octave of the ground's own pattern adds."""
_OCTAVES = 5
_STEPS = 128
"""Places along a tile at which all octaves but the finest are worked out."""
_FINER = 2
"""Lines are drawn this much finer than a texel, and then averaged."""

Pixels = NDArray[np.uint8]
Floats = NDArray[np.float32]


class Tiles:
    """Paints a ground's tiles when they are first asked for and keeps the last used ones.

    Columns go east and rows north. Level, column and row name a tile; tile (0, 0) begins at the
    world's origin.
    """

    def __init__(self, ground: Ground) -> None:
        """Raises UserError for a picture that cannot be read."""
        self._ground = ground
        self._picture = load_picture(ground.texture) if ground.texture else None
        self._stripes = [(_bgr(stripe.color), list(_pieces(stripe))) for stripe in ground.stripes]
        self._kept: OrderedDict[tuple[int, int, int], Pixels] = OrderedDict()
        red, green, blue = ground.color
        self.color = (blue, green, red, 255)
        self.beyond = (*((3 * part + 2 * 125) // 5 for part in (blue, green, red)), 255)
        """Colour of the ground outside the coloured square."""

    def tile(self, level: int, column: int, row: int) -> Pixels:
        """The BGRA texels of a tile, (SIDE, SIDE, 4)."""
        key = (level, column, row)
        kept = self._kept
        if key in kept:
            kept.move_to_end(key)
        else:
            kept[key] = self._paint(level, column, row)
            if len(kept) > _KEPT:
                kept.popitem(last=False)
        return kept[key]

    def _paint(self, level: int, column: int, row: int) -> Pixels:
        texel = FINEST * 2**level
        west, south = column * SIDE * texel, row * SIDE * texel
        tile = filled(SIDE, SIDE, self.beyond)
        half = self._ground.size / 2
        left, right, low, high = (
            min(SIDE, max(0, round((edge - begin) / texel)))
            for edge, begin in ((-half, west), (half, west), (-half, south), (half, south))
        )
        if left < right and low < high:
            inside = np.s_[low:high, left:right]
            if self._picture is None:
                tile[inside] = filled(right - left, high - low, self.color)
            else:
                tile[inside] = self._tiled(self._picture, texel, west, south)[inside]
        self._draw_stripes(tile, texel, west, south)
        if self._picture is None:
            _roughen(tile, level, column, row)
        return tile

    def _tiled(self, picture: Picture, texel: float, west: float, south: float) -> Pixels:
        period = self._ground.tile
        pixels = picture.level(texel / period)
        height, width = pixels.shape[:2]
        along, up = width / period, height / period
        # The picture's upper edge is in the north, the tile's first row in the south.
        move = np.array(
            [
                [along * texel, 0, (west + texel / 2) * along % width - 0.5],
                [0, -up * texel, height - (south + texel / 2) * up % height - 0.5],
            ]
        )
        return np.asarray(
            cv2.warpAffine(
                pixels,
                move,
                (SIDE, SIDE),
                flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                borderMode=cv2.BORDER_WRAP,
            ),
            np.uint8,
        )

    def _draw_stripes(self, tile: Pixels, texel: float, west: float, south: float) -> None:
        side, fine = SIDE * texel, texel / _FINER
        drawn = [
            (color, near)
            for color, pieces in self._stripes
            if (near := [piece for piece in pieces if _meets(piece, west, south, side)])
        ]
        if not drawn:
            return
        size = SIDE * _FINER
        large = cv2.resize(tile, (size, size), interpolation=cv2.INTER_NEAREST)
        for color, pieces in drawn:
            points = (np.concatenate(pieces) - (west, south)) / fine - 0.5
            starts = np.cumsum([0, *map(len, pieces)])
            found = outlines(spans(points, starts, size, size))
            for number in range(len(found.polygon)):
                outline = found.points[found.start[number] : found.start[number + 1]]
                cv2.fillConvexPoly(large, outline, color)
        cv2.resize(large, (SIDE, SIDE), tile, interpolation=cv2.INTER_AREA)


def filled(width: int, height: int, color: tuple[int, ...]) -> Pixels:
    """A picture of one BGRA colour."""
    # As whole words: filling byte by byte takes twenty times as long.
    word = np.frombuffer(bytes(color), np.uint32)[0]
    return np.full((height, width), word, np.uint32).view(np.uint8).reshape(height, width, 4)


def _bgr(color: Color) -> tuple[int, int, int, int]:
    return color[2], color[1], color[0], 255


def _pieces(stripe: Stripe) -> Iterator[NDArray[np.float64]]:
    """The convex pieces of a painted line: a rectangle along each leg, a round joint between two.

    Clockwise on the map: rows of a tile go north, so an image shows it counter-clockwise.
    """
    points = np.array(stripe.points, float)
    half = stripe.width / 2
    for start, end in pairwise(points):
        along = end - start
        length = float(np.hypot(*along))
        if length > 0:
            left = np.array([-along[1], along[0]]) * (half / length)
            yield np.array([start + left, end + left, end - left, start - left])
    for joint in points[1:-1]:
        yield joint + half * _ROUND


_ROUND = np.array([[cos(2 * pi * k / 16), -sin(2 * pi * k / 16)] for k in range(16)])


def _meets(piece: NDArray[np.float64], west: float, south: float, side: float) -> bool:
    low, high = piece.min(0), piece.max(0)
    return bool(
        low[0] < west + side and high[0] > west and low[1] < south + side and high[1] > south
    )


def _roughen(tile: Pixels, level: int, column: int, row: int) -> None:
    """Add a pattern that has detail at every scale, so that motion over bare ground can be seen.

    An octave's grid is that of its level; it repeats after SIDE texels of it.
    """
    corner = column * SIDE, row * SIDE
    # All but the finest are added up in steps of some texels, from one step before the tile to
    # one behind it, and spread from there; the finest lies on the texels themselves.
    step = SIDE // _STEPS
    coarse = np.zeros((_STEPS + 2, _STEPS + 2), np.float32)
    for octave in range(1, _OCTAVES):
        coarse += _octave(level, octave, corner, step, -step / 2, _STEPS + 2)
    total = _warped(coarse, 1 / step, (0.5 / step + 0.5, 0.5 / step + 0.5), SIDE)
    total += np.roll(_noise(), (-91 * level, -37 * level), (0, 1))
    added = np.rint(total).astype(np.int16)
    cv2.add(tile, cv2.merge([added, added, added, np.zeros_like(added)]), tile, dtype=cv2.CV_8U)


def _octave(
    level: int, octave: int, corner: tuple[int, int], step: int, first: float, count: int
) -> Floats:
    """An octave at ``count`` places each way, from ``first`` texels behind the tile's corner on."""
    share, kind = 0.5**octave, level + octave
    east, north = (
        ((place + first) * share - 0.5 + shift * kind) % SIDE
        for place, shift in zip(corner, (37, 91), strict=True)
    )
    return _warped(_noise(), step * share, (east, north), count)


def _warped(field: Floats, scale: float, begin: tuple[float, float], count: int) -> Floats:
    move = np.array([[scale, 0, begin[0]], [0, scale, begin[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (count, count)
    return np.asarray(
        cv2.warpAffine(field, move, size, flags=flags, borderMode=cv2.BORDER_WRAP), np.float32
    )


def _noise() -> NDArray[np.float32]:
    """A field of even noise, always the same; (SIDE, SIDE)."""
    if not _NOISE:
        drawn = generator(0, "ground").randbytes(SIDE * SIDE)
        field = np.frombuffer(drawn, np.uint8).reshape(SIDE, SIDE).astype(np.float32)
        _NOISE.append((field / 127.5 - 1) * _ROUGHNESS)
    return _NOISE[0]


_NOISE: list[NDArray[np.float32]] = []
