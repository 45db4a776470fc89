"""Flying points in order without stopping at them: lines with arcs at the corners."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from behaviors.arrival import Approach, Arrival, ArrivalWatch
from behaviors.flight import Flight
from behaviors.guidance import MAX_LEAD, NEARBY, Reference, yaw_along, yaw_towards
from behaviors.pace import Agility, paced
from behaviors.params import Heading
from behaviors.path import SAME, Corner, blended, turns_back
from behaviors.path_follower import PathFollower
from fsm.host import Outcome
from hal.vehicle import Observation, Position
from vencejo.geometry import Point, distance

_STILL = 0.1
"""Speed below which the vehicle begins its path at once; from above it brakes first, m/s."""
_STOPPED = 1e-6
_MISSED = MAX_LEAD + 0.4
"""Way beyond a point after which it counts as missed, metres."""
_DEVIATION = 0.5
"""Share of the tolerance by which an arc may pass its point; the rest is for the vehicle."""


@dataclass(frozen=True, slots=True)
class Goal:
    """A point to fly to, with all its settings."""

    place: Point
    """Mission frame, metres."""
    speed: float
    """On the way there, m/s."""
    dwell: float
    """Stay there, seconds."""
    heading: Heading
    turned: bool
    """Whether it is only reached with that heading."""


@dataclass(frozen=True, slots=True)
class Tolerances:
    """What counts as reached (see :class:`behaviors.arrival.Arrival`)."""

    level: float
    vertical: float | None
    yaw: float

    @property
    def deviation(self) -> float:
        """The distance at which an arc may pass a point, metres."""
        return _DEVIATION * min(self.level, self.vertical or inf)


class _Section:
    """The path from a place through some points to one at which it stops."""

    def __init__(
        self, origin: Point, goals: Sequence[Goal], first: int, last: int, terms: _Terms
    ) -> None:
        """It leads from ``origin`` through the points ``first`` to ``last``."""
        self.origin, self.first, self.last = origin, first, last
        through = goals[first : last + 1]
        corners = [Corner(goal.place, terms.deviation) for goal in through]
        path, (_, *self.ways) = blended([Corner(origin, 0.0), *corners])
        asked, number = [], 0
        for end in path.ways[1:]:
            while end > self.ways[number] + SAME and number < len(through) - 1:
                number += 1
            asked.append(through[number].speed)
        self.follower = PathFollower(path, paced(path, asked, terms.agility))

    def has_missed(self, index: int) -> bool:
        """Whether it has gone on too far without a point having been reached."""
        return index < self.last and self.follower.way > self.ways[index - self.first] + _MISSED


@dataclass(frozen=True, slots=True)
class _Terms:
    """What sections depend on beside their points."""

    deviation: float
    agility: Agility


class WaypointFlight:
    """Flies points in order: each period ``step``, then ``arrived`` and ``blocked``."""

    def __init__(
        self,
        flight: Flight,
        goals: Sequence[Goal],
        tolerances: Tolerances,
        index: int = 0,
        progress: Mapping[str, Any] | None = None,
    ) -> None:
        """It begins with the point ``index``, at the place where the vehicle is."""
        seen = flight.observation
        self._goals, self._tolerances, self._index = goals, tolerances, index
        self._start_yaw = self._yaw = seen.yaw
        self._watch = ArrivalWatch(seen, goals[index].place)
        self.approach = Approach()
        """The remaining way to the present point."""
        self._terms = _Terms(tolerances.deviation, Agility.of(flight.limits))
        self._exact = False
        """Whether it stops at the present point, since it missed that before."""
        self._braking: Reference | None = None
        """The stop of a vehicle that moves; the path begins where that ends."""
        self._section: _Section | None = None
        self.went_on = False
        """Whether it goes on from its progress; from farther away it begins anew."""
        if progress:
            self._start_yaw = progress["start_yaw"]
            # From farther away the way to the point begins anew, as do timeout and patience.
            if distance(progress["watch"]["here"], seen.position) <= NEARBY:
                self._resume(progress)
                self.went_on = True
                return
        if seen.velocity.norm() < _STILL:
            self._begin_section(seen.position)
        else:
            self._braking = Reference(seen.position, seen.velocity)

    def _begin_section(self, origin: Point) -> None:
        last = self._index if self._exact else self._next_stop(origin)
        self._section = _Section(origin, self._goals, self._index, last, self._terms)

    def _next_stop(self, origin: Point) -> int:
        """The first point to stop at: for a dwell, to turn back, or at the end."""
        goals, before = self._goals, origin
        for k in range(self._index, len(goals) - 1):
            here, after = goals[k].place, goals[k + 1].place
            if goals[k].dwell or turns_back(before, here, after):
                return k
            if distance(before, here) > SAME and distance(here, after) > SAME:
                before = here
        return len(goals) - 1

    def step(self, flight: Flight) -> None:
        """Command this period's set-point."""
        seen = flight.observation
        setpoint = self._brake(flight) or self._follow(flight)
        flight.command(setpoint)
        self.approach = self._watch.look(seen, self._yaw)

    def _brake(self, flight: Flight) -> Position | None:
        """The set-point of a stop; None when it is over, or there is none."""
        braking, seen = self._braking, flight.observation
        if braking is None:
            return None
        braking.stop(seen, flight.dt)
        if braking.velocity.norm() < _STOPPED:
            self._braking = None
            self._begin_section(braking.position)
            return None
        goal = self._goals[self._index]
        self._yaw = yaw_towards(goal.heading, seen.position, goal.place, self._start_yaw, self._yaw)
        return braking.setpoint(self._yaw)

    def _follow(self, flight: Flight) -> Position:
        section = self._section
        assert section is not None
        follower = section.follower
        if follower.ended and self._index > section.last:
            self._exact = False
            self._begin_section(follower.place)
            return self._follow(flight)
        follower.step(flight.observation, flight.dt)
        if section.has_missed(self._index):
            self._exact, self._section = True, None
            self._braking = Reference(follower.place, follower.velocity)
            return follower.setpoint(self._yaw)
        self._yaw = self._heading(follower, flight.observation)
        return follower.setpoint(self._yaw)

    def _heading(self, follower: PathFollower, seen: Observation) -> float:
        """The yaw asked for on the path, radians."""
        goal = self._goals[self._index]
        if goal.heading == "travel":
            return yaw_along(follower.path.direction(follower.way), self._yaw)
        return yaw_towards(goal.heading, seen.position, goal.place, self._start_yaw, self._yaw)

    def arrived(self) -> bool:
        """Whether the present point has been reached."""
        goal, tolerances = self._goals[self._index], self._tolerances
        yaw = tolerances.yaw if goal.dwell or goal.turned else inf
        arrival = Arrival(tolerances.level, yaw, goal.dwell, tolerances.vertical)
        return self._watch.arrived(self.approach, arrival)

    def head_for(self, index: int, flight: Flight) -> None:
        """Go on to the next point."""
        seen = flight.observation
        self._index = index
        self._watch.begin(self._goals[index].place, seen.time)
        self.approach = self._watch.look(seen, self._yaw)

    def rest(self, flight: Flight) -> None:
        """Command the present point itself, to be held."""
        flight.command(Position(self._goals[self._index].place, yaw=self._yaw))

    def blocked(self, timeout: float | None) -> Outcome | None:
        """The outcome ``blocked`` when it is not getting there; None while it is."""
        return self._watch.blocked(self.approach, timeout)

    def progress(self) -> dict[str, Any]:
        """The progress to resume from, as JSON."""
        section, braking = self._section, self._braking
        return {
            "start_yaw": self._start_yaw,
            "yaw": self._yaw,
            "exact": self._exact,
            "watch": self._watch.progress(),
            "agility": self._terms.agility.progress(),
            "braking": braking.progress() if braking else None,
            "section": section
            and {
                "origin": list(section.origin),
                "points": [section.first, section.last],
                "follower": section.follower.progress(),
            },
        }

    def _resume(self, progress: Mapping[str, Any]) -> None:
        self._yaw, self._exact = progress["yaw"], progress["exact"]
        self._watch.resume(progress["watch"])
        self._terms = _Terms(self._terms.deviation, Agility.resumed(progress["agility"]))
        braking, section = progress["braking"], progress["section"]
        self._braking = Reference.resumed(braking) if braking else None
        if section:
            origin, (first, last) = Point(*section["origin"]), section["points"]
            self._section = _Section(origin, self._goals, first, last, self._terms)
            self._section.follower.resume(section["follower"])
