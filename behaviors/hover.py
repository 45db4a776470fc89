"""hover: stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.guidance import Reference, yaw_towards
from behaviors.params import BehaviorParams, Heading, live
from fsm.vocabulary import Outcome
from vencejo.geometry import Point, distance

SPEED = 1.0
"""How fast it goes to a new place, m/s."""
SETTLED = 0.15
"""Speed below which the vehicle counts as stopped, m/s."""


class Hover(Behavior):
    """Stay where it comes to rest, or at a point, until the state is left. Never ends by itself."""

    class Params(BehaviorParams):
        at: Point | None = live(None, help="where; without it, where the vehicle stops")
        heading: Heading = live("keep", help="an angle, keep or {face: point}")

    outcomes: ClassVar[Mapping[str, type | None]] = {}
    requires = ("position",)

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        seen = flight.observation
        self.start_yaw = self.yaw = seen.yaw
        self.rest: Point | None = None
        self.reference = Reference(seen.position, seen.velocity)

    def step(self, flight: Flight) -> Outcome | str | None:
        seen = flight.observation
        target = self.params.at or self.rest
        if target is None:
            # Brake along the way it was going, then stay at that very point.
            self.reference.step(self.reference.position, SPEED, seen.position, flight.dt)
            if distance(self.reference.velocity, (0.0, 0.0, 0.0)) < SETTLED:
                self.rest = self.reference.position
            target = self.reference.position
        else:
            self.reference.step(target, SPEED, seen.position, flight.dt)
        self.yaw = yaw_towards(self.params.heading, seen.position, target, self.start_yaw, self.yaw)
        flight.command(self.reference.setpoint(self.yaw))
        return None
