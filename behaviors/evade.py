"""evade: fly from beacon to beacon in a loop, faster from level to level."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate
from math import copysign, cos, pi, sin, sqrt, tan
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.guidance import BRAKING, STILL
from behaviors.manoeuvre import EPSILON
from behaviors.params import BehaviorParams, Route, param, value
from behaviors.plan import Legs, PlannedLeg, PlanStart, Unflyable, is_known
from behaviors.tracking_reference import Aim, TrackingReference
from fsm.host import Outcome
from vencejo.geometry import Point, bearing, distance, horizontal_distance, wrap

_SPEED_CHANGE = 1.5
"""Acceleration from one level's speed to the next, m/s²."""
_TURN_CHANGE = 6.0
"""Largest change of the rate at which it turns, rad/s²."""
_REACHED = 0.5
"""Distance over the ground at which a beacon counts as reached at least, metres."""
_SHARP = 2.5
"""A turn by more than this angle begins as one by this, radians."""
_SLOW = 0.02
"""Speed below which it hovers, m/s."""
_SOON = 0.7
"""Least time in which it comes to the height of a beacon, seconds."""
_MOST_LEGS = 500
"""Of a plan."""


@dataclass(frozen=True, slots=True)
class Evading:
    """How fast it is at, and where to."""

    level: int = 1
    """From 1."""
    speed: float = value("m/s")
    """Of the level."""
    beacon: int = 0
    """Number of the one that it flies to, from 0."""


@dataclass(frozen=True, slots=True)
class Level:
    """A level that begins."""

    level: int
    """From 1."""


class Evade(Behavior):
    """Fly from beacon to beacon in a loop, each level at a speed and for a time of its own.

    Where a level's speed is 0 it hovers. Past each beacon it turns to the next one in a curve, at
    ``turn_rate`` at most, without slowing down. Ends in ``done`` after the last level.
    """

    name = "evade"

    class Params(BehaviorParams):
        beacons: Route = param(help="the points of the loop")
        durations: list[float] = param(help="of each level, seconds")
        speeds: list[float] = param(help="of each level, m/s; 0 hovers")
        turn_rate: float = param(90.0, unit="deg/s", min=5.0, max=180.0, help="at most")
        heading: str = param("travel", choices=("travel", "keep"), help="of the nose")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None}
    events: ClassVar[Mapping[str, type | None]] = {"evade.level": Level}
    publishes = Evading
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if not (is_known(params.durations) and is_known(params.speeds)):
            return None
        _check(params)
        left = sum(
            time * speed for time, speed in zip(params.durations, params.speeds, strict=True)
        )
        legs: list[PlannedLeg] = []
        here = start.position
        while left > 0 and len(legs) < _MOST_LEGS:
            to = params.beacons[len(legs) % len(params.beacons)].at
            legs.append(PlannedLeg(to, max(params.speeds)))
            left -= max(_REACHED, distance(here, to))
            here = to
        return legs

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, progress = self.params, progress or {}
        _check(params)
        fastest = max(params.speeds, default=0.0)
        self.reference = TrackingReference(flight.observation, flight.limits, max(0.1, fastest))
        self.begin = flight.now - progress.get("elapsed", 0.0)
        self.elapsed = progress.get("elapsed", 0.0)
        self.level = progress.get("level", 0)
        self.beacon = progress.get("beacon", 0) % len(params.beacons)
        self.yaw = flight.observation.yaw
        self.course = self.yaw
        self.turning = 0.0
        self.speed = 0.0

    def step(self, flight: Flight) -> Outcome | str | None:
        params = self.params
        self.elapsed = flight.now - self.begin
        ends = list(accumulate(params.durations))
        level = bisect_right(ends, self.elapsed + EPSILON)
        if level >= len(ends):
            return "done"
        if level + 1 > self.level:
            self.level = level + 1
            flight.raise_event("evade.level", Level(self.level))
        self.reference.step(
            self._aim(params.speeds[level], flight.dt), flight.observation, flight.dt
        )
        flight.command(self.reference.setpoint())
        flight.publish(Evading(self.level, params.speeds[level], self.beacon))
        return None

    def _aim(self, speed: float, dt: float) -> Aim:
        """Along a curve towards the beacon, at the speed of the level; where that is 0, here."""
        here = self.reference.place
        change = _SPEED_CHANGE * dt
        self.speed += max(-change, min(change, speed - self.speed))
        if self.speed < _SLOW:
            self.course, self.turning = bearing(here, self._beacon), 0.0
            return Aim(here, STILL, STILL, self.yaw, 0.0)
        self._pass_beacons(here)
        self._turn(here, dt)
        east, north = cos(self.course), sin(self.course)
        to = self._beacon
        time = max(_SOON, horizontal_distance(here, to) / self.speed)
        if self.params.heading == "travel":
            self.yaw = self.course
        push = self.speed * self.turning
        return Aim(
            here,
            Point(self.speed * east, self.speed * north, (to.z - here.z) / time),
            Point(-push * north, push * east, 0.0),
            self.yaw,
            self.turning if self.params.heading == "travel" else 0.0,
        )

    def _turn(self, here: Point, dt: float) -> None:
        most: float = self.params.turn_rate
        error = wrap(bearing(here, self._beacon) - self.course)
        # The rate from which it stops turning in time (v² = 2·b·s, for angles).
        wanted = copysign(min(most, sqrt(2 * _TURN_CHANGE * BRAKING * abs(error))), error)
        change = _TURN_CHANGE * dt
        self.turning += max(-change, min(change, wanted - self.turning))
        self.course = wrap(self.course + self.turning * dt)

    def _pass_beacons(self, here: Point) -> None:
        """Turn to the next beacon when the present one is reached, or the curve begins."""
        points = self.params.beacons
        radius = self.speed / self.params.turn_rate
        for _ in points:
            to, following = self._beacon, points[(self.beacon + 1) % len(points)].at
            far = horizontal_distance(here, to)
            corner = abs(wrap(bearing(to, following) - self.course))
            begins = min(2 * radius, radius * tan(min(corner, _SHARP) / 2))
            behind = abs(wrap(bearing(here, to) - self.course)) > pi / 2 and far < 2 * radius
            if far > max(_REACHED, begins) and not behind:
                return
            self.beacon = (self.beacon + 1) % len(points)

    @property
    def _beacon(self) -> Point:
        at: Point = self.params.beacons[self.beacon].at
        return at

    def progress(self) -> dict[str, Any]:
        return {"elapsed": self.elapsed, "level": self.level, "beacon": self.beacon}


def _check(params: Any) -> None:
    """Raises Unflyable for levels that are none, and a loop without a beacon."""
    if not params.beacons:
        raise Unflyable("there is no beacon to fly to", "beacons", "beacons: [[8, 0, 2], …]")
    times, speeds = params.durations, params.speeds
    if len(times) != len(speeds) or not times:
        message = f"there are {len(times)} durations and {len(speeds)} speeds"
        raise Unflyable(message, "durations", "each level has one of both")
    for name, values in (("durations", times), ("speeds", speeds)):
        for each in values:
            if isinstance(each, bool) or not isinstance(each, (int, float)) or not each >= 0:
                raise Unflyable(f"{each!r:.40} is no number of 0 or more", name)
