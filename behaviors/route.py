"""route: fly a list of points in order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.leg import Arrival, Blocked, Leg
from behaviors.params import BehaviorParams, Heading, Route, Waypoint, param, value
from fsm.vocabulary import Outcome
from vencejo.geometry import Point


@dataclass(frozen=True, slots=True)
class Passage:
    """Where on the route it is."""

    index: int = 0
    """The point it heads for, from 0."""
    count: int = 0
    """How many there are."""
    distance: float = value("m")
    """To that point."""


@dataclass(frozen=True, slots=True)
class Reached:
    """A point of the route that was reached."""

    index: int
    position: Point


class FlyRoute(Behavior):
    """Fly points in order; each may have its own ``{at, heading, speed, dwell}``.

    A point is reached inside ``tolerance`` (the straight-line threshold of the beacon application
    of Yagüe, 2015); without a dwell the vehicle goes on at once. The last is held like a goto's.
    Raises ``route.reached`` at each point, and resumes at the one it headed for when interrupted.
    """

    name = "route"

    class Params(BehaviorParams):
        points: Route = param(help="points, or maps {at, heading, speed, dwell}")
        speed: float = param(2.0, unit="m/s", min=0.05, max=20.0, help="where a point names none")
        heading: Heading = param("travel", help="where a point names none")
        dwell: float = param(0.0, unit="s", min=0.0, help="stay at each point")
        tolerance: float = param(0.5, unit="m", min=0.02, help="distance that counts as reached")
        yaw_tolerance: float = param(
            0.15, unit="rad", min=0.01, help="where a heading is asked for"
        )
        timeout: float | None = param(None, unit="s", min=0.1, help="for one point; then blocked")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None, "blocked": Blocked}
    events: ClassVar[Mapping[str, type | None]] = {"route.reached": Reached}
    publishes = Passage
    requires = ("position", "velocity")

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        self.index = min(int((progress or {}).get("index", 0)), max(0, len(self.params.points) - 1))
        self.leg = self._leg(flight) if self.params.points else None

    def _leg(self, flight: Flight, before: Leg | None = None) -> Leg:
        point = self.params.points[self.index]
        leg = Leg(flight, point.at, self.params.timeout, point.speed or self.params.speed)
        if before is not None:
            # Fly on smoothly: the reference does not stop at a point without dwell.
            leg.reference, leg.yaw = before.reference, before.yaw
        return leg

    def step(self, flight: Flight) -> Outcome | str | None:
        params, leg = self.params, self.leg
        if leg is None:
            return "done"
        point: Waypoint = params.points[self.index]
        heading = params.heading if point.heading is None else point.heading
        approach = leg.step(flight, point.speed or params.speed, heading)
        flight.publish(Passage(self.index, len(params.points), approach.distance))
        dwell = params.dwell if point.dwell is None else point.dwell
        # A heading is waited for only where one was asked for, not one that follows the way.
        turned = params.yaw_tolerance if dwell or point.heading is not None else 7.0
        if leg.arrived(approach, Arrival(params.tolerance, turned, dwell), flight.now):
            flight.raise_event("route.reached", Reached(self.index, point.at))
            if self.index + 1 == len(params.points):
                return "done"
            self.index += 1
            self.leg = self._leg(flight, leg)
            return None
        blocked = leg.late(approach)
        if blocked:
            return Outcome("blocked", {"reason": blocked.reason, "distance": blocked.distance})
        return None

    def progress(self) -> dict[str, Any]:
        return {"index": self.index}
