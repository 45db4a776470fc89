"""goto: fly to a point."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from behaviors.arrival import Approach, Arrival, Blocked
from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.leg import Leg
from behaviors.params import BehaviorParams, Heading, live, param
from behaviors.plan import Legs, PlanStart, leg_to
from fsm.host import Outcome
from vencejo.geometry import Point


class GoTo(Behavior):
    """Fly to a point in a straight line and stay inside the tolerance for ``dwell``.

    A point of two coordinates keeps the height at the start. Ends in ``blocked`` when it has come
    no nearer for 15 s, or when ``timeout`` is over. The point is held afterwards.
    """

    name = "goto"

    class Params(BehaviorParams):
        to: Point = live(help="where to")
        speed: float = live(2.0, unit="m/s", min=0.05, max=20.0, help="on the way")
        heading: Heading = live("keep", help="an angle, keep, travel or {face: point}")
        tolerance: float = param(0.20, unit="m", min=0.02, help="distance that counts as there")
        tolerance_vertical: float | None = param(
            None, unit="m", min=0.02, help="that in height; then `tolerance` is over the ground"
        )
        yaw_tolerance: float = param(0.15, unit="rad", min=0.01, help="error of the heading")
        dwell: float = param(0.5, unit="s", min=0.0, help="time inside the tolerance")
        timeout: float | None = param(None, unit="s", min=0.1, help="then it is blocked anyway")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None, "blocked": Blocked}
    publishes = Approach
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        return [leg_to(start, start.position, params.to, params.speed, params.heading)]

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params = self.params
        self.leg = Leg(flight, params.to, progress)
        self.arrival = Arrival(
            params.tolerance, params.yaw_tolerance, params.dwell, params.tolerance_vertical
        )

    def step(self, flight: Flight) -> Outcome | str | None:
        params = self.params
        approach = self.leg.step(flight, params.to, params.speed, params.heading)
        flight.publish(approach)
        if self.leg.arrived(approach, self.arrival):
            self.leg.rest(flight)
            return "done"
        return self.leg.blocked(approach, params.timeout)

    def progress(self) -> dict[str, Any]:
        return self.leg.progress()
