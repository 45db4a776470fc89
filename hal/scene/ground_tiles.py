"""The painted ground as tiles, at the levels of detail and in the places that are looked at."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from math import cos, pi, sin

import cv2
import numpy as np

from hal.scene.arrays import Float32s, Float64s, Pixels
from hal.scene.scanlines import outlines_of, scan_convert
from hal.scene.textures import Mipmap, load_image, uniform_image
from vencejo.seeds import generator
from worlds.things import Color, Stripe
from worlds.world import Ground

TILE_TEXELS = 256
"""Texels along a tile."""
LEVELS = 12
"""Levels of detail, 0 the finest."""
_FINEST_TEXEL = 0.01
"""Side of a texel of level 0, metres."""
_KEPT = 600
"""Tiles kept, 256 KiB each."""
_NOISE_AMPLITUDE = 5.0
"""Largest change of brightness that one octave of noise makes, grey levels."""
_OCTAVES = 5
_COARSE_SAMPLES = 128
"""Samples along a tile at which all octaves but the finest are computed."""
_SUPERSAMPLING = 2
"""Stripes are drawn this much finer than a texel along each axis, and then averaged."""
_FADE = 0.15
"""Width of the strip about the coloured square in which its colour fades, as a share of its side.
"""
_NEAR_SUPERSAMPLING, _NEAR_LEVELS = 4, 3
"""The same for the finest levels, whose texels are seen one by one."""


def texel_size(level: int) -> float:
    """Side of a texel, metres: each level doubles it."""
    return float(_FINEST_TEXEL * 2**level)


class GroundTiles:
    """Paints a ground's tiles when they are first asked for and keeps those used last.

    Columns go east and rows north; tile (0, 0) of each level has its south-west corner at the
    world's origin.
    """

    def __init__(self, ground: Ground) -> None:
        """Raises UserError (``bad-picture``) for a texture that cannot be read."""
        self._ground = ground
        self._texture = load_image(ground.texture) if ground.texture else None
        self._stripes = [
            (_bgra(stripe.color), list(_convex_pieces(stripe))) for stripe in ground.stripes
        ]
        self._kept: OrderedDict[tuple[int, int, int], Pixels] = OrderedDict()
        self._color = _bgra(ground.color)
        blue, green, red, _ = self._color
        self.color_beyond = (*((3 * part + 2 * 125) // 5 for part in (blue, green, red)), 255)
        """BGRA colour of the ground outside the coloured square."""

    def tile(self, level: int, column: int, row: int) -> Pixels:
        """The BGRA texels of a tile, (TILE_TEXELS, TILE_TEXELS, 4); the first row is south."""
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
        texel = texel_size(level)
        west, south = column * TILE_TEXELS * texel, row * TILE_TEXELS * texel
        beyond = self._beyond(texel, west, south)
        tile = uniform_image(TILE_TEXELS, TILE_TEXELS, self.color_beyond)
        if beyond.min() < 1:
            inside = uniform_image(TILE_TEXELS, TILE_TEXELS, self._color)
            if self._texture is not None:
                inside = self._repeated(self._texture, texel, west, south)
            tile = _blended(inside, tile, beyond) if beyond.any() else inside
        self._draw_stripes(tile, level, west, south)
        if self._texture is None:
            _add_noise(tile, level, column, row)
        return tile

    def _beyond(self, texel: float, west: float, south: float) -> Float32s:
        """The share of the colour beyond the coloured square at a tile's texels: 0 in the square,
        1 from some metres outside on.
        """
        middles = (np.arange(TILE_TEXELS) + 0.5) * texel
        east, north = (np.abs(begin + middles) - self._ground.size / 2 for begin in (west, south))
        width = _FADE * self._ground.size
        outside = np.maximum(east[None, :], north[:, None]) / width
        return np.asarray(outside.clip(0.0, 1.0), np.float32)

    def _repeated(self, texture: Mipmap, texel: float, west: float, south: float) -> Pixels:
        """The ground's texture, repeated over a tile with that south-west corner."""
        period = self._ground.tile
        pixels = texture.level(texel / period)
        height, width = pixels.shape[:2]
        along, up = width / period, height / period
        # The texture's upper edge is in the north, the tile's first row in the south.
        to_texture = np.array(
            [
                [along * texel, 0, (west + texel / 2) * along % width - 0.5],
                [0, -up * texel, height - (south + texel / 2) * up % height - 0.5],
            ]
        )
        return np.asarray(
            cv2.warpAffine(
                pixels,
                to_texture,
                (TILE_TEXELS, TILE_TEXELS),
                flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                borderMode=cv2.BORDER_WRAP,
            ),
            np.uint8,
        )

    def _draw_stripes(self, tile: Pixels, level: int, west: float, south: float) -> None:
        finer = _NEAR_SUPERSAMPLING if level < _NEAR_LEVELS else _SUPERSAMPLING
        side, fine = TILE_TEXELS * texel_size(level), texel_size(level) / finer
        drawn = [
            (color, near)
            for color, pieces in self._stripes
            if (near := [piece for piece in pieces if _overlaps(piece, west, south, side)])
        ]
        if not drawn:
            return
        size = TILE_TEXELS * finer
        large = cv2.resize(tile, (size, size), interpolation=cv2.INTER_NEAREST)
        for color, pieces in drawn:
            points = (np.concatenate(pieces) - (west, south)) / fine - 0.5
            starts = np.cumsum([0, *map(len, pieces)])
            found = outlines_of(scan_convert(points, starts, size, size))
            for number in range(len(found.polygon)):
                outline = found.points[found.start[number] : found.start[number + 1]]
                cv2.fillConvexPoly(large, outline, color)
        cv2.resize(large, (TILE_TEXELS, TILE_TEXELS), tile, interpolation=cv2.INTER_AREA)


