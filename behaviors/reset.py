"""reset: leave the emergency state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.manoeuvre import PendingOrder
from behaviors.params import BehaviorParams, param
from behaviors.plan import Legs, PlanStart
from fsm.host import Outcome


class Reset(Behavior):
    """Let the vehicle leave its emergency state on the ground, so that it can take off again."""

    class Params(BehaviorParams):
        timeout: float = param(30.0, unit="s", min=0.1, help="then it has failed")

    requires = ("reset",)

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        return []

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        self.pending = PendingOrder(flight.reset(), flight.now, self.params.timeout, progress)

    def step(self, flight: Flight) -> Outcome | str | None:
        return self.pending.step(flight)

    def progress(self) -> dict[str, Any]:
        return self.pending.progress()
