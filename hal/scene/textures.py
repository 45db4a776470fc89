"""Pictures and markers as textures, with their coarser versions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import log2
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from vencejo.errors import UserError, Where
from worlds.things import Charuco, Fiducial, Image, Texture

Pixels = NDArray[np.uint8]

CELL = 64
"""Texels along a cell of a marker, and of its white border."""
_LARGEST = 2048
"""Pixels along a picture; larger ones are made smaller."""


class Picture:
    """A BGRA picture and its halves, quarters, … down to one pixel."""

    def __init__(self, pixels: Pixels) -> None:
        self._levels = [pixels]

    def level(self, step: float) -> Pixels:
        """The version to be seen in steps of ``step``, a share of the picture's width."""
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
class Painted:
    """A texture whose BGRA pixels are known already."""

    pixels: Pixels


@lru_cache(maxsize=256)
def picture_of(texture: Texture | Painted) -> Picture:
    """The picture of a texture. Raises UserError for a file or a marker that is none."""
    if isinstance(texture, Painted):
        return Picture(texture.pixels)
    if isinstance(texture, Image):
        return load_picture(texture.path)
    if isinstance(texture, Fiducial):
        return Picture(_with_alpha(_marker(texture)))
    return Picture(_with_alpha(_board(texture)))


@lru_cache(maxsize=32)
def load_picture(path: Path) -> Picture:
    """The picture in a file. Raises UserError (``bad-picture``)."""
    pixels = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if pixels is None:
        raise UserError("bad-picture", "this file is no picture that can be read", Where(str(path)))
    most = max(pixels.shape[:2])
    if most > _LARGEST:
        scale = _LARGEST / most
        pixels = cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return Picture(_with_alpha(np.asarray(pixels, np.uint8)))


def _with_alpha(pixels: Pixels) -> Pixels:
    code = cv2.COLOR_GRAY2BGRA if pixels.ndim == 2 else cv2.COLOR_BGR2BGRA
    return np.asarray(cv2.cvtColor(pixels, code), np.uint8)


def dictionary(name: str) -> cv2.aruco.Dictionary:
    """OpenCV's dictionary of that name. Raises UserError (``unknown-dictionary``)."""
    number = getattr(cv2.aruco, f"DICT_{name}", None)
    if number is None:
        raise UserError("unknown-dictionary", f"there is no dictionary of markers '{name}'")
    return cv2.aruco.getPredefinedDictionary(number)


def _marker(fiducial: Fiducial) -> Pixels:
    """A marker with a white border one cell wide."""
    known = dictionary(fiducial.dictionary)
    if not 0 <= fiducial.id < len(known.bytesList):
        raise UserError(
            "no-such-marker",
            f"the dictionary '{fiducial.dictionary}' has no marker {fiducial.id}",
            hint=f"it has 0 to {len(known.bytesList) - 1}",
        )
    cells = known.markerSize + 2
    black = cv2.aruco.generateImageMarker(known, fiducial.id, cells * CELL)
    return np.pad(black, CELL, constant_values=255)


def _board(charuco: Charuco) -> Pixels:
    known = dictionary(charuco.dictionary)
    size = (charuco.columns, charuco.rows)
    board = cv2.aruco.CharucoBoard(size, 1.0, charuco.marker, known)
    square = 8 * CELL
    return np.asarray(board.generateImage((size[0] * square, size[1] * square)), np.uint8)