def _blended(one: Pixels, other: Pixels, share: Float32s) -> Pixels:
    """Two images as one, with that share (rows, columns) of the other."""
    return np.asarray(cv2.blendLinear(one, other, 1 - share, share), np.uint8)


def _bgra(color: Color) -> tuple[int, int, int, int]:
    return color[2], color[1], color[0], 255


def _convex_pieces(stripe: Stripe) -> Iterator[Float64s]:
    """The convex polygons of a stripe: a rectangle along each leg, a round joint between two.

    Each is (n, 2), x and y in metres, clockwise on the map: rows of a tile go north, so in the
    tile's image it is counter-clockwise.
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
        yield joint + half * _UNIT_CIRCLE


_UNIT_CIRCLE = np.array([[cos(2 * pi * k / 16), -sin(2 * pi * k / 16)] for k in range(16)])


def _overlaps(piece: Float64s, west: float, south: float, side: float) -> bool:
    """Whether the box about a polygon overlaps a square with that south-west corner."""
    low, high = piece.min(0), piece.max(0)
    return bool(
        low[0] < west + side and high[0] > west and low[1] < south + side and high[1] > south
    )


# Noise. K. Perlin, *An image synthesizer*, SIGGRAPH 1985: octaves of one noise field, each of
# twice the wavelength of the one before.


def _add_noise(tile: Pixels, level: int, column: int, row: int) -> None:
    """Add noise of every wavelength to a tile, so that motion over bare ground can be seen.

    The wavelengths of a tile begin at its own texel. Each octave repeats after TILE_TEXELS of its
    samples.
    """
    corner = column * TILE_TEXELS, row * TILE_TEXELS
    # All octaves but the finest are added up at samples some texels apart, from one sample before
    # the tile to one behind it, and interpolated; the finest lies on the texels themselves.
    step = TILE_TEXELS // _COARSE_SAMPLES
    coarse = np.zeros((_COARSE_SAMPLES + 2, _COARSE_SAMPLES + 2), np.float32)
    for octave in range(1, _OCTAVES):
        coarse += _octave(level, octave, corner, step)
    total = _resampled(coarse, 1 / step, (0.5 / step + 0.5, 0.5 / step + 0.5), TILE_TEXELS)
    total += np.roll(_noise_field(), (-91 * level, -37 * level), (0, 1))
    added = np.rint(total).astype(np.int16)
    cv2.add(tile, cv2.merge([added, added, added, np.zeros_like(added)]), tile, dtype=cv2.CV_8U)


def _octave(level: int, octave: int, corner: tuple[int, int], step: int) -> Float32s:
    """One octave at the coarse samples of the tile with that corner (texels).

    Samples are ``step`` texels apart, the first one half a step before the corner.
    """
    share, shift = 0.5**octave, level + octave
    east, north = (
        ((place - step / 2) * share - 0.5 + offset * shift) % TILE_TEXELS
        for place, offset in zip(corner, (37, 91), strict=True)
    )
    return _resampled(_noise_field(), step * share, (east, north), _COARSE_SAMPLES + 2)


def _resampled(field: Float32s, scale: float, begin: tuple[float, float], count: int) -> Float32s:
    """``count`` × ``count`` samples of a repeating field, ``scale`` of its cells apart."""
    move = np.array([[scale, 0, begin[0]], [0, scale, begin[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = (count, count)
    return np.asarray(
        cv2.warpAffine(field, move, size, flags=flags, borderMode=cv2.BORDER_WRAP), np.float32
    )


@cache
def _noise_field() -> Float32s:
    """Uniform noise, always the same; (TILE_TEXELS, TILE_TEXELS), grey levels."""
    drawn = generator(0, "ground").randbytes(TILE_TEXELS * TILE_TEXELS)
    field = np.frombuffer(drawn, np.uint8).reshape(TILE_TEXELS, TILE_TEXELS).astype(np.float32)
    return (field / 127.5 - 1) * _NOISE_AMPLITUDE
