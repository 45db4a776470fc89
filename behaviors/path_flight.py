"""Flying a smooth path: to its begin, and along it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from behaviors.arrival import PATIENCE, Arrival
from behaviors.flight import Flight
from behaviors.guidance import NEARBY, yaw_along, yaw_towards
from behaviors.leg import Leg
from behaviors.manoeuvre import EPSILON
from behaviors.pace import Pace
from behaviors.params import Heading
from behaviors.path import Path
from behaviors.path_follower import PathFollower
from behaviors.plan import PlannedLeg, Slower
from fsm.host import Outcome
from hal.vehicle import Position
from vencejo.geometry import distance

BEGIN = Arrival(tolerance=0.1, yaw_tolerance=0.3, dwell=0.5)
"""When it is at the begin of its path, and goes on along it."""
_CHORD = 5
"""Nodes of a path that a straight leg of its plan takes together; more where that is short."""
_SHORTEST = 0.25
"""Way from which such a leg is not short, metres: a begin and an end of each cost time in plans."""
_FURTHER = 0.02
"""Least way along a path that counts as going on, metres."""


class PathFlight:
    """Flies to a path and follows it to its end, where it rests: each period ``step``."""

    def __init__(
        self,
        flight: Flight,
        follower: PathFollower,
        speed: float,
        progress: Mapping[str, Any] | None = None,
    ) -> None:
        """``speed`` is that on the way to the path's begin, m/s."""
        seen = flight.observation
        self.follower = follower
        self._speed = speed
        self._start_yaw = self._yaw = seen.yaw
        self.error = 0.0
        """Distance of the vehicle from where it is to be, on the path, metres."""
        self._here, self._now = seen.position, seen.time
        self._way, self._further_at = 0.0, seen.time
        self._leg: Leg | None = None
        if progress is None:
            self._leg = Leg(flight, follower.place)
            return
        self._start_yaw, self._yaw = progress["start_yaw"], progress["yaw"]
        follower.resume(progress["follower"])
        near = distance(progress["here"], seen.position) <= NEARBY
        if progress["leg"] or not near:
            self._leg = Leg(flight, follower.place, progress["leg"])
        if near:
            self._way, self._further_at = progress["way"], seen.time - progress["no_further"]
        elif not progress["leg"]:
            follower.halt()

    @property
    def on_path(self) -> bool:
        """Whether it follows the path; before, it flies to its begin."""
        return self._leg is None

    @property
    def ended(self) -> bool:
        return self._leg is None and self.follower.ended

    def step(self, flight: Flight, heading: Heading) -> Outcome | str | None:
        """Command this period's set-point: the outcome ``done`` at the end of the path, which is
        held then, and ``blocked`` when it does not go on.
        """
        blocked = self._fly(flight, heading)
        if not self.ended:
            return blocked
        flight.command(Position(self.follower.path.places[-1], yaw=self._yaw))
        return "done"

    def _fly(self, flight: Flight, heading: Heading) -> Outcome | None:
        seen, follower = flight.observation, self.follower
        self._here, self._now = seen.position, seen.time
        if heading == "keep":
            heading = self._start_yaw
        if self._leg is not None:
            return self._approach(self._leg, flight, heading)
        follower.step(seen, flight.dt)
        self.error = distance(follower.place, seen.position)
        self._yaw = self._heading(heading, flight)
        flight.command(follower.setpoint(self._yaw))
        if follower.way > self._way + _FURTHER or follower.ended:
            self._way, self._further_at = follower.way, seen.time
        if seen.time - self._further_at < PATIENCE - EPSILON:
            return None
        reason = f"came no further for {PATIENCE:g} s"
        return Outcome("blocked", {"reason": reason, "distance": self.error})

    def _approach(self, leg: Leg, flight: Flight, heading: Heading) -> Outcome | None:
        """Fly to the path's begin, and turn there as it asks for."""
        here, target = flight.observation.position, self.follower.place
        if heading == "travel" and distance(here, target) < NEARBY:
            heading = yaw_along(self.follower.path.direction(self.follower.way), leg.yaw)
        approach = leg.step(flight, target, self._speed, heading)
        self._yaw, self._further_at = leg.yaw, flight.now
        if leg.arrived(approach, BEGIN):
            self._leg = None
        return leg.blocked(approach, None)

    def _heading(self, heading: Heading, flight: Flight) -> float:
        """The yaw asked for on the path, radians."""
        follower = self.follower
        if heading == "travel":
            return yaw_along(follower.path.direction(follower.way), self._yaw)
        here = flight.observation.position
        return yaw_towards(heading, here, follower.place, self._start_yaw, self._yaw)

    def progress(self) -> dict[str, Any]:
        """The progress to resume from, as JSON."""
        return {
            "start_yaw": self._start_yaw,
            "yaw": self._yaw,
            "here": list(self._here),
            "way": self._way,
            "no_further": self._now - self._further_at,
            "leg": self._leg.progress() if self._leg else None,
            "follower": self.follower.progress(),
        }


def planned_along(
    path: Path, pace: Pace, laps: int = 1, slower: Slower | None = None
) -> list[PlannedLeg]:
    """The straight legs that stand for a path in a plan: those of its first lap.

    Its other laps lead along the same places, and are the stay at the end.
    """
    end = (len(path.places) - 1) // laps
    numbers = [0]
    for number in range(_CHORD, end, _CHORD):
        if path.ways[number] - path.ways[numbers[-1]] >= _SHORTEST:
            numbers.append(number)
    numbers.append(end)
    speed = path.length / pace.duration
    *legs, last = (PlannedLeg(path.places[number], speed, slower=slower) for number in numbers[1:])
    return [*legs, replace(last, dwell=pace.duration * (laps - 1) / laps)]
