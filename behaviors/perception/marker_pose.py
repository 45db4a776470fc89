"""The pose of a fiducial marker, from its corners and what is known of it already.

A camera whose attitude is known (from the vehicle's) sees how far away a marker is far better than
one that has to find its own tilt in the same few pixels: with the rotation fixed, the translation
is a linear least-squares problem of the four corners. Each corner p = t + R·k, in optical axes,
that is seen at the undistorted image point (u, v) gives u·p_z = p_x and v·p_z = p_y (the direct
linear transformation: R. Hartley, A. Zisserman, *Multiple View Geometry in Computer Vision*, 2nd
edition, 2003, chapter 4). A marker that is known to lie level, or to stand upright, leaves only its
heading ψ open, and in cos ψ and sin ψ the equations are linear as well. What is known of neither
is found as a full pose (T. Collins, A. Bartoli, *Infinitesimal Plane-based Pose Estimation*, 2014).

The frame of a marker: x to the right and y to the top of its picture, z out of it towards who looks
at it; its heading is the direction of x for one that lies and that of z for one that stands, as
world files mean it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot
from typing import Literal

import cv2
import numpy as np

from hal.scene.arrays import Float64s
from hal.scene.distortion import rays_of
from hal.scene.transforms import rotation_matrix
from hal.vehicle import Frame
from vencejo.geometry import Point

Posture = Literal["level", "upright", "any"]
"""What is known of a marker: it lies, facing up; it stands, facing any side; or neither."""

PIXEL_NOISE = 0.4
"""Standard deviation of a corner's place, pixels (sub-pixel refined, with sensor noise of 3)."""
ATTITUDE_NOISE = 0.005
"""Standard deviation of the camera's attitude, radians (0.3°)."""
_OUTLINE = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)])
"""The corners of a marker of size 1 in its x and y, in the order in which they are found."""


@dataclass(frozen=True, eq=False)
class MarkerPose:
    """Where a marker is, in the world axes of the frame's pose."""

    position: Point
    """Of its centre, metres."""
    heading: float
    """Of its x axis where it lies level, of its z axis where it stands; radians."""
    covariance: Float64s
    """(3, 3) of the position, m²: of the corners' noise and that of the camera's attitude."""
    error: float
    """Root mean square distance of the corners from where this pose puts them, pixels."""


def marker_pose(
    frame: Frame,
    corners: Float64s,
    size: float,
    posture: Posture = "level",
    height: float | None = None,
) -> MarkerPose | None:
    """The pose of a marker whose black square has sides of ``size`` metres.

    ``corners`` are (4, 2) pixels of ``frame``, as a FiducialDetector gives them. ``height`` is that
    of the marker's centre, where it is known otherwise (from an altimeter, for one on the ground).
    None when no such marker can be seen so: behind the camera, or from its back.
    """
    points = rays_of(corners, frame.intrinsics)
    turn = rotation_matrix(frame.attitude)
    if posture == "any":
        return _full_pose(frame, points, turn, size)
    axes = _heading(points, turn, posture)
    if axes is None:
        return None
    offsets = size * _OUTLINE @ axes
    return _placed(frame, points, turn, offsets, _facing(axes, posture), height)


