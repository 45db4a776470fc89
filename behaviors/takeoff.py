"""takeoff: rise from the ground."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.manoeuvre import PendingOrder
from behaviors.params import BehaviorParams, param
from behaviors.plan import Legs, PlannedLeg, PlanStart
from fsm.host import Outcome


class Takeoff(Behavior):
    """Arm, rise to ``altitude`` above the ground and hold there.

    Done when the altitude is reached, which is measured, not timed. ``failed`` tells why the
    vehicle refused, or that it did not get there in time.
    """

    class Params(BehaviorParams):
        altitude: float = param(1.5, unit="m", min=0.3, max=120.0, help="above the ground here")
        timeout: float = param(30.0, unit="s", min=1.0, help="then it has failed")

    requires = ("takeoff",)
    takes_off = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if start.flying:
            return []  # it stays where it is
        top = start.position.plus((0.0, 0.0, params.altitude))
        return [PlannedLeg(top, yaw=start.yaw)]

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        order = flight.takeoff(self.params.altitude)
        self.pending = PendingOrder(order, flight.now, self.params.timeout, progress)

    def step(self, flight: Flight) -> Outcome | str | None:
        return self.pending.step(flight)

    def progress(self) -> dict[str, Any]:
        return self.pending.progress()
