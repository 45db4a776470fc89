"""Blobs: connected parts of a mask, with their outlines."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import cv2
import numpy as np

from hal.scene.arrays import Box, Int32s, Pixels


@dataclass(frozen=True, eq=False)
class Blob:
    """A connected part of a mask; pixels."""

    x: float
    """Of its centroid."""
    y: float
    area: float
    """The number of its pixels, holes included."""
    box: Box
    """Left, top, right and bottom; right and bottom are outside."""
    contour: Int32s
    """(n, 2), the pixels along its edge."""

    @property
    def width(self) -> int:
        return self.box[2] - self.box[0]

    @property
    def height(self) -> int:
        return self.box[3] - self.box[1]


def blobs(mask: Pixels, min_area: float = 1.0, max_area: float = inf) -> list[Blob]:
    """The blobs of a mask (height, width; 0 is outside) of these areas, largest first."""
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    found = [_blob(np.asarray(contour, np.int32).reshape(-1, 2)) for contour in contours]
    kept = [blob for blob in found if min_area <= blob.area <= max_area]
    return sorted(kept, key=lambda blob: (-blob.area, blob.box))


def _blob(contour: Int32s) -> Blob:
    # The contour leads through the centres of pixels: what is outside of it, up to their outer
    # edges, is half of its length and a pixel more (Pick's theorem).
    moments = cv2.moments(contour.reshape(-1, 1, 2))
    left, top, width, height = cv2.boundingRect(contour)
    inner = moments["m00"]
    area = inner + len(contour) / 2 + 1 if len(contour) > 1 else 1.0
    if inner > 0:
        x, y = moments["m10"] / inner, moments["m01"] / inner
    else:
        x, y = map(float, contour.mean(0))
    return Blob(x, y, area, (left, top, left + width, top + height), contour)


def touches_edge(blob: Blob, image: Pixels) -> bool:
    """Whether a blob reaches the edge of its image, so that more of it may be outside."""
    height, width = image.shape[:2]
    left, top, right, bottom = blob.box
    return left <= 0 or top <= 0 or right >= width or bottom >= height
