"""land: come down and switch off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.landing import PendingLanding
from behaviors.params import BehaviorParams, param
from behaviors.plan import Legs, PlannedLeg, PlanStart
from fsm.host import Outcome


class Land(Behavior):
    """Descend where it is and switch the motors off on the ground.

    Done when it stands on the ground or on a thing, from any height. Where it does not stand, on a
    ball, an edge or a steep roof, it tries again 1.5 m beside, three times; then it has failed.
    """

    class Params(BehaviorParams):
        timeout: float = param(300.0, unit="s", min=1.0, help="then it has failed")

    requires = ("land",)
    ends_landed = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        return [PlannedLeg(start.position._replace(z=start.ground), yaw=start.yaw)]

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        self.pending = PendingLanding(flight.land, flight.now, self.params.timeout, progress)

    def step(self, flight: Flight) -> Outcome | str | None:
        return self.pending.step(flight)

    def progress(self) -> dict[str, Any]:
        return self.pending.progress()
