"""The pinhole camera of one image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hal.scene.arrays import Bools, Float64s
from hal.scene.surfaces import clip_polygon
from hal.scene.transforms import camera_matrix, rotation_matrix
from hal.vehicle import Intrinsics
from vencejo.geometry import Pose

NEAR = 0.0005
"""Depth of the near plane: what is nearer is not seen, metres."""
_AHEAD = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class PinholeCamera:
    """Projects points of the world frame. Camera axes: x right, y down, z (the depth) out."""

    eye: Float64s
    """World frame, metres."""
    rotation: Float64s
    """(3, 3), camera axes to world."""
    matrix: Float64s
    """(3, 3), camera axes to pixels."""
    width: int
    height: int

    @classmethod
    def at(cls, pose: Pose, intrinsics: Intrinsics) -> PinholeCamera:
        """The camera of a pose (camera axes to world); distortion is left out."""
        eye, rotation = np.array(pose[0], float), rotation_matrix(pose[1])
        return cls(eye, rotation, camera_matrix(intrinsics), intrinsics.width, intrinsics.height)

    def to_camera(self, points: Float64s) -> Float64s:
        """Points (…, 3) of the world in camera axes."""
        return (points - self.eye) @ self.rotation

    def to_pixels(self, points: Float64s) -> Float64s:
        """The pixels (…, 2) where points (…, 3) in camera axes are seen; depths are above 0."""
        m = self.matrix
        depth = points[..., 2]
        return np.stack(
            [
                m[0, 0] * points[..., 0] / depth + m[0, 2],
                m[1, 1] * points[..., 1] / depth + m[1, 2],
            ],
            -1,
        )

    def clipped(self, polygon: Float64s) -> list[Float64s]:
        """The corners, in camera axes, of what of a polygon lies beyond the near plane."""
        return clip_polygon(polygon, _AHEAD, NEAR)

    def may_see(self, centers: Float64s, radii: Float64s) -> Bools:
        """A mask of the spheres that reach into the field of view.

        Centres (n, 3) and radii (n,) are in the world frame, metres.
        """
        x, y, z = self.to_camera(centers).T
        m = self.matrix
        seen = z > NEAR - radii
        for along, focal, middle, size in (
            (x, m[0, 0], m[0, 2], self.width),
            (y, m[1, 1], m[1, 2], self.height),
        ):
            for sign, edge in ((1.0, middle + 1), (-1.0, size - middle)):
                seen &= sign * focal * along + edge * z > -radii * np.hypot(focal, edge)
        return np.asarray(seen, bool)
