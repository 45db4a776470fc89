"""search_spiral: search around a point, ever farther out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.arrival import Blocked
from behaviors.behavior import Behavior
from behaviors.curves import spiral
from behaviors.flight import Flight
from behaviors.pace import Agility, paced
from behaviors.params import BehaviorParams, Heading, live, param, value
from behaviors.path import Path
from behaviors.path_flight import PathFlight, planned_along
from behaviors.path_follower import PathFollower
from behaviors.plan import Legs, PlanStart, leg_to
from fsm.host import Outcome
from vencejo.geometry import Point, horizontal_distance


@dataclass(frozen=True, slots=True)
class Searched:
    """How far out it is."""

    radius: float = value("m")
    """Distance from the centre."""
    progress: float = value("%")
    """Share of the whole way."""


class SearchSpiral(Behavior):
    """Fly outwards round a point on a spiral, until its radius is reached.

    It detects nothing itself: leave it by the event or the value of a companion that does.

    It flies to the centre first. Ends in ``blocked`` when it comes no further for 15 s. Entered
    again by way of a history state, it goes on where it was.
    """

    name = "search_spiral"

    class Params(BehaviorParams):
        center: Point | None = param(None, help="without it, where it begins")
        radius: float = param(10.0, unit="m", min=0.5, max=1000.0, help="how far out")
        spacing: float = param(2.0, unit="m", min=0.2, max=100.0, help="between two turns")
        axis: float = param(0.0, unit="rad", help="direction in which it leaves the centre")
        clockwise: bool = param(False, help="seen from above")
        speed: float = param(1.5, unit="m/s", min=0.05, max=20.0, help="along the spiral")
        heading: Heading = live("travel", help="an angle, keep, travel or {face: point}")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None, "blocked": Blocked}
    publishes = Searched
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        path = _path(params, start.position)
        pace = paced(path, [params.speed] * (len(path.ways) - 1), Agility.of(start.limits))
        begin = leg_to(start, start.position, path.places[0], params.speed, params.heading)
        return [begin, *planned_along(path, pace)]

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, progress = self.params, progress or {}
        self.begin = Point(*progress.get("begin", flight.observation.position))
        self.agility = Agility.at_start(flight.limits, progress.get("agility"))
        path = _path(params, self.begin)
        pace = paced(path, [params.speed] * (len(path.ways) - 1), self.agility)
        self.way = PathFlight(flight, PathFollower(path, pace), params.speed, progress.get("way"))

    def step(self, flight: Flight) -> Outcome | str | None:
        way = self.way
        outcome = way.step(flight, self.params.heading)
        follower = way.follower
        out = horizontal_distance(follower.place, follower.path.places[0])
        flight.publish(Searched(out, follower.way / follower.path.length))
        return outcome

    def progress(self) -> dict[str, Any]:
        return {
            "begin": list(self.begin),
            "agility": self.agility.progress(),
            "way": self.way.progress(),
        }


def _path(params: Any, here: Point) -> Path:
    centre = here if params.center is None else params.center
    turn = -1.0 if params.clockwise else 1.0
    return spiral(centre, params.radius, params.spacing, params.axis, turn)
