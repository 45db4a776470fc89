"""One leg: fly to a point and be there. What goto and route have in common."""

from __future__ import annotations

from dataclasses import dataclass

from behaviors.flight import Flight
from behaviors.guidance import Reference, yaw_towards
from behaviors.params import Heading, value
from vencejo.geometry import Point, distance, wrap


@dataclass(frozen=True, slots=True)
class Approach:
    """How far it still is."""

    distance: float = value("m")
    """Straight line from the vehicle to the target."""
    yaw_error: float = value("rad")
    """Heading still to turn, counter-clockwise."""
    elapsed: float = value("s")
    """Since the leg began."""


@dataclass(frozen=True, slots=True)
class Blocked:
    """Why a target was not reached."""

    reason: str = ""
    distance: float = value("m")
    """What was left."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """When a leg counts as flown."""

    tolerance: float
    """Distance from the target, metres."""
    yaw_tolerance: float
    """Error of the heading, radians."""
    dwell: float
    """Seconds without a break inside both."""


class Leg:
    """Follows a reference to its target; ``step`` each period until ``arrived`` or ``late``."""

    def __init__(self, flight: Flight, target: Point, timeout: float | None, speed: float) -> None:
        seen = flight.observation
        self.target = target
        self.started = flight.now
        self.start_yaw = seen.yaw
        self.yaw = seen.yaw
        self.reference = Reference(seen.position, seen.velocity)
        self.inside_since: float | None = None
        self.length = distance(seen.position, target)
        # Twice the time it should take, and time to settle: a leg that is held up ends.
        self.timeout = timeout if timeout is not None else 2 * self.length / speed + 15.0

    def step(self, flight: Flight, speed: float, heading: Heading) -> Approach:
        """Command this period's set-point; how far it still is."""
        seen = flight.observation
        self.yaw = yaw_towards(heading, seen.position, self.target, self.start_yaw, self.yaw)
        self.reference.step(self.target, speed, seen.position, flight.dt)
        flight.command(self.reference.setpoint(self.yaw))
        return Approach(
            distance(seen.position, self.target),
            wrap(self.yaw - seen.yaw),
            flight.now - self.started,
        )

    def retarget(self, target: Point) -> None:
        """Head for another target from where the reference is."""
        if target != self.target:
            self.target = target
            self.inside_since = None

    def arrived(self, approach: Approach, arrival: Arrival, now: float) -> bool:
        inside = (
            approach.distance <= arrival.tolerance
            and abs(approach.yaw_error) <= arrival.yaw_tolerance
        )
        if not inside:
            self.inside_since = None
            return False
        if self.inside_since is None:
            self.inside_since = now
        return now - self.inside_since >= arrival.dwell - 1e-9

    def late(self, approach: Approach) -> Blocked | None:
        if approach.elapsed < self.timeout:
            return None
        return Blocked("not there in time", approach.distance)
