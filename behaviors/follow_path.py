"""follow_path: fly a smooth path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.arrival import Blocked
from behaviors.behavior import Behavior
from behaviors.curves import circle, lemniscate
from behaviors.flight import Flight
from behaviors.guidance import ACCELERATION, RAMP
from behaviors.pace import Agility, Pace, bend_speed, even, paced, slowed
from behaviors.params import BehaviorParams, Heading, Route, live, param, value
from behaviors.path import SAME, Path, repeated, spline, turns_back
from behaviors.path_flight import PathFlight, planned_along
from behaviors.path_follower import PathFollower
from behaviors.plan import Legs, PlanStart, Slower, Unflyable, leg_to
from fsm.host import Outcome
from vencejo.geometry import Point, distance

_ALIKE = 0.99
"""A speed that is at least this share of what was asked for is no slower."""


@dataclass(frozen=True, slots=True)
class Followed:
    """Where it is on its path."""

    lap: int = 0
    """Number of the lap, from 1; 0 on the way to the begin."""
    laps: int = 0
    progress: float = value("%")
    """Share of the whole path."""
    error: float = value("m")
    """Distance of the vehicle from where it is to be at this time."""


@dataclass(frozen=True, slots=True)
class Lap:
    """A lap that is over."""

    lap: int
    """Its number, from 1."""


@dataclass(frozen=True)
class _Course:
    """A path with its pace, as the vehicle can fly it."""

    path: Path
    pace: Pace
    ramp: float
    """See PathFollower."""
    speed: float
    """See Slower."""

    def slower_than(self, asked: float) -> Slower | None:
        """What is told if it is slower than asked for, m/s; else None."""
        return Slower(asked, self.speed) if self.speed < _ALIKE * asked else None


class FollowPath(Behavior):
    """Fly a smooth path, each place at its time: a curve, a circle or a figure eight.

    It flies to the begin of the path first, and comes to rest at its end. ``speed`` is the highest
    one on the path. Where the path needs more than the vehicle can do, it is flown more slowly, and
    ``path.slower`` is raised: a circle or figure eight as a whole, a curve through points in its
    bends. Ends in ``blocked`` when it comes no further for 15 s.
    """

    name = "follow_path"

    class Params(BehaviorParams):
        shape: str = param(
            "points", choices=("points", "circle", "figure_eight"), help="what it flies"
        )
        points: Route | None = param(None, help="of shape points: what the curve passes through")
        closed: bool = param(False, help="of shape points: it comes back to its first point")
        center: Point | None = param(None, help="of the others: without it, where it begins")
        length: float = param(4.0, unit="m", min=0.2, max=1000, help="or the circle's diameter")
        width: float = param(2.0, unit="m", min=0.1, max=1000, help="of the figure eight")
        axis: float = param(0.0, unit="rad", help="direction of the length, where it begins")
        clockwise: bool = param(False, help="the circle")
        speed: float = param(2.0, unit="m/s", min=0.05, max=20.0, help="the highest on the path")
        laps: int = param(1, min=1, max=1000, help="of a closed path")
        heading: Heading = live("travel", help="an angle, keep, travel or {face: point}")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None, "blocked": Blocked}
    events: ClassVar[Mapping[str, type | None]] = {"path.lap": Lap, "path.slower": Slower}
    publishes = Followed
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        course = _course(params, start.position, Agility.of(start.limits))
        path, speed = course.path, params.speed
        legs = [leg_to(start, start.position, path.places[0], speed, params.heading)]
        laps = params.laps if _is_closed(params) else 1
        return [*legs, *planned_along(path, course.pace, laps, course.slower_than(speed))]

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, progress = self.params, progress or {}
        self.origin = Point(*progress.get("origin", flight.observation.position))
        self.agility = (
            Agility.resumed(progress["agility"]) if progress else Agility.of(flight.limits)
        )
        self.laps = params.laps if _is_closed(params) else 1
        self.lap = progress.get("lap", 0)
        course = _course(params, self.origin, self.agility)
        follower = PathFollower(course.path, course.pace, course.ramp)
        self.way = PathFlight(flight, follower, params.speed, progress.get("way"))
        slower = course.slower_than(params.speed)
        if slower is not None and not progress:
            flight.raise_event("path.slower", slower)

    def step(self, flight: Flight) -> Outcome | str | None:
        way = self.way
        blocked = way.step(flight, self.params.heading)
        follower = way.follower
        share = follower.way / follower.path.length
        lap = min(self.laps, int(share * self.laps) + 1) if way.on_path else 0
        for over in range(max(1, self.lap), self.laps + 1 if way.ended else lap):
            flight.raise_event("path.lap", Lap(over))
        self.lap = max(self.lap, lap)
        flight.publish(Followed(lap, self.laps, share, way.error))
        if way.ended:
            way.rest(flight)
            return "done"
        return blocked

    def progress(self) -> dict[str, Any]:
        return {
            "origin": list(self.origin),
            "agility": self.agility.progress(),
            "lap": self.lap,
            "way": self.way.progress(),
        }


def _is_closed(params: Any) -> bool:
    return bool(params.shape != "points" or params.closed)


def _course(params: Any, here: Point, agility: Agility) -> _Course:
    """The path of the parameters. Raises Unflyable where they make none."""
    if params.shape == "points":
        return _through_points(params, agility)
    if params.points is not None:
        message = f"a {params.shape} leads through no `points`"
        raise Unflyable(message, "points", "leave them out, or the shape")
    centre = here if params.center is None else params.center
    if params.shape == "circle":
        turns = -params.laps if params.clockwise else params.laps
        path = circle(centre, params.length / 2, params.axis, turns)
        pace = even(path, params.speed)
    else:
        path, pace = lemniscate(centre, params.length, params.width, params.axis, params.laps)
        factor = params.speed / pace.fastest
        speeds = [speed * factor for speed in pace.speeds]
        pace = Pace([time / factor for time in pace.times], pace.ways, speeds)
    pace = slowed(path, pace, agility)
    return _Course(path, pace, max(RAMP, pace.speeds[0] / ACCELERATION), pace.fastest)


def _through_points(params: Any, agility: Agility) -> _Course:
    places = _apart([point.at for point in params.points or ()])
    least = 3 if params.closed else 2
    if params.closed and len(places) > 1 and distance(places[0], places[-1]) <= SAME:
        places = places[:-1]
    if len(places) < least:
        what = "a closed path" if params.closed else "a path"
        message = f"{what} leads through {least} different points or more, not {len(places)}"
        hint = "give `points`, or the `shape` circle or figure_eight"
        raise Unflyable(message, "points", hint)
    if params.laps > 1 and not params.closed:
        message = f"{params.laps} laps of a path that does not come back to its first point"
        raise Unflyable(message, "laps", "closed: true")
    around = [*places, *places[:2]] if params.closed else places
    for a, b, c in zip(around, around[1:], around[2:], strict=False):
        if turns_back(a, b, c):
            raise Unflyable(f"a smooth path cannot turn back at {_shown(b)}", "points", "use route")
    path, _ = spline(places, params.closed)
    if params.closed:
        path = repeated(path, params.laps)
    pace = paced(path, [params.speed] * (len(path.ways) - 1), agility)
    slowest = min(bend_speed(bend, agility) for bend in path.bends())
    return _Course(path, pace, 0.0, min(params.speed, slowest))


def _shown(place: Point) -> str:
    return f"[{', '.join(f'{v:.4g}' for v in place)}]"


def _apart(places: Sequence[Point]) -> list[Point]:
    """Places without those that are where the one before is."""
    return [p for k, p in enumerate(places) if k == 0 or distance(p, places[k - 1]) > SAME]
