"""survey: fly over an area in lines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import Any, ClassVar

from behaviors.arrival import Blocked
from behaviors.behavior import Behavior
from behaviors.flight import Flight
from behaviors.outline import require_simple
from behaviors.params import Area, BehaviorParams, Heading, param, value
from behaviors.plan import Legs, PlanStart, Unflyable, leg_to
from behaviors.waypoint_flight import Goal, Tolerances, WaypointFlight
from fsm.host import Outcome
from vencejo.geometry import Point, bearing, distance, rotate_xy

_YAW_TOLERANCE = 0.3
_MOST_LINES = 10_000


@dataclass(frozen=True, slots=True)
class Surveyed:
    """How much of the area it has flown over."""

    line: int = 0
    """Number of the line that it flies, or flies to, from 1."""
    lines: int = 0
    progress: float = value("%")
    """Share of the lines that are over."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line that is over."""

    line: int
    """Its number, from 1."""


class Survey(Behavior):
    """Fly over an area in parallel lines, to and fro, each ``spacing`` from the next or less.

    Without ``spacing`` it follows from what ``camera`` sees across the lines at ``height`` above
    home, less the ``overlap``. Ends in ``blocked`` like a route. Entered again by way of a history
    state, it goes on with the line on which it was, from its begin.
    """

    name = "survey"

    class Params(BehaviorParams):
        area: Area = param(help="the corners of the area")
        height: float = param(5.0, unit="m", help="above home")
        spacing: float | None = param(None, unit="m", min=0.1, help="between lines, at most")
        camera: str | None = param(
            None, help="without spacing: the camera that must see it all", names="camera"
        )
        overlap: float = param(30.0, unit="%", min=0, max=90, help="of what it sees on two lines")
        axis: float | None = param(
            None, unit="rad", help="direction of the lines; without it, that of the longest side"
        )
        speed: float = param(2.0, unit="m/s", min=0.05, max=20.0, help="along the lines")
        heading: Heading = param("travel", help="an angle, keep, travel or {face: point}")
        tolerance: float = param(0.5, unit="m", min=0.02, help="at the ends of lines")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None, "blocked": Blocked}
    events: ClassVar[Mapping[str, type | None]] = {"survey.line": Line}
    publishes = Surveyed
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        _check(params)
        if params.spacing is None:
            return None  # what the camera sees is known in flight
        legs, here = [], start.position
        for place in survey_lines(params.area, params.height, params.spacing, params.axis):
            legs.append(leg_to(start, here, place, params.speed, params.heading))
            here = place
        return legs

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, progress = self.params, progress or {}
        _check(params)
        self.spacing: float | None = progress.get("spacing", params.spacing)
        self.index: int = progress.get("index", 0)
        self.way: WaypointFlight | None = None
        self.places: list[Point] = []
        self._resumed = progress.get("way")

    def _begin(self, flight: Flight) -> WaypointFlight | None:
        """Plan the lines; None while the camera has given no picture yet."""
        params = self.params
        if self.spacing is None:
            self.spacing = self._spacing_seen(flight)
            if self.spacing is None:
                return None
        self.places = survey_lines(params.area, params.height, self.spacing, params.axis)
        goals = [Goal(p, params.speed, 0.0, params.heading, False) for p in self.places]
        tolerances = Tolerances(params.tolerance, None, _YAW_TOLERANCE)
        way = WaypointFlight(flight, goals, tolerances, self.index, self._resumed)
        if not way.went_on and self.index % 2:
            self.index -= 1
            way = WaypointFlight(flight, goals, tolerances, self.index)
        return way

    def _spacing_seen(self, flight: Flight) -> float | None:
        """The spacing by the camera's picture: its width on the ground, less the overlap."""
        params = self.params
        frame = flight.camera(params.camera).latest()
        if frame is None:
            return None
        seen: float = params.height * frame.intrinsics.width / frame.intrinsics.fx
        shared: float = params.overlap
        return max(0.1, seen * (1 - shared))

    def step(self, flight: Flight) -> Outcome | str | None:
        if self.way is None:
            self.way = self._begin(flight)
        way = self.way
        if way is None:
            return None
        way.step(flight)
        while way.arrived():
            if self.index % 2:
                flight.raise_event("survey.line", Line(self.index // 2 + 1))
            self.index += 1
            if self.index == len(self.places):
                way.rest(flight)
                return "done"
            way.head_for(self.index, flight)
        lines = len(self.places) // 2
        over = self.index // 2
        flight.publish(Surveyed(over + 1, lines, over / lines))
        return way.blocked(None)

    def progress(self) -> dict[str, Any]:
        return {
            "spacing": self.spacing,
            "index": self.index,
            "way": self.way.progress() if self.way else self._resumed,
        }


def _check(params: Any) -> None:
    """Raises Unflyable where nobody can tell which lines they are."""
    if params.spacing is None and params.camera is None:
        hint = "give the `spacing`, or the `camera` that must see it all"
        raise Unflyable("nothing says how far the lines are apart", "", hint)
    require_simple(params.area)


def survey_lines(
    area: list[Point], height: float, spacing: float, axis: float | None
) -> list[Point]:
    """The ends of parallel lines over an area, in the order in which they are flown.

    ``height`` is that of the lines, metres; ``spacing`` the largest distance between two of them;
    ``axis`` their direction, radians, None for that of the longest side. Where the area is concave
    a line has several parts. Raises Unflyable for an area without extent, or too many lines.
    """
    if axis is None:
        a, b = max(zip(area, [*area[1:], area[0]], strict=True), key=lambda side: distance(*side))
        axis = bearing(a, b)
    corners = [rotate_xy(corner.x, corner.y, -axis) for corner in area]
    low, high = (pick(y for _, y in corners) for pick in (min, max))
    count = max(1, ceil((high - low) / spacing - 1e-9))
    if high - low < 1e-3 or count > _MOST_LINES:
        message = f"an area {high - low:.3g} m wide cannot be flown over in {count} lines"
        raise Unflyable(message, "area")
    places = []
    for k in range(count):
        y = low + (k + 0.5) * (high - low) / count
        ends = sorted(_crossings(corners, y), reverse=k % 2 == 1)
        places += [Point(*rotate_xy(x, y, axis), height) for x in ends]
    return places


def _crossings(corners: list[tuple[float, float]], y: float) -> list[float]:
    """Where the sides of a polygon cross a height: an even number of places."""
    found = []
    for (x1, y1), (x2, y2) in zip(corners, [*corners[1:], corners[0]], strict=True):
        if (y1 <= y) != (y2 <= y):
            found.append(x1 + (x2 - x1) * (y - y1) / (y2 - y1))
    return found
