"""A quadrotor in the pictures of a test: rendered where the test says it is."""

from __future__ import annotations

from collections.abc import Callable

from hal.raster import Raster
from hal.scene.appearance import quadrotor
from hal.scene.arrays import Pixels
from hal.sim.sensors.camera_spec import CameraSpec
from hal.vehicle import Intrinsics
from tests.behaviors.sighted import Look
from tests.hal.scenes import world_of
from vencejo.geometry import Point, Pose, Quaternion, about_x, about_y, product, yaw_quaternion
from worlds.colors import COLORS
from worlds.world import Light

SIZE = 0.52
MIDDLE = 0.06
"""Height of a quadrotor's middle over its place, metres."""
PLAIN = CameraSpec().intrinsics


def turned(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> Quaternion:
    """Body to world of a vehicle turned so, radians."""
    return product(product(yaw_quaternion(yaw), about_y(pitch)), about_x(roll))


def quadrotor_at(
    where: Callable[[float], Pose | None], color: str = "red", lens: Intrinsics = PLAIN
) -> Look:
    """A look at a meadow with a quadrotor whose middle is at a pose at each time; None: nowhere."""
    body = quadrotor("mouse", color=COLORS[color])
    renderer = Raster(world_of(light=Light()), {"mouse": body}, False)

    def look(eye: Pose, time: float) -> Pixels:
        pose = where(time)
        return renderer.render(eye, lens, time, {} if pose is None else {"mouse": pose})

    return look


def at(place: Point, yaw: float = 0.0) -> Pose:
    """The pose of the middle of a level vehicle whose place is there."""
    return place.plus((0.0, 0.0, MIDDLE)), turned(yaw)
