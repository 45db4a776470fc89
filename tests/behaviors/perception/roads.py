"""Helpers: roads drawn on the ground, as a camera above sees them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import cv2
import numpy as np

from behaviors.perception.ground_map import GroundMap
from behaviors.perception.projection import pixels_of
from hal.scene.arrays import Pixels
from hal.vehicle import Frame, Intrinsics
from vencejo.geometry import OPTICAL, Point, Quaternion, about_y, product

LENS = Intrinsics.from_field_of_view(640, 480, 1.4)
DOWN: Quaternion = product(about_y(np.pi / 2), OPTICAL)
"""A camera that looks down, east at the top of the picture."""
ABOVE = Point(0.0, 0.0, 10.0)
XY = tuple[float, float]


def frame_at(place: Point = ABOVE, attitude: Quaternion = DOWN, lens: Intrinsics = LENS) -> Frame:
    """A frame without an image that matters."""
    return Frame(np.zeros((lens.height, lens.width, 3), np.uint8), 0, 0.0, lens, place, attitude)


def drawn(frame: Frame, lines: Sequence[Sequence[XY]], width: float) -> Pixels:
    """The mask of roads along some lines, with flat ends and round corners, as a frame sees it."""
    mask = np.zeros(frame.image.shape[:2], np.uint8)
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = width / 2 * np.stack([np.cos(angles), np.sin(angles)], 1)
    for line in lines:
        for corner in line[1:-1]:
            points = np.concatenate([ring + corner, np.zeros((24, 1))], 1)
            pixels = np.rint(pixels_of(frame, points) * 16).astype(np.int32)
            cv2.fillConvexPoly(mask, pixels, 255, shift=4)
        for a, b in pairwise(line):
            way = np.subtract(b, a) / np.hypot(*np.subtract(b, a))
            aside = np.array([-way[1], way[0]]) * width / 2
            corners = [a + aside, b + aside, b - aside, a - aside]
            points = np.concatenate([corners, np.zeros((4, 1))], 1)
            pixels = np.rint(pixels_of(frame, points) * 16).astype(np.int32)
            cv2.fillConvexPoly(mask, pixels, 255, shift=4)
    return mask


def mapped(lines: Sequence[Sequence[XY]], width: float = 0.8, cell: float = 0.04) -> GroundMap:
    """The map of roads seen from 10 m above the origin: 6 m about it."""
    ground = GroundMap(cell)
    frame = frame_at()
    assert ground.add(drawn(frame, lines, width), frame)
    return ground
