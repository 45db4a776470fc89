"""route: fly a list of points in order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.leg import Arrival, Blocked, Leg
from behaviors.params import BehaviorParams, Heading, Route, Waypoint, param, value
from behaviors.plan import Legs, PlannedLeg, PlanStart, leg_to
from fsm.host import Outcome
from vencejo.geometry import Point


@dataclass(frozen=True, slots=True)
class Passage:
    """Progress along a route."""

    index: int = 0
    """Index of the point that the vehicle flies to, from 0."""
    count: int = 0
    """Number of points in the route."""
    distance: float = value("m")
    """Distance to that point."""


@dataclass(frozen=True, slots=True)
class Reached:
    """A point of the route that was reached."""

    index: int
    position: Point


class FlyRoute(Behavior):
    """Fly points in order; each may have its own ``{at, heading, speed, dwell}``.

    A point is reached inside ``tolerance``; without a dwell the vehicle goes on at once. The last
    one is held afterwards.
    Raises ``route.reached`` at each point. Ends in ``blocked`` like a goto. Entered again by way
    of a history state, it goes on with the point it was heading for.
    """

    name = "route"

    class Params(BehaviorParams):
        points: Route = param(help="points, or maps {at, heading, speed, dwell}")
        speed: float = param(2.0, unit="m/s", min=0.05, max=20.0, help="where a point names none")
        heading: Heading = param("travel", help="where a point names none")
        dwell: float = param(0.0, unit="s", min=0.0, help="stay at each point")
        # The threshold for straight lines of the beacon application of Yagüe, 2015.
        tolerance: float = param(0.5, unit="m", min=0.02, help="distance that counts as reached")
        yaw_tolerance: float = param(
            0.15, unit="rad", min=0.01, help="where a heading is asked for"
        )
        timeout: float | None = param(None, unit="s", min=0.1, help="for one point; then blocked")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None, "blocked": Blocked}
    events: ClassVar[Mapping[str, type | None]] = {"route.reached": Reached}
    publishes = Passage
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        legs: list[PlannedLeg] = []
        here = start.position
        for point in params.points:
            heading = params.heading if point.heading is None else point.heading
            dwell = params.dwell if point.dwell is None else point.dwell
            speed = params.speed if point.speed is None else point.speed
            legs.append(leg_to(start, here, point.at, speed, heading, dwell))
            here = point.at
        return legs

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        progress = progress or {}
        self.index = progress.get("index", 0)
        points = self.params.points
        # A route that lost points while it was interrupted may have none left to fly.
        self.leg: Leg | None = None
        if self.index < len(points):
            self.leg = Leg(flight, points[self.index].at, progress.get("leg"))

    def step(self, flight: Flight) -> Outcome | str | None:
        params, leg = self.params, self.leg
        if leg is None:
            return "done"
        point: Waypoint = params.points[self.index]
        heading = params.heading if point.heading is None else point.heading
        dwell = params.dwell if point.dwell is None else point.dwell
        approach = leg.step(flight, point.at, point.speed or params.speed, heading)
        flight.publish(Passage(self.index, len(params.points), approach.distance))
        # Where it flies on at once, it waits for no heading but the one of this very point.
        turned = params.yaw_tolerance if dwell or point.heading is not None else inf
        if not leg.arrived(flight, approach, Arrival(params.tolerance, turned, dwell)):
            return leg.blocked(flight, approach, params.timeout)
        flight.raise_event("route.reached", Reached(self.index, point.at))
        self.index += 1
        if self.index == len(params.points):
            leg.rest(flight)
            return "done"
        leg.begin(params.points[self.index].at, flight.now)
        return None

    def progress(self) -> dict[str, Any]:
        return {"index": self.index, "leg": self.leg.progress() if self.leg else None}
