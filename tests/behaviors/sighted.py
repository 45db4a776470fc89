"""A vehicle without physics that sees what a test shows it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import floor, pi

from hal.fake import FakeSession, FakeVehicle
from hal.scene.arrays import Pixels
from hal.sim.sensors.camera_spec import CameraSpec
from hal.vehicle import Frame
from tests.behaviors.flying import airborne
from vencejo.geometry import Pose, product, turned
from worlds.world import World

CAMERAS: Mapping[str, CameraSpec] = {
    "front": CameraSpec(at=(0.2, 0.0, 0.02)),
    "ventral": CameraSpec(at=(0.0, 0.0, -0.04), tilt=pi / 2),
}
Look = Callable[[Pose, float], Pixels | None]
"""The image from a pose (optical axes to world) at a time; None for none, as through a fault."""


class Eye:
    """A camera of a vehicle: takes an image at its rate, with the pose of that moment."""

    def __init__(self, vehicle: FakeVehicle, spec: CameraSpec, look: Look) -> None:
        self.look = look
        self._vehicle = vehicle
        self._spec = spec
        self._frame: Frame | None = None
        self._sequence = -1

    def latest(self) -> Frame | None:
        seen, spec = self._vehicle.observe(), self._spec
        sequence = floor(seen.time * spec.rate + 1e-9)
        if sequence != self._sequence:
            self._sequence = sequence
            at = seen.position.plus(turned(spec.at, seen.attitude))
            attitude = product(seen.attitude, spec.attitude)
            image = self.look((at, attitude), seen.time)
            if image is not None:
                lens = spec.intrinsics
                self._frame = Frame(image, sequence, seen.time, lens, at, attitude)
        return self._frame


def sighted(
    look: Look, height: float = 3.0, cameras: Mapping[str, CameraSpec] = CAMERAS
) -> tuple[FakeSession, FakeVehicle]:
    """A vehicle that hovers at a height above the origin, heading east, with these cameras."""
    session, vehicle = airborne(height)
    for name, spec in cameras.items():
        vehicle.cameras[name] = Eye(vehicle, spec, look)
        vehicle.capabilities |= {f"camera.{name}"}
    return session, vehicle


def shown(world: World, cameras: Mapping[str, CameraSpec] = CAMERAS) -> Look:
    """A look at a world, through the lens that the cameras share."""
    from hal.raster import Raster

    renderer = Raster(world, {}, False)
    lens = next(iter(cameras.values())).intrinsics
    return lambda pose, time: renderer.render(pose, lens, time, {})
