"""One leg: a flight to a point, as goto and each part of a route make it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

from behaviors.flight import Flight
from behaviors.guidance import NEARBY, Reference, yaw_towards
from behaviors.manoeuvre import EPSILON
from behaviors.params import Heading, value
from fsm.host import Outcome
from hal.vehicle import Position
from vencejo.geometry import Point, distance, wrap

PATIENCE = 15.0
"""Seconds without getting nearer to the target after which a leg is blocked."""
NEARER = 0.1
"""Least decrease of the distance that counts as getting nearer, metres."""


@dataclass(frozen=True, slots=True)
class Approach:
    """The remaining way to the target of a leg."""

    distance: float = value("m")
    """Straight line from the vehicle to the target."""
    yaw_error: float = value("rad")
    """Heading still to turn, counter-clockwise."""
    elapsed: float = value("s")
    """Since the leg began."""


@dataclass(frozen=True, slots=True)
class Blocked:
    """The fields of ``blocked``: a target that was not reached."""

    reason: str = ""
    distance: float = value("m")
    """Remaining distance to the target."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """The conditions under which a leg counts as flown."""

    tolerance: float
    """Distance from the target, metres."""
    yaw_tolerance: float
    """Error of the heading, radians."""
    dwell: float
    """Seconds without a break inside both."""


class Leg:
    """Follows a reference to a target: each period ``step``, then ``arrived`` and ``blocked``."""

    def __init__(
        self, flight: Flight, target: Point, progress: Mapping[str, Any] | None = None
    ) -> None:
        seen = flight.observation
        self.start_yaw = self.yaw = seen.yaw
        self.reference = Reference(seen.position, seen.velocity)
        self._here, self._now = seen.position, seen.time
        self.inside_since: float | None = None
        self.begin(target, flight.now)
        if progress:
            self.start_yaw = progress["start_yaw"]
            # From farther away the leg starts anew, with the whole timeout and patience.
            if distance(progress["here"], seen.position) <= NEARBY:
                self._go_on(progress)

    def _go_on(self, progress: Mapping[str, Any]) -> None:
        now, inside, nearest = self._now, progress["inside"], progress["nearest"]
        self.yaw = progress["yaw"]
        self.reference = Reference.resumed(progress["reference"])
        self.started = now - progress["elapsed"]
        self.target = Point(*progress["target"])
        self.inside_since = None if inside is None else now - inside
        self._nearest = inf if nearest is None else nearest
        self._nearer_at = now - progress["no_nearer"]

    def progress(self) -> dict[str, Any]:
        """The progress to resume from, as JSON; times as durations, since the clock goes on."""
        now, inside = self._now, self.inside_since
        return {
            "start_yaw": self.start_yaw,
            "yaw": self.yaw,
            "here": list(self._here),
            "reference": self.reference.progress(),
            "elapsed": now - self.started,
            "target": list(self.target),
            "inside": None if inside is None else now - inside,
            "nearest": None if self._nearest == inf else self._nearest,
            "no_nearer": now - self._nearer_at,
        }

    def begin(self, target: Point, now: float) -> None:
        """Head for the next target from where the reference is, at the speed it has."""
        self.started = now
        self._aim(target, now)

    def _aim(self, target: Point, now: float) -> None:
        self.target = target
        self.inside_since = None
        self._nearest = inf
        self._nearer_at = now

    def step(self, flight: Flight, target: Point, speed: float, heading: Heading) -> Approach:
        """Command this period's set-point, and return the remaining way.

        ``speed`` is in m/s; a new ``target`` restarts the dwell and the patience.
        """
        if target != self.target:
            self._aim(target, flight.now)
        seen = flight.observation
        self._here, self._now = seen.position, seen.time
        self.yaw = yaw_towards(heading, seen.position, target, self.start_yaw, self.yaw)
        self.reference.step(target, speed, seen, flight.dt)
        flight.command(self.reference.setpoint(self.yaw))
        return Approach(
            distance(seen.position, target), wrap(self.yaw - seen.yaw), seen.time - self.started
        )

    def arrived(self, flight: Flight, approach: Approach, arrival: Arrival) -> bool:
        """Whether the vehicle has been inside the tolerances for the dwell."""
        inside = (
            approach.distance <= arrival.tolerance
            and abs(approach.yaw_error) <= arrival.yaw_tolerance
        )
        if not inside:
            self.inside_since = None
            return False
        if self.inside_since is None:
            self.inside_since = flight.now
        return flight.now - self.inside_since >= arrival.dwell - EPSILON

    def rest(self, flight: Flight) -> None:
        """Command the target itself, to be held after the leg."""
        flight.command(Position(self.target, yaw=self.yaw))

    def blocked(self, flight: Flight, approach: Approach, timeout: float | None) -> Outcome | None:
        """The outcome ``blocked`` when the leg is not getting there; None while it is.

        That is after ``timeout`` seconds, or PATIENCE seconds without getting nearer.
        """
        if self.inside_since is not None or approach.distance < self._nearest - NEARER:
            self._nearest = min(self._nearest, approach.distance)
            self._nearer_at = flight.now
        if timeout is not None and approach.elapsed >= timeout - EPSILON:
            reason = f"not there within {timeout:g} s"
        elif flight.now - self._nearer_at >= PATIENCE - EPSILON:
            reason = f"came no nearer for {PATIENCE:g} s"
        else:
            return None
        return Outcome("blocked", {"reason": reason, "distance": approach.distance})
