"""A map of the ground about the vehicle, put together from the frames of a camera.

A square of cells in the axes of the frames' poses, which moves with the camera by whole cells. Each
keeps the share of its last looks in which a mask had it. So noise averages out, and what has left
the picture is still known.
"""

from __future__ import annotations

from dataclasses import replace
from math import floor

import cv2
import numpy as np
from numpy.typing import ArrayLike

from behaviors.perception.projection import ground_points
from hal.scene.arrays import Bools, Float32s, Float64s, Pixels
from hal.scene.transforms import camera_matrix, rotation_matrix
from hal.vehicle import Frame, Intrinsics

_CELLS = 320
"""Along each side."""
_SLACK = 16
"""Cells by which the middle may be away from the camera before the map moves."""
_LOOKS = 4.0
"""Looks after which the newest one counts as much as it ever will: one part in so many."""
_FARTHEST = 3.0
"""Corners of a picture that see farther than this many times the camera's height are not used."""
_RIM = 3
"""Pixels along the edge of a picture that are not used: smoothing has no neighbours there."""


class GroundMap:
    """Where a mask is on level ground, as far as it was seen."""

    def __init__(self, cell: float, height: float = 0.0) -> None:
        """``cell``: the side of a cell; ``height``: that of the ground; metres."""
        self.cell = cell
        self._height = height
        self._column = self._row = 0
        """Of the cell [0, 0], in cells from the origin."""
        self._share: Float32s = np.zeros((_CELLS, _CELLS), np.float32)
        self._looks: Float32s = np.zeros((_CELLS, _CELLS), np.float32)
        self._lens: tuple[Intrinsics, tuple[Float32s, Float32s]] | None = None

    def add(self, mask: Pixels, frame: Frame) -> bool:
        """Look at the mask (height, width; 0 to 255) of a frame.

        False for one that looks too far or up, or is too small or not of its lens's size: that
        changes nothing.
        """
        lens = frame.intrinsics
        if mask.shape != (lens.height, lens.width):
            return False
        if any(lens.distortion):
            mask = self._straightened(mask, lens)
            frame = replace(frame, intrinsics=replace(lens, distortion=()))
        corners = self._seen_corners(frame)
        if corners is None:
            return False
        self._follow(frame)
        cells = np.rint((corners / self.cell - (self._column, self._row)) * 16).astype(np.int32)
        inside = np.zeros((_CELLS, _CELLS), np.uint8)
        cv2.fillConvexPoly(inside, cells - 8, 1, shift=4)
        left, top, width, height = cv2.boundingRect(inside)
        part = np.s_[top : top + height, left : left + width]
        to_pixels = self._cells_to_pixels(frame, left, top)
        looked = cv2.warpPerspective(
            mask, to_pixels, (width, height), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        seen, share, looks = inside[part].astype(bool), self._share[part], self._looks[part]
        looks += seen
        np.minimum(looks, _LOOKS, out=looks)
        change = (looked.astype(np.float32) / 255 - share) / np.maximum(looks, 1)
        share += np.where(seen, change, 0)
        return True

    def sample(self, places: ArrayLike) -> tuple[Float32s, Bools]:
        """At places (n, 2): the share of looks in which the mask was there, and whether there was
        any look at all.
        """
        at = np.asarray(places, np.float64).reshape(-1, 2) / self.cell
        x = (at[:, 0] - self._column - 0.5).astype(np.float32)
        y = (at[:, 1] - self._row - 0.5).astype(np.float32)
        share = cv2.remap(self._share, x[None], y[None], cv2.INTER_LINEAR)[0]
        looks = cv2.remap(self._looks, x[None], y[None], cv2.INTER_NEAREST)[0]
        return np.asarray(share, np.float32), np.asarray(looks > 0, bool)

    def whole(self) -> tuple[Pixels, Float64s]:
        """All that the mask has (cells, cells), 1 there, else 0; and the place of cell [0, 0]."""
        road = ((self._share > 0.5) & (self._looks > 0)).astype(np.uint8)
        return road, np.array([self._column + 0.5, self._row + 0.5]) * self.cell

    def _seen_corners(self, frame: Frame) -> Float64s | None:
        """The places (4, 2) of the corners of a picture; None where it is not to be used."""
        lens = frame.intrinsics
        if min(lens.width, lens.height) <= 4 * _RIM:
            return None
        right, bottom = lens.width - 1 - _RIM, lens.height - 1 - _RIM
        pixels = [(_RIM, _RIM), (right, _RIM), (right, bottom), (_RIM, bottom)]
        corners = ground_points(frame, pixels, self._height)[:, :2]
        up = frame.position.z - self._height
        far = np.hypot(*(corners - frame.position[:2]).T)
        return corners if bool((far <= _FARTHEST * up).all()) else None

    def _cells_to_pixels(self, frame: Frame, left: int, top: int) -> Float64s:
        """The homography from cells, counted from one of them, to the pixels that see them."""
        turn = rotation_matrix(frame.attitude).T
        x, y = (self._column + left + 0.5) * self.cell, (self._row + top + 0.5) * self.cell
        origin = np.array([x, y, self._height]) - frame.position
        on_ground = np.stack([turn[:, 0] * self.cell, turn[:, 1] * self.cell, turn @ origin], 1)
        return np.asarray(camera_matrix(frame.intrinsics) @ on_ground, np.float64)

    def _straightened(self, mask: Pixels, lens: Intrinsics) -> Pixels:
        """A mask without its lens's distortion."""
        if self._lens is None or self._lens[0] != lens:
            matrix = camera_matrix(lens)
            maps = cv2.initUndistortRectifyMap(
                matrix,
                np.array(lens.distortion),
                None,
                matrix,
                (lens.width, lens.height),
                cv2.CV_32FC1,
            )
            self._lens = lens, (np.asarray(maps[0], np.float32), np.asarray(maps[1], np.float32))
        return np.asarray(cv2.remap(mask, *self._lens[1], cv2.INTER_LINEAR), np.uint8)

    def _follow(self, frame: Frame) -> None:
        """Move the window with the camera."""
        column, row = (floor(each / self.cell) - _CELLS // 2 for each in frame.position[:2])
        right, down = column - self._column, row - self._row
        if max(abs(right), abs(down)) <= _SLACK:
            return
        self._column, self._row = column, row
        for cells in (self._share, self._looks):
            _shift(cells, right, down)


def _shift(cells: Float32s, right: int, down: int) -> None:
    """Move the window over a field by whole cells; what is new there is 0."""
    kept = np.zeros_like(cells)
    if abs(right) < _CELLS and abs(down) < _CELLS:
        to_y, from_y = _overlap(down)
        to_x, from_x = _overlap(right)
        kept[to_y, to_x] = cells[from_y, from_x]
    cells[:] = kept


def _overlap(shift: int) -> tuple[slice, slice]:
    if shift >= 0:
        return slice(0, _CELLS - shift), slice(shift, _CELLS)
    return slice(-shift, _CELLS), slice(0, _CELLS + shift)
