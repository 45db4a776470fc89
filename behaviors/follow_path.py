"""follow_path: fly a smooth path."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.arrival import Blocked
from behaviors.behavior import Behavior
from behaviors.curves import circle, lemniscate
from behaviors.flight import Flight
from behaviors.guidance import ACCELERATION, RAMP
from behaviors.pace import Agility, Pace, bend_speed, even, paced, slowed, timed
from behaviors.params import BehaviorParams, Heading, Route, live, param, value
from behaviors.path import SAME, Path, repeated, spline, turns_back
from behaviors.path_file import PathFile
from behaviors.path_flight import PathFlight, planned_along
from behaviors.path_follower import PathFollower
from behaviors.plan import Legs, PlanStart, Slower, Unflyable, leg_to
from fsm.host import Outcome
from vencejo.geometry import Point, distance, wrap

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
class _Yaws:
    """Headings along a path, radians, between which it turns the shorter way."""

    ways: Sequence[float]
    """Where each is reached, metres."""
    yaws: Sequence[float]

    def at(self, way: float) -> float:
        """The heading at a way, kept between begin and end."""
        k = max(0, min(bisect_right(self.ways, way), len(self.ways) - 1) - 1)
        share = (way - self.ways[k]) / (self.ways[k + 1] - self.ways[k])
        begin, end = self.yaws[k], self.yaws[k + 1]
        return wrap(begin + max(0.0, min(1.0, share)) * wrap(end - begin))


@dataclass(frozen=True)
class _Course:
    """A path with its pace, as the vehicle can fly it."""

    path: Path
    pace: Pace
    ramp: float
    """See PathFollower."""
    asked: float
    speed: float
    """See Slower."""
    yaws: _Yaws | None = None
    """The headings that its file has."""

    @property
    def slower(self) -> Slower | None:
        """What is told if it is slower than asked for; else None."""
        return Slower(self.asked, self.speed) if self.speed < _ALIKE * self.asked else None

    def heading(self, asked: Heading, way: float) -> Heading:
        """The heading at a way: that of its file, unless another than travel is asked for."""
        return self.yaws.at(way) if self.yaws and asked == "travel" else asked


class FollowPath(Behavior):
    """Fly a smooth path, each place at its time: a curve, a circle, a figure eight or a CSV file's.

    It flies to the begin of the path first, and comes to rest at its end. ``speed`` is the highest
    one on the path; a file with times is flown at these, and ``speed`` is that to its begin. Where
    the path needs more than the vehicle can do, it is flown more slowly, and ``path.slower`` is
    raised: a circle, a figure eight or a file with times as a whole, other curves in their bends.
    Ends in ``blocked`` when it comes no further for 15 s.
    """

    name = "follow_path"

    class Params(BehaviorParams):
        shape: str = param(
            "points", choices=("points", "circle", "figure_eight", "file"), help="what it flies"
        )
        points: Route | None = param(None, help="of shape points: what the curve passes through")
        file: PathFile | None = param(None, help="of shape file: CSV, x,y,z or t,x,y,z, and yaw")
        closed: bool = param(False, help="of shape points: it comes back to its first point")
        center: Point | None = param(None, help="of circle and eight: without it, where it begins")
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
        return [*legs, *planned_along(path, course.pace, laps, course.slower)]

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, progress = self.params, progress or {}
        self.origin = Point(*progress.get("origin", flight.observation.position))
        self.agility = Agility.at_start(flight.limits, progress.get("agility"))
        self.laps = params.laps if _is_closed(params) else 1
        self.lap = progress.get("lap", 0)
        course = self.course = _course(params, self.origin, self.agility)
        follower = PathFollower(course.path, course.pace, course.ramp)
        self.way = PathFlight(flight, follower, params.speed, progress.get("way"))
        if course.slower is not None and not progress:
            flight.raise_event("path.slower", course.slower)

    def step(self, flight: Flight) -> Outcome | str | None:
        way = self.way
        follower = way.follower
        outcome = way.step(flight, self.course.heading(self.params.heading, follower.way))
        share = follower.way / follower.path.length
        lap = min(self.laps, int(share * self.laps) + 1) if way.on_path else 0
        for over in range(max(1, self.lap), self.laps + 1 if way.ended else lap):
            flight.raise_event("path.lap", Lap(over))
        self.lap = max(self.lap, lap)
        flight.publish(Followed(lap, self.laps, share, way.error))
        return outcome

    def progress(self) -> dict[str, Any]:
        return {
            "origin": list(self.origin),
            "agility": self.agility.progress(),
            "lap": self.lap,
            "way": self.way.progress(),
        }


def _is_closed(params: Any) -> bool:
    return bool(params.shape in ("circle", "figure_eight") or params.closed)


def _course(params: Any, here: Point, agility: Agility) -> _Course:
    """The path of the parameters. Raises Unflyable where they make none."""
    if params.shape != "points" and params.points is not None:
        message = f"a {params.shape} leads through no `points`"
        raise Unflyable(message, "points", "leave them out, or the shape")
    if params.shape != "file" and params.file is not None:
        raise Unflyable("the `file` is of the shape file", "file", "write shape: file")
    if params.shape == "points":
        return _through_points(params, agility)
    if params.shape == "file":
        return _from_file(params, agility)
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
    return _whole(path, pace, path.directions, agility)


def _whole(
    path: Path,
    pace: Pace,
    directions: Sequence[Point],
    agility: Agility,
    yaws: _Yaws | None = None,
) -> _Course:
    """A path at a pace that is slowed as a whole; ``directions`` are its at the pace's nodes."""
    asked = pace.fastest
    pace = slowed(directions, pace, agility)
    ramp = max(RAMP, pace.speeds[0] / ACCELERATION)
    return _Course(path, pace, ramp, asked, pace.fastest, yaws)


def _from_file(params: Any, agility: Agility) -> _Course:
    """The path of a file: at its times, or at the speed asked for."""
    file: PathFile | None = params.file
    if file is None:
        raise Unflyable("the shape file has no `file`", "shape", "file: path.csv")
    if params.closed:
        raise Unflyable("the path of a file is not closed", "closed", "end it in its first place")
    if params.laps > 1:
        raise Unflyable("the path of a file is flown once", "laps", "come back to the state again")
    path, ways = spline(file.places)
    yaws = _Yaws(ways, file.yaws) if file.yaws else None
    if file.times is None:
        return _at_speed(path, params.speed, agility, yaws)
    pace = timed(path, ways, file.times)
    return _whole(path, pace, [path.direction(way) for way in pace.ways], agility, yaws)


def _at_speed(path: Path, speed: float, agility: Agility, yaws: _Yaws | None = None) -> _Course:
    """A path that is flown at a speed, and more slowly in its bends."""
    pace = paced(path, [speed] * (len(path.ways) - 1), agility)
    slowest = min(bend_speed(bend, agility) for bend in path.bends())
    return _Course(path, pace, 0.0, speed, min(speed, slowest), yaws)


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
    return _at_speed(path, params.speed, agility)


def _shown(place: Point) -> str:
    return f"[{', '.join(f'{v:.4g}' for v in place)}]"


def _apart(places: Sequence[Point]) -> list[Point]:
    """Places without those that are where the one before is."""
    return [p for k, p in enumerate(places) if k == 0 or distance(p, places[k - 1]) > SAME]
