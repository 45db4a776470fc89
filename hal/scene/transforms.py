"""Rotations and cameras as matrices."""

from __future__ import annotations

import numpy as np

from hal.scene.arrays import Float64s
from hal.vehicle import Intrinsics
from vencejo.geometry import Quaternion


def rotation_matrix(q: Quaternion) -> Float64s:
    """The 3 × 3 matrix that turns vectors (columns) of the rotated frame into the outer one's."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def camera_matrix(intrinsics: Intrinsics) -> Float64s:
    """OpenCV's 3 × 3 camera matrix: optical axes to pixels, distortion left out."""
    return np.array(
        [
            [intrinsics.fx, 0.0, intrinsics.cx],
            [0.0, intrinsics.fy, intrinsics.cy],
            [0.0, 0.0, 1.0],
        ]
    )
