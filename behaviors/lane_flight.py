"""Flying lanes over an area, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, cos, dist, pi
from typing import Any

from behaviors.coverage import Lanes
from behaviors.flight import Flight
from behaviors.params import Heading
from behaviors.waypoint_flight import Goal, Tolerances, WaypointFlight
from fsm.host import Outcome
from vencejo.geometry import Point, wrap
from vencejo.polylines import XY

_YAW_TOLERANCE = 0.3
_GROUND_STEP = 2.0
"""Distance between places of a lane at which a height above ground is asked for, metres."""


@dataclass(frozen=True)
class LaneStyle:
    """How lanes are flown."""

    speed: float
    """m/s."""
    heading: Heading
    tolerance: float
    """Distance from the ends of lanes at which these count as reached, metres."""


def along_lanes(axis: float, yaw: float) -> float:
    """The heading along lanes of a direction that is nearest to a yaw, radians."""
    return wrap(axis if cos(axis - yaw) >= 0 else axis + pi)


def lane_places(
    lanes: Lanes, height: Callable[[XY], float], level: bool
) -> list[tuple[int, Point]]:
    """The places of a flight over lanes with the number of the lane, from 0, that each is part of.

    The way to a lane is part of it. ``height`` is that of the flight at a place, mission frame;
    ``level`` says that it is the same everywhere, otherwise long ways get places between.
    """
    found: list[tuple[int, XY]] = []
    for number, lane in enumerate(lanes.lanes):
        found += [(number, place) for place in (*lane.approach, *lane.line)]
    if not level:
        found = _closer(found)
    return [(number, Point(*place, height(place))) for number, place in found]


def _closer(places: list[tuple[int, XY]]) -> list[tuple[int, XY]]:
    """The places, with more between those that are far apart."""
    found = places[:1]
    for (_, a), (number, b) in pairwise(places):
        parts = max(1, ceil(dist(a, b) / _GROUND_STEP))
        for k in range(1, parts + 1):
            share = k / parts
            found.append((number, (a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share)))
    return found


class LaneFlight:
    """Flies the places of lanes: each period ``step``."""

    def __init__(
        self,
        flight: Flight,
        places: list[tuple[int, Point]],
        style: LaneStyle,
        progress: Mapping[str, Any] | None = None,
    ) -> None:
        """``places`` are those of :func:`lane_places`. With a progress it goes on where that was
        told, or with the begin of that lane if the vehicle has been elsewhere since.
        """
        self._numbers = [number for number, _ in places]
        self._index = progress["index"] if progress else 0
        goals = [Goal(place, style.speed, 0.0, style.heading, False) for _, place in places]
        tolerances = Tolerances(style.tolerance, None, _YAW_TOLERANCE)
        way = progress and progress["way"]
        self._way = WaypointFlight(flight, goals, tolerances, self._index, way)
        if progress and not self._way.went_on:
            self._index = self._numbers.index(self._numbers[self._index])
            self._way = WaypointFlight(flight, goals, tolerances, self._index)

    @property
    def lane(self) -> int:
        """The number of the lane that it flies, or flies to, from 0."""
        return self._numbers[self._index]

    def step(self, flight: Flight) -> Outcome | str | None:
        """Command this period's set-point: ``done`` at the end of the last lane, which is held
        then, and ``failed`` when it does not get on.
        """
        way = self._way
        way.step(flight)
        while way.arrived():
            if self._index == len(self._numbers) - 1:
                way.rest(flight)
                return "done"
            self._index += 1
            way.head_for(self._index, flight)
        blocked = way.blocked(None)
        return blocked and Outcome("failed", {"reason": blocked.fields["reason"]})

    def progress(self) -> dict[str, Any]:
        """The progress to resume from, as JSON."""
        return {"index": self._index, "way": self._way.progress()}
