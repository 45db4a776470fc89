"""return_home: the vehicle's own way home."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.landing import PendingLanding
from behaviors.params import BehaviorParams, param
from behaviors.plan import Legs, PlannedLeg, PlanStart
from fsm.host import Outcome
from vencejo.geometry import Point


class ReturnHome(Behavior):
    """Let the vehicle fly home by its own means and land there.

    On a real vehicle this is the autopilot's return mode, with its own height and speed. Where it
    does not stand at home it tries to land beside, as ``land`` does. To fly home and stay in the
    air, use ``goto`` with ``to: home``.
    """

    class Params(BehaviorParams):
        timeout: float = param(600.0, unit="s", min=1.0, help="then it has failed")

    requires = ("return_home",)
    ends_landed = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        position = start.position
        height = max(position.z, start.return_height)
        above, home = position._replace(z=height), Point(0.0, 0.0, 0.0)
        return [PlannedLeg(to, yaw=start.yaw) for to in (above, home._replace(z=height), home)]

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        order, timeout = flight.return_home, self.params.timeout
        self.pending = PendingLanding(order, flight.now, timeout, progress)

    def step(self, flight: Flight) -> Outcome | str | None:
        return self.pending.step(flight)

    def progress(self) -> dict[str, Any]:
        return self.pending.progress()
