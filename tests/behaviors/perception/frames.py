"""Frames with known truth for the tests of perception: rendered, distorted, noisy and blurred."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any

from behaviors.perception.projection import directions
from hal.raster import Raster
from hal.scene.arrays import Pixels
from hal.sim.sensors.camera_spec import CameraSpec
from hal.sim.sensors.lens import Lens
from hal.vehicle import Frame, Intrinsics
from vencejo.geometry import Point, Pose, Quaternion, about_x, about_y, product, yaw_quaternion
from worlds.world import World

PLAIN = CameraSpec()
LENSES: Mapping[str, CameraSpec] = {
    "plain": PLAIN,
    "distorted": CameraSpec(distortion=(-0.28, 0.09, 0.001, -0.0008, 0.0)),
    "noisy": CameraSpec(noise=8.0),
    "blurred": CameraSpec(exposure=0.02),
}
"""Lenses to see with; the blurred one moves during its exposure by ``BLUR`` metres."""
BLUR = 0.02
WIDE = Intrinsics.from_field_of_view(320, 240, pi / 3)


def ventral(tilt: float = 0.0, roll: float = 0.0, yaw: float = 0.0) -> Quaternion:
    """Optical axes to world of a camera that looks down from a vehicle turned so, radians."""
    body = product(product(yaw_quaternion(yaw), about_y(tilt)), about_x(roll))
    return product(body, CameraSpec(tilt=pi / 2).attitude)


def front(tilt: float = 0.0, roll: float = 0.0, yaw: float = 0.0) -> Quaternion:
    """Optical axes to world of a camera that looks ahead from a vehicle turned so, radians."""
    body = product(product(yaw_quaternion(yaw), about_y(tilt)), about_x(roll))
    return product(body, CameraSpec().attitude)


def seen_from(world: World, at: Point, attitude: Quaternion, spec: CameraSpec = PLAIN) -> Frame:
    """What a camera sees of a world, with the pose and lens that it has."""
    lens = Lens(spec, 0, ("test",))
    steps = (-0.5, -0.25, 0.0, 0.25, 0.5) if spec.exposure else (0.0,)
    with_blur = [(Point(at.x + BLUR * step, at.y, at.z), attitude) for step in steps]
    renderer = Raster(world, {}, False)
    images = [renderer.render(pose, lens.pinhole, 0.0, {}) for pose in with_blur]
    renderer.close()
    return frame_of(lens.develop(images, 1), (at, attitude), spec.intrinsics)


def frame_of(image: Pixels, pose: Pose, lens: Intrinsics = WIDE, **settings: Any) -> Frame:
    """A frame of an image, taken at a pose."""
    facts = {"sequence": 1, "time": 0.0, **settings}
    return Frame(image=image, intrinsics=lens, position=pose[0], attitude=pose[1], **facts)


def aimed_at(frame: Frame, pixel: tuple[float, float], far: float) -> Point:
    """The place that lies ``far`` metres behind a pixel."""
    (x, y, z) = directions(frame, [pixel])[0] * far
    return frame.position.plus((float(x), float(y), float(z)))
