"""route: fly a list of points in order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.arrival import Blocked
from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.params import BehaviorParams, Heading, Route, Waypoint, param, value
from behaviors.plan import Legs, PlannedLeg, PlanStart, leg_to
from behaviors.waypoint_flight import Goal, Tolerances, WaypointFlight
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

    A point is reached inside ``tolerance``; without a dwell the vehicle passes it in an arc, within
    half of that, as fast as the arc allows. The last one is held afterwards.
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
        tolerance_vertical: float | None = param(
            None, unit="m", min=0.02, help="that in height; then `tolerance` is over the ground"
        )
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
        params, progress = self.params, progress or {}
        self.index = progress.get("index", 0)
        # A route that lost points while it was interrupted may have none left to fly.
        self.way: WaypointFlight | None = None
        if self.index < len(params.points):
            tolerances = Tolerances(
                params.tolerance, params.tolerance_vertical, params.yaw_tolerance
            )
            goals = [self._goal(point) for point in params.points]
            self.way = WaypointFlight(flight, goals, tolerances, self.index, progress.get("way"))

    def _goal(self, point: Waypoint) -> Goal:
        """A point with its own settings or those of the route."""
        params = self.params
        return Goal(
            point.at,
            params.speed if point.speed is None else point.speed,
            params.dwell if point.dwell is None else point.dwell,
            params.heading if point.heading is None else point.heading,
            # Where it flies on at once, it waits for no heading but a point's own.
            turned=point.heading is not None,
        )

    def step(self, flight: Flight) -> Outcome | str | None:
        params, way = self.params, self.way
        if way is None:
            return "done"
        way.step(flight)
        flight.publish(Passage(self.index, len(params.points), way.approach.distance))
        while way.arrived():
            flight.raise_event("route.reached", Reached(self.index, params.points[self.index].at))
            self.index += 1
            if self.index == len(params.points):
                way.rest(flight)
                return "done"
            way.head_for(self.index, flight)
        return way.blocked(params.timeout)

    def progress(self) -> dict[str, Any]:
        return {"index": self.index, "way": self.way.progress() if self.way else None}
