"""What a behaviour may touch: its vehicle in the mission frame, a clock, draws, a command channel.

The mission frame has its origin where the vehicle stood when the mission began; its axes are the
world's (east, north, up). Here, and only here, positions pass from one frame to the other.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from random import Random
from typing import Any

from behaviors.params import Face, Heading, Waypoint
from fsm.values.functions import EvaluationError, shown
from fsm.values.types import AREA, HEADING, POINT, ROUTE, Type
from hal.vehicle import (
    PERIOD,
    Camera,
    Frame,
    Hold,
    Observation,
    Order,
    Position,
    Sensor,
    Setpoint,
    Vehicle,
    Velocity,
)
from vencejo.geometry import Point, enu_of, rotate_xy


class MissionFrame:
    """Home of one mission: where its points are counted from, and how places are found."""

    def __init__(
        self,
        origin: Point,
        places: Mapping[str, Point] | None = None,
        geographic: tuple[float, float, float] | None = None,
    ) -> None:
        self.origin = origin
        """The mission frame's zero, world frame."""
        self.is_world = origin == (0.0, 0.0, 0.0)
        """Whether the two frames are one, and nothing needs to be moved."""
        self.places = dict(places or {})
        """Places of the world, world frame."""
        self.geographic = geographic
        """Latitude and longitude (degrees) and altitude of the world frame's zero."""

    def from_world(self, point: Point) -> Point:
        return point.minus(self.origin)

    def to_world(self, point: Point) -> Point:
        return point.plus(self.origin)

    def point(self, given: Any, start: Observation) -> Point:
        """The mission-frame point of a value as missions write it.

        ``start`` is the observation (mission frame) when the behaviour began: what is not said
        stays as it was then. Raises EvaluationError.
        """
        if isinstance(given, Point):
            return given
        here = start.position
        if isinstance(given, str):
            if given == "home":
                return Point(0.0, 0.0, here.z)
            if given in self.places:
                return self.from_world(self.places[given])
            known = ", ".join(["home", *sorted(self.places)])
            raise EvaluationError(f"there is no place '{given}' here (known: {known})")
        if not isinstance(given, Mapping):
            raise EvaluationError(f"{shown(given)} is not a point")
        if given.keys() & {"forward", "left", "up"}:
            east, north = rotate_xy(given.get("forward", 0.0), given.get("left", 0.0), start.yaw)
            return here.plus((east, north, given.get("up", 0.0)))
        if "lat" in given:
            if self.geographic is None:
                raise EvaluationError("the vehicle has no geographic position here")
            east, north = enu_of(given["lat"], given["lon"], *self.geographic[:2])
            world = self.from_world(Point(east, north, 0.0))
            return world._replace(z=given.get("above_home", here.z))
        if given.get("frame") == "world":
            there = self.to_world(here)
            named = Point(*(given.get(axis, there[i]) for i, axis in enumerate("xyz")))
            return self.from_world(named)
        return Point(*(given.get(axis, here[i]) for i, axis in enumerate("xyz")))

    def heading(self, given: Any, start: Observation) -> Heading:
        if isinstance(given, Mapping):
            return Face(self.point(given["face"], start))
        return given if isinstance(given, str) else float(given)

    def resolve(self, type_: Type, given: Any, start: Observation) -> Any:
        """A checked value in the form behaviours use: Point, Heading, Route, Area, or itself."""
        if given is None:
            return None
        if type_ == POINT:
            return self.point(given, start)
        if type_ == HEADING:
            return self.heading(given, start)
        if type_ == ROUTE:
            return [self._waypoint(element, start) for element in given]
        if type_ == AREA:
            return [self.point(element, start) for element in given]
        return given

    def _waypoint(self, given: Any, start: Observation) -> Waypoint:
        if isinstance(given, Mapping) and "at" in given:
            heading = given.get("heading")
            return Waypoint(
                self.point(given["at"], start),
                None if heading is None else self.heading(heading, start),
                given.get("speed"),
                given.get("dwell"),
            )
        return Waypoint(self.point(given, start))


