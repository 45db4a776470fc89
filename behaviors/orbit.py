"""orbit: fly round a point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.arrival import Blocked
from behaviors.behavior import Behavior
from behaviors.curves import circle, onto_circle
from behaviors.flight import Flight
from behaviors.guidance import stopping_place
from behaviors.pace import Agility, paced
from behaviors.params import BehaviorParams, Face, Heading, live, param, value
from behaviors.path import Path, joined
from behaviors.path_flight import PathFlight, planned_along
from behaviors.path_follower import PathFollower
from behaviors.plan import Legs, PlanStart
from fsm.host import Outcome
from vencejo.geometry import Point


@dataclass(frozen=True, slots=True)
class Orbited:
    """How far round it is."""

    turns: float = 0.0
    """Turns flown; 0 until it is on the circle."""
    progress: float = value("%")
    """Share of the whole way."""


@dataclass(frozen=True, slots=True)
class Turn:
    """A turn that is over."""

    turn: int
    """Its number, from 1."""


class Orbit(Behavior):
    """Fly round a point on a circle, the nose towards the point unless ``heading`` says otherwise.

    It comes onto the circle along it: from outside on a tangent, from inside on a spiral. With
    ``climb`` it gains height in each turn (negative: it loses some). It comes to rest at the end.
    Ends in ``blocked`` when it comes no further for 15 s.
    """

    name = "orbit"

    class Params(BehaviorParams):
        around: Point = param(help="the point in the middle")
        radius: float = param(5.0, unit="m", min=0.5, max=1000.0, help="of the circle")
        height: float | None = param(None, unit="m", help="above home; without it, the present one")
        turns: float = param(1.0, min=0.01, max=1000, help="how many times round")
        climb: float = param(0.0, unit="m", help="height gained in each turn")
        clockwise: bool = param(False, help="seen from above")
        speed: float = param(2.0, unit="m/s", min=0.05, max=20.0, help="along the circle")
        heading: Heading | None = live(None, help="without it, towards the point")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None, "blocked": Blocked}
    events: ClassVar[Mapping[str, type | None]] = {"orbit.turn": Turn}
    publishes = Orbited
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        path, _ = _course(params, start.position)
        asked = [params.speed] * (len(path.ways) - 1)
        return planned_along(path, paced(path, asked, Agility.of(start.limits)))

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, progress = self.params, progress or {}
        begin = progress.get("begin") or stopping_place(flight.observation)
        self.begin = Point(*begin)
        self.agility = Agility.at_start(flight.limits, progress.get("agility"))
        path, self.entry = _course(params, self.begin)
        pace = paced(path, [params.speed] * (len(path.ways) - 1), self.agility)
        self.way = PathFlight(flight, PathFollower(path, pace), params.speed, progress.get("way"))
        self.turns = progress.get("turns", 0)

    def step(self, flight: Flight) -> Outcome | str | None:
        params, way = self.params, self.way
        heading = Face(params.around) if params.heading is None else params.heading
        outcome = way.step(flight, heading)
        follower = way.follower
        length = follower.path.length
        flown = params.turns * max(0.0, follower.way - self.entry) / (length - self.entry)
        flight.publish(Orbited(flown, follower.way / length))
        while self.turns < int(params.turns if way.ended else flown):
            self.turns += 1
            flight.raise_event("orbit.turn", Turn(self.turns))
        return outcome

    def progress(self) -> dict[str, Any]:
        return {
            "begin": list(self.begin),
            "agility": self.agility.progress(),
            "way": self.way.progress(),
            "turns": self.turns,
        }


def _course(params: Any, begin: Point) -> tuple[Path, float]:
    """The whole path from a place, and the way of it until it is on the circle."""
    turn = -1.0 if params.clockwise else 1.0
    height = begin.z if params.height is None else params.height
    centre = params.around._replace(z=height)
    entry, meets = onto_circle(begin, centre, params.radius, turn)
    turns = circle(centre, params.radius, meets, turn * params.turns, params.climb)
    return joined(entry, turns), entry.length
