"""sweep: fly over all of an area in lanes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.coverage import Lanes, lanes_over
from behaviors.flight import Flight
from behaviors.lane_flight import LaneFlight, LaneStyle, along_lanes, lane_places
from behaviors.outline import outlines_of
from behaviors.params import Area, Areas, BehaviorParams, Heading, param, value
from behaviors.plan import Legs, PlanStart, leg_to
from behaviors.strips import Footprint
from fsm.host import Outcome
from vencejo.geometry import Point


@dataclass(frozen=True, slots=True)
class Swept:
    """How much of the area it has flown over."""

    lane: int = 0
    """Number of the lane that it flies, or flies to, from 1."""
    lanes: int = 0
    progress: float = value("%")
    """Share of the lanes that are over."""


class Sweep(Behavior):
    """Fly over all of an area in lanes, ``step`` apart or less, without detecting anything.

    Any outline that does not cross itself will do, also one with ``holes`` to leave out; the lanes
    lie in the direction that takes the least time, and stay inside. No place of the area is farther
    from the way than half a step, across the lanes and along them. Ends in ``failed`` when it has
    come no nearer to its next place for 15 s. Entered again by way of a history state, it goes on
    with the lane on which it was.
    """

    name = "sweep"

    class Params(BehaviorParams):
        area: Area = param(help="the corners of the area")
        step: float = param(2.0, unit="m", min=0.1, help="between lanes, at most")
        height: float | None = param(None, unit="m", help="above home; without it, as it begins")
        holes: Areas = param([], help="areas inside that are left out")
        axis: float | None = param(
            None, unit="rad", help="direction of the lanes; without it, the fastest"
        )
        speed: float = param(2.0, unit="m/s", min=0.05, max=20.0, help="along the lanes")
        heading: Heading | None = param(
            None, help="an angle, keep, travel or {face: point}; without it, along the lanes"
        )
        tolerance: float = param(0.5, unit="m", min=0.02, help="at the ends of lanes")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None}
    publishes = Swept
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        lanes = _lanes(params, start.position)
        height = start.position.z if params.height is None else params.height
        heading = _heading(params, lanes, start.yaw)
        legs, here = [], start.position
        for _, place in lane_places(lanes, lambda _: height, level=True):
            legs.append(leg_to(start, here, place, params.speed, heading))
            here = place
        return legs

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, progress, seen = self.params, progress or {}, flight.observation
        self.begin = Point(*progress.get("begin", seen.position))
        self.yaw: float = progress.get("yaw", seen.yaw)
        self.lanes = _lanes(params, self.begin)
        height = self.begin.z if params.height is None else params.height
        places = lane_places(self.lanes, lambda _: height, level=True)
        style = LaneStyle(params.speed, _heading(params, self.lanes, self.yaw), params.tolerance)
        self.way = LaneFlight(flight, places, style, progress.get("way"))

    def step(self, flight: Flight) -> Outcome | str | None:
        outcome = self.way.step(flight)
        lane, lanes = self.way.lane, len(self.lanes.lanes)
        flight.publish(Swept(lane + 1, lanes, 1.0 if outcome == "done" else lane / lanes))
        return outcome

    def progress(self) -> dict[str, Any]:
        return {"begin": list(self.begin), "yaw": self.yaw, "way": self.way.progress()}


def _lanes(params: Any, begin: Point) -> Lanes:
    corners, holes = outlines_of(params.area, params.holes)
    footprint = Footprint(params.step, params.step / 2)
    return lanes_over(corners, holes, footprint, params.speed, (begin.x, begin.y), params.axis)


def _heading(params: Any, lanes: Lanes, yaw: float) -> Heading:
    heading: Heading | None = params.heading
    return along_lanes(lanes.axis, yaw) if heading is None else heading