class Flight:
    """One vehicle as its behaviours see it during one mission period."""

    def __init__(self, vehicle: Vehicle, frame: MissionFrame, rng: Random) -> None:
        self._vehicle = vehicle
        self.frame = frame
        self.rng = rng
        """Draws for this vehicle's behaviours, fixed by the run's seed."""
        self.dt = PERIOD
        self.setpoint: Setpoint | None = None
        """What was commanded in this period, mission frame."""
        self.order: Order | None = None
        """The manoeuvre that the behaviour at work has asked the vehicle for."""
        self.raise_event: Callable[[str, Any], None] = _no_event
        """Raise a declared event: name and record. Set for the behaviour that is at work."""
        self.publish: Callable[[Any], None] = _no_value
        """Publish a record of the declared class."""
        self.looked: Callable[[str, Frame], None] = _unseen
        """Told of each frame that is read: the camera's name, and the frame in the world frame."""
        self.observe()

    def observe(self) -> Observation:
        """Take the observation of a new period."""
        seen = self.world = self._vehicle.observe()
        """The observation as the vehicle gave it, world frame: for records."""
        frame = self.frame
        if not frame.is_world:
            position, home = frame.from_world(seen.position), frame.from_world(seen.home)
            seen = seen._replace(position=position, home=home)
        self.observation = seen
        """Position and home in the mission frame."""
        self.setpoint = None
        return self.observation

    @property
    def now(self) -> float:
        """Seconds of the vehicle's clock."""
        return self.observation.time

    @property
    def capabilities(self) -> frozenset[str]:
        return self._vehicle.capabilities

    def command(self, setpoint: Setpoint) -> None:
        """Fly a set-point of the mission frame in this period; the last word counts.

        It ends a manoeuvre under way. In a period without either the vehicle holds its place.
        """
        self.setpoint = setpoint
        self.order = None

    def send(self) -> None:
        """Hand this period's set-point to the vehicle, in the world frame."""
        setpoint = self.setpoint
        if isinstance(setpoint, Position) and not self.frame.is_world:
            setpoint = setpoint._replace(xyz=setpoint.xyz.plus(self.frame.origin))
        if setpoint is not None:
            self._vehicle.command(setpoint)

    def arm(self) -> Order:
        return self._vehicle.arm()

    def disarm(self) -> Order:
        return self._vehicle.disarm()

    def takeoff(self, altitude: float) -> Order:
        self.order = self._vehicle.takeoff(altitude)
        return self.order

    def land(self) -> Order:
        self.order = self._vehicle.land()
        return self.order

    def return_home(self) -> Order:
        self.order = self._vehicle.return_home()
        return self.order

    def camera(self, name: str) -> Camera:
        """A camera whose frames carry mission-frame poses. Raises hal's Unavailable."""
        return _MissionCamera(self._vehicle.camera(name), name, self)

    def sensor(self, name: str) -> Sensor:
        """A sensor by name. Raises hal's Unavailable."""
        return self._vehicle.sensor(name)


class _MissionCamera:
    def __init__(self, camera: Camera, name: str, flight: Flight) -> None:
        self._camera = camera
        self._name = name
        self._flight = flight

    def latest(self) -> Frame | None:
        taken = self._camera.latest()
        if taken is None:
            return None
        self._flight.looked(self._name, taken)
        return dataclasses.replace(taken, position=self._flight.frame.from_world(taken.position))


def _no_event(name: str, record: Any = None) -> None:
    raise RuntimeError("events are raised by a behaviour that is at work")


def _no_value(record: Any) -> None:
    raise RuntimeError("values are published by a behaviour that is at work")


def _unseen(camera: str, frame: Frame) -> None:
    """Nobody keeps frames."""


__all__ = ["Flight", "Hold", "MissionFrame", "Position", "Velocity"]
