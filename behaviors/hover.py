"""hover: stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.guidance import NEARBY, Reference, yaw_towards
from behaviors.params import BehaviorParams, Heading, live
from behaviors.plan import Legs, PlanStart, leg_to
from fsm.host import Outcome
from vencejo.geometry import Point, distance

SPEED = 1.0
"""Speed at which it flies to a new place, m/s."""


class Hover(Behavior):
    """Stay where it comes to rest, or at a point, until the state is left. Never ends by itself."""

    class Params(BehaviorParams):
        at: Point | None = live(None, help="where; without it, where the vehicle stops")
        heading: Heading = live("keep", help="an angle, keep, travel or {face: point}")

    outcomes: ClassVar[Mapping[str, type | None]] = {}
    requires = ("position",)
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        to = start.position if params.at is None else params.at
        return [leg_to(start, start.position, to, SPEED, params.heading)]

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        seen = flight.observation
        self.start_yaw = self.yaw = seen.yaw
        self.reference = Reference(seen.position, seen.velocity)
        self.here = seen.position
        if progress:
            self.start_yaw = progress["start_yaw"]
            if distance(progress["here"], seen.position) <= NEARBY:
                self.yaw = progress["yaw"]
                self.reference = Reference.resumed(progress["reference"])

    def step(self, flight: Flight) -> Outcome | str | None:
        here, reference, at = flight.observation.position, self.reference, self.params.at
        self.here = here
        if at is None:
            reference.stop(flight.observation, flight.dt)
        else:
            reference.step(at, SPEED, flight.observation, flight.dt)
        ahead = reference.position if at is None else at
        self.yaw = yaw_towards(self.params.heading, here, ahead, self.start_yaw, self.yaw)
        flight.command(reference.setpoint(self.yaw))
        return None

    def progress(self) -> dict[str, Any]:
        return {
            "start_yaw": self.start_yaw,
            "yaw": self.yaw,
            "here": list(self.here),
            "reference": self.reference.progress(),
        }
