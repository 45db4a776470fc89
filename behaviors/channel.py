"""The channel between a mission and its vehicle: observations in, set-points and orders out.

Observations and set-points are in the mission frame here; positions are converted to and from the
world frame here and nowhere else. Which parts of the channel a behaviour may use is decided by its
own :class:`behaviors.flight.Flight`.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from random import Random
from typing import TYPE_CHECKING, NamedTuple

from behaviors.frame import MissionFrame
from hal.limits import Limits
from hal.orders import Order
from hal.vehicle import (
    ACCEPTED,
    PERIOD,
    Answer,
    Camera,
    Frame,
    Observation,
    Position,
    Reading,
    Sensor,
    Setpoint,
    Vehicle,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

PICTURE_NAME = re.compile(r"[A-Za-z0-9_-]{1,64}")
"""Names that files of pictures can have."""
Draw = Callable[[], "NDArray[np.uint8]"]
"""Draws a picture: BGR, (height, width, 3)."""


class Jump(NamedTuple):
    """A jump of the world frame's origin."""

    epoch: int
    offset: tuple[float, float, float]
    """Change of the world coordinates of every fixed place, metres."""


class Channel:
    """One vehicle as its mission sees it during one mission period."""

    def __init__(self, vehicle: Vehicle, frame: MissionFrame, rng: Random) -> None:
        self.vehicle = vehicle
        self.frame = frame
        self.rng = rng
        """Draws for this vehicle's behaviours, fixed by the run's seed."""
        self.dt = PERIOD
        """The step that the session made to this period, seconds."""
        self.setpoint: Setpoint | None = None
        """The set-point commanded in this period, mission frame; None for none yet."""
        self.commanded: Setpoint | None = None
        """The set-point that the vehicle was given in this period, world frame: for records."""
        self.order: Order | None = None
        """The last manoeuvre that the active behaviour ordered, unless a set-point followed it."""
        self.on_frame: Callable[[str, Frame], None] = _ignore
        """Called with each camera frame that is read: the camera's name, and the frame with its
        pose in the world frame."""
        self.on_photo: Callable[[str, str, Frame], None] = _ignore_photo
        """Called with each frame that is kept under a name: that, the camera's, and the frame."""
        self.on_picture: Callable[[str, Draw], None] = _ignore_picture
        """Called with the name of an annotated picture, and what draws it if it is wanted."""
        self.on_reading: Callable[[str, Reading], None] = _ignore
        """Called with each sensor reading that is read: the sensor's name, the reading."""
        self.jump: Jump | None = None
        """The jump of the world frame that came with this period."""
        self.observe()

    def observe(self, dt: float = PERIOD) -> Observation:
        """Take the observation of a new period, which came ``dt`` seconds after the last."""
        self.dt = dt
        seen = self.world = self.vehicle.observe()
        """The observation as the vehicle gave it, world frame: for records."""
        frame = self.frame
        self.jump = None
        if seen.origin_shift != frame.origin_shift:
            self.jump = Jump(seen.epoch, frame.follow(seen.origin_shift))
        if not frame.is_world:
            position, home = frame.from_world(seen.position), frame.from_world(seen.home)
            seen = seen._replace(position=position, home=home)
        self.observation = seen
        """Position and home in the mission frame."""
        self.setpoint = self.commanded = None
        return self.observation

    @property
    def now(self) -> float:
        """Seconds of the session's clock."""
        return self.observation.time

    def send(self) -> Answer:
        """Hand this period's set-point to the vehicle, in the world frame."""
        setpoint = self.setpoint
        if isinstance(setpoint, Position) and not self.frame.is_world:
            setpoint = setpoint._replace(xyz=self.frame.to_world(setpoint.xyz))
        self.commanded = setpoint
        return ACCEPTED if setpoint is None else self.vehicle.command(setpoint)

    def configure(self, limits: Limits) -> Answer:
        """Change limits whose altitudes are above home (see :meth:`hal.Vehicle.configure`)."""
        return self.vehicle.configure(limits.raised(self.world.home.z))

    def camera(self, name: str) -> Camera:
        """A camera whose frames carry mission-frame poses. Raises hal's Unavailable."""
        return _MissionCamera(self.vehicle.camera(name), name, self)

    def sensor(self, name: str) -> Sensor:
        """A sensor by name. Raises hal's Unavailable."""
        return _MissionSensor(self.vehicle.sensor(name), name, self)


class _MissionCamera:
    def __init__(self, camera: Camera, name: str, channel: Channel) -> None:
        self._camera = camera
        self._name = name
        self._channel = channel

    def latest(self) -> Frame | None:
        taken = self._camera.latest()
        if taken is None:
            return None
        self._channel.on_frame(self._name, taken)
        return dataclasses.replace(taken, position=self._channel.frame.from_world(taken.position))


class _MissionSensor:
    def __init__(self, sensor: Sensor, name: str, channel: Channel) -> None:
        self._sensor = sensor
        self._name = name
        self._channel = channel

    def latest(self) -> Reading | None:
        reading = self._sensor.latest()
        if reading is not None:
            self._channel.on_reading(self._name, reading)
        return reading


def _ignore_photo(name: str, camera: str, frame: Frame) -> None:
    """Ignore a photo: nothing records it."""


def _ignore_picture(name: str, draw: Draw) -> None:
    """Ignore an annotated picture, and do not draw it: nobody wants it."""


def _ignore(name: str, what: Frame | Reading) -> None:
    """Ignore a frame or reading: nothing records them."""
