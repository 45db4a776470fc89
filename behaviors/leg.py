"""One leg: a straight flight to a point, as goto makes it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from behaviors.arrival import Approach, Arrival, ArrivalWatch
from behaviors.flight import Flight
from behaviors.guidance import NEARBY, Reference, yaw_towards
from behaviors.params import Heading
from fsm.host import Outcome
from hal.vehicle import Position
from vencejo.geometry import Point, distance


class Leg:
    """Follows a reference to a target: each period ``step``, then ``arrived`` and ``blocked``."""

    def __init__(
        self, flight: Flight, target: Point, progress: Mapping[str, Any] | None = None
    ) -> None:
        seen = flight.observation
        self.start_yaw = self.yaw = seen.yaw
        self._reference = Reference(seen.position, seen.velocity)
        self._watch = ArrivalWatch(seen, target)
        if progress:
            self.start_yaw = progress["start_yaw"]
            # From farther away the leg starts anew, with the whole timeout and patience.
            if distance(progress["watch"]["here"], seen.position) <= NEARBY:
                self.yaw = progress["yaw"]
                self._reference = Reference.resumed(progress["reference"])
                self._watch.resume(progress["watch"])

    def progress(self) -> dict[str, Any]:
        """The progress to resume from, as JSON."""
        return {
            "start_yaw": self.start_yaw,
            "yaw": self.yaw,
            "reference": self._reference.progress(),
            "watch": self._watch.progress(),
        }

    def step(self, flight: Flight, target: Point, speed: float, heading: Heading) -> Approach:
        """Command this period's set-point, and return the remaining way.

        ``speed`` is in m/s; a new ``target`` restarts the dwell and the patience.
        """
        if target != self._watch.target:
            self._watch.aim(target, flight.now)
        seen = flight.observation
        self.yaw = yaw_towards(heading, seen.position, target, self.start_yaw, self.yaw)
        self._reference.step(target, speed, seen, flight.dt)
        flight.command(self._reference.setpoint(self.yaw))
        return self._watch.look(seen, self.yaw)

    def arrived(self, approach: Approach, arrival: Arrival) -> bool:
        """Whether the vehicle has been inside the tolerances for the dwell."""
        return self._watch.arrived(approach, arrival)

    def rest(self, flight: Flight) -> None:
        """Command the target itself, to be held after the leg."""
        flight.command(Position(self._watch.target, yaw=self.yaw))

    def blocked(self, approach: Approach, timeout: float | None) -> Outcome | None:
        """The outcome ``blocked`` when the leg is not getting there; None while it is."""
        return self._watch.blocked(approach, timeout)
