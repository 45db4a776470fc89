"""Arriving at a target: when a vehicle is there, and when it is not getting there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

from behaviors.manoeuvre import EPSILON
from behaviors.params import value
from fsm.host import Outcome
from hal.vehicle import Observation
from vencejo.geometry import Point, distance, horizontal_distance, wrap

PATIENCE = 15.0
"""Seconds without getting nearer to the target after which a leg is blocked."""
NEARER = 0.1
"""Least decrease of the distance that counts as getting nearer, metres."""


@dataclass(frozen=True, slots=True)
class Approach:
    """The remaining way to the target of a leg."""

    distance: float = value("m")
    """Straight line from the vehicle to the target."""
    yaw_error: float = value("rad")
    """Heading still to turn, counter-clockwise."""
    elapsed: float = value("s")
    """Since the leg began."""


@dataclass(frozen=True, slots=True)
class Blocked:
    """The fields of ``blocked``: a target that was not reached."""

    reason: str = ""
    distance: float = value("m")
    """Remaining distance to the target."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """The conditions under which a target counts as reached."""

    tolerance: float
    """Distance from it, metres; over the ground where ``vertical`` is given."""
    yaw_tolerance: float
    """Error of the heading, radians."""
    dwell: float
    """Seconds without a break inside all of them."""
    vertical: float | None = None
    """Distance from it in height, metres; None: ``tolerance`` is all round."""

    def includes(self, place: Point, target: Point) -> bool:
        """Whether a place is within the distances from a target."""
        if self.vertical is None:
            return distance(place, target) <= self.tolerance
        level = horizontal_distance(place, target)
        return level <= self.tolerance and abs(place.z - target.z) <= self.vertical


class ArrivalWatch:
    """Watches a vehicle on its way to a target: each period ``look``, then ``arrived`` and
    ``blocked``.
    """

    def __init__(self, seen: Observation, target: Point) -> None:
        self.here, self._now = seen.position, seen.time
        self.inside_since: float | None = None
        self._before = seen.position
        """Where the vehicle was in the last period."""
        self.begin(target, seen.time)

    def begin(self, target: Point, now: float) -> None:
        """Watch for another target, with the whole timeout and patience."""
        self.started = now
        self.aim(target, now)

    def aim(self, target: Point, now: float) -> None:
        """The target is elsewhere now: dwell and patience begin anew, the timeout goes on."""
        self.target = target
        self.inside_since = None
        self._nearest = inf
        self._nearer_at = now

    def look(self, seen: Observation, yaw: float) -> Approach:
        """Take this period's observation; the remaining way. ``yaw`` is the heading asked for."""
        self._before, self.here, self._now = self.here, seen.position, seen.time
        return Approach(
            distance(seen.position, self.target), wrap(yaw - seen.yaw), seen.time - self.started
        )

    def arrived(self, approach: Approach, arrival: Arrival) -> bool:
        """Whether the vehicle has been inside the tolerances for the dwell.

        Without a dwell it is enough to have been inside since the last period.
        """
        now = self._now
        place = self.here if arrival.dwell else self._nearest_place()
        inside = arrival.includes(place, self.target)
        if not inside or abs(approach.yaw_error) > arrival.yaw_tolerance:
            self.inside_since = None
            return False
        if self.inside_since is None:
            self.inside_since = now
        return now - self.inside_since >= arrival.dwell - EPSILON

    def _nearest_place(self) -> Point:
        """The place nearest to the target on the line flown since the last period."""
        a, way = self._before, self.here.minus(self._before)
        left = self.target.minus(a)
        squared = way.x * way.x + way.y * way.y + way.z * way.z
        along = left.x * way.x + left.y * way.y + left.z * way.z
        share = max(0.0, min(1.0, along / squared)) if squared else 1.0
        return a.plus((way.x * share, way.y * share, way.z * share))

    def blocked(self, approach: Approach, timeout: float | None) -> Outcome | None:
        """The outcome ``blocked`` when the vehicle is not getting there; None while it is.

        That is after ``timeout`` seconds, or PATIENCE seconds without getting nearer.
        """
        if self.inside_since is not None or approach.distance < self._nearest - NEARER:
            self._nearest = min(self._nearest, approach.distance)
            self._nearer_at = self._now
        if timeout is not None and approach.elapsed >= timeout - EPSILON:
            reason = f"not there within {timeout:g} s"
        elif self._now - self._nearer_at >= PATIENCE - EPSILON:
            reason = f"came no nearer for {PATIENCE:g} s"
        else:
            return None
        return Outcome("blocked", {"reason": reason, "distance": approach.distance})

    def progress(self) -> dict[str, Any]:
        """The progress to resume from, as JSON; times as durations, since the clock goes on."""
        now, inside = self._now, self.inside_since
        return {
            "here": list(self.here),
            "elapsed": now - self.started,
            "target": list(self.target),
            "inside": None if inside is None else now - inside,
            "nearest": None if self._nearest == inf else self._nearest,
            "no_nearer": now - self._nearer_at,
        }

    def resume(self, progress: Mapping[str, Any]) -> None:
        """Go on from the progress of another watch."""
        now, inside, nearest = self._now, progress["inside"], progress["nearest"]
        self.started = now - progress["elapsed"]
        self.target = Point(*progress["target"])
        self.inside_since = None if inside is None else now - inside
        self._nearest = inf if nearest is None else nearest
        self._nearer_at = now - progress["no_nearer"]