def _placed(
    frame: Frame,
    points: Float64s,
    turn: Float64s,
    offsets: Float64s,
    heading: float,
    height: float | None,
) -> MarkerPose | None:
    """The pose of a marker whose corners are at these ``offsets`` (4, 3) from its centre, in world
    axes: the least-squares translation.
    """
    rows, _ = _equations(points, turn)
    right = -np.einsum("ij,ij->i", rows, np.repeat(offsets, 2, axis=0))
    if height is None:
        unknown, known = rows, right
    else:
        unknown, known = rows[:, :2], right - rows[:, 2] * (height - frame.position.z)
    normal = unknown.T @ unknown
    try:
        inverse = np.linalg.inv(normal)
    except np.linalg.LinAlgError:
        return None
    away = inverse @ (unknown.T @ known)
    covariance = np.zeros((3, 3))
    if height is not None:
        away = np.append(away, height - frame.position.z)
    seen = (offsets + away) @ turn
    if not np.isfinite(away).all() or (seen[:, 2] <= 0.0).any():
        return None
    focal = frame.intrinsics.fx
    free = len(inverse)
    noise = seen[:, 2].mean() * PIXEL_NOISE / focal
    covariance[:free, :free] = inverse * noise * noise
    level = ATTITUDE_NOISE * float(np.linalg.norm(away))
    covariance[:free, :free] += np.eye(free) * level * level
    missed = (seen[:, :2] / seen[:, 2:] - points) * focal
    x, y, z = away.tolist()
    error = float(np.sqrt((missed * missed).sum(axis=1).mean()))
    return MarkerPose(frame.position.plus((x, y, z)), heading, covariance, error)


def _equations(points: Float64s, turn: Float64s) -> tuple[Float64s, Float64s]:
    """The rows (8, 3) that are orthogonal to the ray of each corner, in world axes, two for each;
    and in which corner each is.
    """
    rows = np.empty((8, 3))
    rows[0::2] = points[:, :1] * turn[:, 2] - turn[:, 0]
    rows[1::2] = points[:, 1:] * turn[:, 2] - turn[:, 1]
    return rows, np.repeat(np.arange(4), 2)


def _heading(points: Float64s, turn: Float64s, posture: Posture) -> Float64s | None:
    """The marker's x and y axes (2, 3) in world axes; None when nothing fits."""
    rows, corner = _equations(points, turn)
    across, along = _OUTLINE[corner, 0], _OUTLINE[corner, 1]
    if posture == "level":
        # x = (c, s, 0), y = (−s, c, 0); homogeneous, as the size scales everything.
        c = across * rows[:, 0] + along * rows[:, 1]
        s = across * rows[:, 1] - along * rows[:, 0]
        solution = np.linalg.svd(np.column_stack([rows, c, s]))[2][-1]
        if (turn[:, 2] @ solution[:3]) < 0.0:
            solution = -solution
        c, s = solution[3:]
    else:
        # x = (c, s, 0), y = (0, 0, 1): the upright sides give the scale.
        c, s = across * rows[:, 0], across * rows[:, 1]
        unknown = np.column_stack([rows, c, s])
        solution = np.linalg.lstsq(unknown, -along * rows[:, 2], rcond=None)[0]
        c, s = solution[3:]
    length = hypot(c, s)
    if not np.isfinite(length) or length < 1e-9:
        return None
    c, s = c / length, s / length
    upper = (-s, c, 0.0) if posture == "level" else (0.0, 0.0, 1.0)
    return np.array([(c, s, 0.0), upper])


def _facing(axes: Float64s, posture: Posture) -> float:
    """The heading of a marker with these axes."""
    x, y = axes
    if posture == "level":
        return atan2(x[1], x[0])
    out = np.cross(x, y)
    return atan2(out[1], out[0])


def _full_pose(frame: Frame, points: Float64s, turn: Float64s, size: float) -> MarkerPose | None:
    """The pose of a marker of which nothing is known: the better of the two that IPPE finds."""
    outline = np.column_stack([size * _OUTLINE, np.zeros(4)])
    try:
        count, rotations, _, _ = cv2.solvePnPGeneric(
            outline, points, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE_SQUARE
        )
    except cv2.error:
        return None
    if not count or not np.isfinite(rotations[0]).all():
        return None
    axes = (turn @ cv2.Rodrigues(rotations[0])[0]).T
    lies = abs(axes[2, 2]) > 0.7
    heading = atan2(axes[0, 1], axes[0, 0]) if lies else atan2(axes[2, 1], axes[2, 0])
    return _placed(frame, points, turn, size * _OUTLINE @ axes[:2], heading, None)
