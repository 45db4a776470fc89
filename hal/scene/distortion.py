"""The distortion of lenses by OpenCV's model: pixels to rays and back."""

from __future__ import annotations

import cv2
import numpy as np

from hal.scene.arrays import Float64s
from hal.scene.transforms import camera_matrix
from hal.vehicle import Intrinsics

# Without its criteria OpenCV stops after five rounds, up to a pixel off. OpenCV 4 takes them by
# a function of its own, which OpenCV 5 has no more.
_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-8)
_UNDISTORT = getattr(cv2, "undistortPointsIter", cv2.undistortPoints)
_UNTURNED = np.zeros(3)


def rays_of(pixels: Float64s, lens: Intrinsics) -> Float64s:
    """The rays (n, 2) to pixels (n, 2): x and y in optical axes at depth 1."""
    if not any(lens.distortion):
        return (pixels - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    if not len(pixels):
        return np.empty((0, 2))
    given = np.ascontiguousarray(pixels, np.float64).reshape(-1, 1, 2)
    coefficients = np.array(lens.distortion)
    straight = _UNDISTORT(
        given, camera_matrix(lens), coefficients, R=None, P=None, criteria=_CRITERIA
    )
    return np.asarray(straight, np.float64).reshape(-1, 2)


def pixels_of(rays: Float64s, lens: Intrinsics) -> Float64s:
    """The pixels (n, 2) where rays (n, 2) are seen, given as x and y at depth 1."""
    if not any(lens.distortion):
        return rays * (lens.fx, lens.fy) + (lens.cx, lens.cy)
    if not len(rays):
        return np.empty((0, 2))
    # OpenCV makes 15 derivatives for each ray: give it an image's row at a time, not an image.
    points = np.concatenate([rays, np.ones((len(rays), 1))], 1)
    coefficients = np.array(lens.distortion)
    seen = cv2.projectPoints(points, _UNTURNED, _UNTURNED, camera_matrix(lens), coefficients)[0]
    return np.asarray(seen, np.float64).reshape(-1, 2)
