"""Rendered frames of markers, with known truth."""

from __future__ import annotations

from functools import lru_cache
from math import pi, radians
from random import Random

import numpy as np
from numpy.typing import NDArray

from hal.raster.renderer import Raster
from hal.scene.transforms import rotation_matrix
from hal.sim.sensors.camera_spec import CameraSpec
from hal.sim.sensors.lens import Lens
from hal.vehicle import Frame, Intrinsics
from tests.hal.scenes import thing_of
from vencejo.geometry import (
    OPTICAL,
    Point,
    Pose,
    Quaternion,
    about_x,
    about_y,
    product,
    yaw_quaternion,
)
from worlds.markers import plate_side
from worlds.things import UPRIGHT, Fiducial, Plate, Thing

DOWN = product(about_y(pi / 2), OPTICAL)
"""The attitude of a camera that looks straight down, with east at the top of its picture."""


def marker_of(
    dictionary: str, number: int, at: Point, size: float, attitude: Quaternion = UPRIGHT
) -> Thing:
    """A marker of any dictionary; ``size`` is that of its black square."""
    side = plate_side(dictionary, size)
    texture = Fiducial(dictionary, number)
    name = f"{dictionary}_{number}"
    return thing_of(name, Plate(side, side), at, attitude, (255, 255, 255), texture)


def corners_of(size: float, at: Point, attitude: Quaternion = UPRIGHT) -> NDArray[np.float64]:
    """The corners (4, 3) of a marker in the world, in the order in which they are found."""
    outline = np.array([(-1, 1, 0), (1, 1, 0), (1, -1, 0), (-1, -1, 0)]) * size / 2
    return np.asarray(outline @ rotation_matrix(attitude).T + at, np.float64)


def pixels_of(points: NDArray[np.float64], pose: Pose, lens: Intrinsics) -> NDArray[np.float64]:
    """Where points are seen by a lens without distortion, (n, 2) pixels."""
    at, attitude = pose
    seen = (points - at) @ rotation_matrix(attitude)
    found = seen[:, :2] / seen[:, 2:] * (lens.fx, lens.fy) + (lens.cx, lens.cy)
    return np.asarray(found, np.float64)


def above(draw: Random, height: float, spread: float = 0.25, tilt: float = 3.0) -> Pose:
    """A downward camera's pose about over the origin: ``spread`` is a share of the height, and
    ``tilt`` the standard deviation of roll and pitch, degrees.
    """
    x, y = (draw.uniform(-spread, spread) * height for _ in range(2))
    return Point(x, y, height), product(
        product(yaw_quaternion(draw.uniform(-pi, pi)), small_turn(draw, tilt)), DOWN
    )


def small_turn(draw: Random, degrees: float) -> Quaternion:
    """A draw of roll and pitch with this standard deviation."""
    roll, pitch = (radians(draw.gauss(0, degrees)) for _ in range(2))
    return product(about_x(roll), about_y(pitch))


def photograph(raster: Raster, pose: Pose, camera: CameraSpec, number: int = 0) -> Frame:
    """A frame through a camera's lens: its distortion, blur and noise, drawn by the number."""
    lens = _lens(camera)
    image = lens.develop([raster.render(pose, lens.pinhole, 0.0, {})], number)
    return Frame(image, number, 0.0, camera.intrinsics, *pose)


@lru_cache
def _lens(camera: CameraSpec) -> Lens:
    return Lens(camera, 1, ("test",))
