"""Pixels to the world and back, by the time, pose, intrinsics and distortion of their frame.

The frame says where its camera was and how it was turned when the picture was taken, so a tilted
vehicle measures as well as a level one. World axes and origin are those of the frame's pose: the
mission frame in a behaviour, the world frame from a vehicle. A pixel's centre is a whole number.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, atan2, hypot

import numpy as np
from numpy.typing import ArrayLike

from hal.scene.arrays import Bools, Float64s
from hal.scene.distortion import pixels_of as distorted_pixels
from hal.scene.distortion import rays_of
from hal.scene.transforms import rotation_matrix
from hal.vehicle import Frame
from vencejo.geometry import Point, Quaternion

_NEAR = 1e-6
"""Least depth before the camera, and least slope downwards, of what is projected."""


def directions(frame: Frame, pixels: ArrayLike) -> Float64s:
    """Unit vectors (n, 3), world axes, from the camera through pixels (n, 2)."""
    rays = rays_of(np.asarray(pixels, np.float64).reshape(-1, 2), frame.intrinsics)
    out = np.concatenate([rays, np.ones((len(rays), 1))], 1)
    out /= np.sqrt((out * out).sum(1, keepdims=True))
    return np.asarray(out @ rotation_matrix(frame.attitude).T, np.float64)


def direction(frame: Frame, pixel: Sequence[float]) -> Point:
    """The unit vector, world axes, from the camera through one pixel."""
    return Point(*map(float, directions(frame, [pixel])[0]))


def bearing(frame: Frame, pixel: Sequence[float]) -> tuple[float, float]:
    """Azimuth, counter-clockwise from east, and elevation above the level of a pixel, radians."""
    x, y, z = direction(frame, pixel)
    return atan2(y, x), atan2(z, hypot(x, y))


def ground_points(frame: Frame, pixels: ArrayLike, height: float = 0.0) -> Float64s:
    """Where the rays through pixels (n, 2) meet the level plane at ``height``, metres: (n, 3).

    NaN where a ray does not come down to it.
    """
    return level_points(frame.position, directions(frame, pixels), height)


def ground_point(frame: Frame, pixel: Sequence[float], height: float = 0.0) -> Point | None:
    """Where the ray through a pixel meets the level plane at ``height``; None where it does not."""
    x, y, z = map(float, ground_points(frame, [pixel], height)[0])
    return None if np.isnan(x) else Point(x, y, z)


def level_points(eye: Sequence[float], rays: Float64s, height: float) -> Float64s:
    """Where rays (n, 3) from an ``eye`` meet the level plane at ``height``: (n, 3).

    NaN where a ray leads away from it, or along it.
    """
    start = np.asarray(eye, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (height - start[2]) / rays[:, 2]
    far[~((np.abs(rays[:, 2]) > _NEAR) & (far > 0))] = np.nan
    found = start + far[:, None] * rays
    found[:, 2] = np.where(np.isnan(far), np.nan, height)
    return np.asarray(found, np.float64)


def pixels_of(frame: Frame, points: ArrayLike) -> Float64s:
    """The pixels (n, 2) where points (n, 3) of the world are seen, in the image or beside it.

    NaN for what is behind the camera; NaN or infinite for what is too far off for a float.
    """
    given = np.asarray(points, np.float64).reshape(-1, 3)
    found = np.full((len(given), 2), np.nan)
    with np.errstate(over="ignore", invalid="ignore"):
        inside = (given - frame.position) @ rotation_matrix(frame.attitude)
        depth = inside[:, 2]
        ahead = depth > _NEAR
        found[ahead] = distorted_pixels(inside[ahead, :2] / depth[ahead, None], frame.intrinsics)
    return found


def is_inside(frame: Frame, pixels: Float64s, margin: float = 0.0) -> Bools:
    """A mask of the pixels (n, 2) in the image that are ``margin`` pixels from its edge or more."""
    lens = frame.intrinsics
    x, y = pixels[:, 0], pixels[:, 1]
    with np.errstate(invalid="ignore"):
        across = (x >= margin - 0.5) & (x <= lens.width - 0.5 - margin)
        down = (y >= margin - 0.5) & (y <= lens.height - 0.5 - margin)
    return np.asarray(across & down, bool)


def tilt_of(attitude: Quaternion) -> float:
    """The angle between a body's upright axis and the vertical, radians."""
    x, y, _, _ = attitude
    return acos(max(-1.0, min(1.0, 1 - 2 * (x * x + y * y))))
