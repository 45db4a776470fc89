"""Textures as pixels: image files, markers, boards and roundels, with coarser versions of each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import log2
from pathlib import Path

import cv2
import numpy as np

from hal.scene.arrays import Pixels
from vencejo.errors import UserError, Where
from worlds import roundel
from worlds.things import Charuco, Fiducial, Image, Roundel, Texture

_MODULE = 64
"""Texels along a module (bit) of a marker, and so along its white border."""
_LARGEST = 2048
"""Pixels along an image; larger files are scaled down to it."""
_ROUNDEL = 512
"""Texels along the diameter of a roundel's disc."""


class Mipmap:
    """A BGRA image and its halves, quarters, … down to one pixel.

    L. Williams, *Pyramidal parametrics*, SIGGRAPH 1983.
    """

    def __init__(self, pixels: Pixels) -> None:
        self._levels = [pixels]

    def level(self, step: float) -> Pixels:
        """The version whose texels are nearest in size to ``step``, a share of the image's width.

        A coarser version is computed when it is first asked for.
        """
        wanted = max(0, round(log2(max(step * self._levels[0].shape[1], 1.0))))
        while wanted >= len(self._levels):
            last = self._levels[-1]
            height, width = last.shape[:2]
            if height == width == 1:
                return last
            size = (max(1, width // 2), max(1, height // 2))
            self._levels.append(np.asarray(cv2.resize(last, size, interpolation=cv2.INTER_AREA)))
        return self._levels[wanted]


@dataclass(frozen=True, eq=False)
class Bitmap:
    """A texture whose BGRA pixels are known already."""

    pixels: Pixels


@lru_cache(maxsize=256)
def mipmap_of(texture: Texture | Bitmap) -> Mipmap:
    """The pixels of a texture.

    Raises UserError for a file that is no image (``bad-picture``) and for a marker that its
    dictionary does not have (``unknown-dictionary``, ``no-such-marker``).
    """
    if isinstance(texture, Bitmap):
        return Mipmap(texture.pixels)
    if isinstance(texture, Image):
        return load_image(texture.path)
    if isinstance(texture, Fiducial):
        return Mipmap(_with_alpha(_marker(texture)))
    if isinstance(texture, Roundel):
        return Mipmap(_with_alpha(_roundel()))
    return Mipmap(_with_alpha(_board(texture)))


@lru_cache(maxsize=32)
def load_image(path: Path) -> Mipmap:
    """The pixels of an image file. Raises UserError (``bad-picture``)."""
    pixels = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if pixels is None:
        raise UserError("bad-picture", "this file is no picture that can be read", Where(str(path)))
    longest = max(pixels.shape[:2])
    if longest > _LARGEST:
        scale = _LARGEST / longest
        pixels = cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return Mipmap(_with_alpha(np.asarray(pixels, np.uint8)))


def uniform_image(width: int, height: int, color: tuple[int, ...]) -> Pixels:
    """An image of one BGRA colour, (height, width, 4)."""
    # As whole words: filling byte by byte takes twenty times as long.
    word = np.frombuffer(bytes(color), np.uint32)[0]
    return np.full((height, width), word, np.uint32).view(np.uint8).reshape(height, width, 4)


def _with_alpha(pixels: Pixels) -> Pixels:
    code = cv2.COLOR_GRAY2BGRA if pixels.ndim == 2 else cv2.COLOR_BGR2BGRA
    return np.asarray(cv2.cvtColor(pixels, code), np.uint8)


def _dictionary(name: str) -> cv2.aruco.Dictionary:
    """OpenCV's predefined dictionary of that name. Raises UserError (``unknown-dictionary``)."""
    number = getattr(cv2.aruco, f"DICT_{name}", None)
    if number is None:
        raise UserError("unknown-dictionary", f"there is no dictionary of markers '{name}'")
    return cv2.aruco.getPredefinedDictionary(number)


def _marker(fiducial: Fiducial) -> Pixels:
    """A marker in grey, with a white border one module wide."""
    dictionary = _dictionary(fiducial.dictionary)
    count = len(dictionary.bytesList)
    if not 0 <= fiducial.id < count:
        raise UserError(
            "no-such-marker",
            f"the dictionary '{fiducial.dictionary}' has no marker {fiducial.id}",
            hint=f"it has 0 to {count - 1}",
        )
    modules = dictionary.markerSize + 2
    black = cv2.aruco.generateImageMarker(dictionary, fiducial.id, modules * _MODULE)
    plate = np.asarray(np.pad(black, _MODULE, constant_values=255), np.uint8)
    if fiducial.inside is not None:
        _put_inside(plate, _marker(fiducial.inside), fiducial.share)
    return plate


def _put_inside(plate: Pixels, inside: Pixels, share: float) -> None:
    """Draw a smaller plate in the middle of another one."""
    side = len(plate)
    # As many texels on both sides, so that it is in the very middle.
    margin = round(side * (1 - share) / 2)
    left = side - 2 * margin
    scaled = cv2.resize(inside, (left, left), interpolation=cv2.INTER_AREA)
    plate[margin : side - margin, margin : side - margin] = scaled


def _board(charuco: Charuco) -> Pixels:
    """A ChArUco board in grey, without a border."""
    size = (charuco.columns, charuco.rows)
    dictionary = _dictionary(charuco.dictionary)
    board = cv2.aruco.CharucoBoard(size, 1.0, charuco.marker, dictionary)
    square = 8 * _MODULE
    return np.asarray(board.generateImage((size[0] * square, size[1] * square)), np.uint8)


def _roundel() -> Pixels:
    """The oriented roundel in grey, with the line at its right."""
    side, middle = round(roundel.PLATE * _ROUNDEL), round(roundel.PLATE * _ROUNDEL / 2)
    image = np.full((side, side), 255, np.uint8)
    cv2.circle(image, (middle, middle), _ROUNDEL // 2, 0, cv2.FILLED, cv2.LINE_AA)
    _fill(image, (middle, middle), roundel.HOLE, 255)
    _fill(image, (middle + round(roundel.LINE_AT * _ROUNDEL), middle), roundel.LINE, 0)
    return image


def _fill(image: Pixels, centre: tuple[int, int], size: tuple[float, float], grey: int) -> None:
    """Fill an upright rectangle of a roundel; its size is in diameters of the disc."""
    x, y = centre
    half_width, half_height = (round(side * _ROUNDEL / 2) for side in size)
    image[y - half_height : y + half_height, x - half_width : x + half_width] = grey
