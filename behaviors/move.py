"""move: fly at a velocity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.params import BehaviorParams, live
from fsm.host import Outcome
from hal.vehicle import Velocity


class Move(Behavior):
    """Fly at a velocity of the heading frame until the state is left. Never ends by itself."""

    class Params(BehaviorParams):
        forward: float = live(0.0, unit="m/s", help="along the nose")
        left: float = live(0.0, unit="m/s")
        up: float = live(0.0, unit="m/s")
        yaw_rate: float = live(0.0, unit="rad/s", help="counter-clockwise")

    outcomes: ClassVar[Mapping[str, type | None]] = {}
    requires = ("velocity",)
    needs_flight = True

    def step(self, flight: Flight) -> Outcome | str | None:
        p = self.params
        flight.command(Velocity(p.forward, p.left, p.up, "heading", p.yaw_rate))
        return None
