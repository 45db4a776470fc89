"""sweep_detect: fly over all of an area, and find what is in it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import astuple, dataclass
from typing import Any, ClassVar

import shapely

from behaviors.behavior import Behavior
from behaviors.coverage import Lanes, lanes_over
from behaviors.detectors import read_detectors
from behaviors.findings import Findings, News
from behaviors.flight import Flight
from behaviors.lane_flight import LaneFlight, LaneStyle, along_lanes, lane_places
from behaviors.new_frames import NewFrames
from behaviors.outline import outlines_of
from behaviors.params import Area, Areas, BehaviorParams, Heading, param, value
from behaviors.perception.annotations import BLUE, GREEN, WHITE, circle, text_line
from behaviors.perception.projection import direction, pixels_of
from behaviors.plan import Legs, PlanStart, Unflyable, is_known, leg_to
from behaviors.polygons import area_of
from behaviors.strips import Footprint
from fsm.host import Outcome
from hal.scene.arrays import Pixels
from hal.vehicle import Frame, Intrinsics
from vencejo.geometry import Point
from vencejo.polylines import XY

_AHEAD = 0.35
"""Of the spacing, where the camera's picture is not asked for: how far ahead places count as seen.
Half of a picture of 4:3 is 0.375 of its width long."""
_SURE = 0.92
"""Share of what is seen at the edges of a level picture that counts as seen."""
_RADIUS = 0.6
"""Of the spacing: the distance from which things are found, more than half of what is between."""
_MARK = 14.0
"""Radius of the circle drawn round a thing, pixels."""
_DOWN = -0.5
"""The vertical share of the direction of view below which a camera looks down."""
_EDGE = 0.3
"""Things that are less outside the area count as inside, metres."""


@dataclass(frozen=True, slots=True)
class Searched:
    """How much of the area it has searched, and what it has found."""

    count: int = 0
    """Things found."""
    far: int = 0
    """Things seen from afar only, so far."""
    lane: int = 0
    """Number of the lane that it flies, or flies to, from 1."""
    lanes: int = 0
    progress: float = value("%")
    """Share of the lanes that are over."""


@dataclass(frozen=True, slots=True)
class FoundThing:
    """A thing that was seen."""

    id: str
    """Its name: kind and number, ``person_1``; empty for one that is only seen from afar."""
    kind: str
    position: Point
    """On the ground."""
    status: str
    """``new``: found now. ``known``: found before; it is out of sight again, and its position is
    the mean of more views. ``far``: seen, but not from near enough."""
    picture: str
    """Name of the photo; empty for none."""


class SweepDetect(Behavior):
    """Fly over all of an area in lanes, and find, locate and photograph what is in it.

    The lanes are as those of sweep, ``spacing`` apart or, without that, as far as the picture of
    the ``camera`` is wide, less the ``overlap``. Each new picture is given to the detectors. A
    thing is found when the vehicle is within ``radius`` of it over the ground; its place is the
    mean of all views, those from straight above counting most, and things of a kind less than
    ``near`` from each other are one. Raises ``thing.found`` for each. Entered again by way of a
    history state, it goes on where it was, and knows what was found.
    """

    name = "sweep_detect"

    class Params(BehaviorParams):
        area: Area = param(help="the corners of the area")
        detect: list[Any] = param(help="people, {fiducials: …}, {color: …}, or your own")
        holes: Areas = param([], help="areas inside that are left out")
        height: float = param(6.0, unit="m", min=0.5, max=120.0, help="of the flight")
        above: str = param("home", choices=("home", "ground"), help="from where it counts")
        camera: str = param("ventral", help="that looks down", names="camera")
        spacing: float | None = param(None, unit="m", min=0.1, help="between lanes, at most")
        overlap: float = param(
            25.0, unit="%", min=0, max=90, help="without spacing: of what it sees on two lanes"
        )
        axis: float | None = param(
            None, unit="rad", help="direction of the lanes; without it, the fastest"
        )
        speed: float = param(2.0, unit="m/s", min=0.05, max=20.0, help="along the lanes")
        heading: Heading | None = param(
            None, help="an angle, keep, travel or {face: point}; without it, along the lanes"
        )
        near: float = param(1.0, unit="m", min=0.01, help="things nearer to each other are one")
        radius: float | None = param(
            None, unit="m", min=0.1, help="distance to find from; without it, 0.6 of the spacing"
        )
        roll_pitch_thr: float | None = param(
            None, unit="rad", min=0.0, help="pictures taken while tilted more are not looked at"
        )
        tolerance: float = param(0.5, unit="m", min=0.02, help="at the ends of lanes")

    outcomes: ClassVar[Mapping[str, type | None]] = {"done": None}
    events: ClassVar[Mapping[str, type | None]] = {"thing.found": FoundThing}
    publishes = Searched
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if is_known(params.detect):
            read_detectors(params.detect, cls.detectors)
        area_of(*outlines_of(params.area, params.holes))
        if params.spacing is None or params.above == "ground":
            return None  # what the camera sees and the ground are known in flight
        lanes = _lanes(params, _footprint(params.spacing), start.position)
        heading = along_lanes(lanes.axis, start.yaw) if params.heading is None else params.heading
        legs, here = [], start.position
        for _, place in lane_places(lanes, lambda _: params.height, level=True):
            legs.append(leg_to(start, here, place, params.speed, heading))
            here = place
        return legs

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, seen, progress = self.params, flight.observation, progress or {}
        self.found_by = read_detectors(params.detect, self.detectors)
        outlines_of(params.area, params.holes)
        self.camera = flight.camera(params.camera)
        self.frames = NewFrames(self.camera, params.roll_pitch_thr)
        self.begin = Point(*progress.get("begin", seen.position))
        self.yaw: float = progress.get("yaw", seen.yaw)
        given = None if params.spacing is None else _footprint(params.spacing)
        told = progress.get("footprint")
        self.footprint = Footprint(*told) if told else given
        self.resumed = progress
        self.way: LaneFlight | None = None
        self.has_looked = False

    def _set_out(self, flight: Flight, footprint: Footprint) -> LaneFlight:
        """Plan the lanes, and begin with the first one, or where it was."""
        params = self.params
        self.footprint = footprint
        self.lanes = _lanes(params, footprint, self.begin)
        corners, holes = outlines_of(params.area, params.holes)
        area = area_of(corners, holes).buffer(_EDGE)
        shapely.prepare(area)
        radius = params.radius or _RADIUS * footprint.across
        self.findings = Findings(
            params.near, radius, lambda place: bool(shapely.contains_xy(area, place.x, place.y))
        )
        self.findings.resume(self.resumed.get("things", ()))
        heading = params.heading
        if heading is None:
            heading = along_lanes(self.lanes.axis, self.yaw)
        places = lane_places(self.lanes, self._height(flight), params.above == "home")
        style = LaneStyle(params.speed, heading, params.tolerance)
        return LaneFlight(flight, places, style, self.resumed.get("way"))

    def _height(self, flight: Flight) -> Any:
        height: float = self.params.height
        if self.params.above == "home":
            return lambda _: height

        def above(place: XY) -> float:
            return _ground(flight, *place) + height

        return above

    def step(self, flight: Flight) -> Outcome | str | None:
        frame = self.frames.next(flight.observation)
        if not self.has_looked:
            self._require_down()
        if self.way is None:
            footprint = self.footprint or self._footprint_now()
            if footprint is None:
                return None
            self.way = self._set_out(flight, footprint)
        if frame is not None:
            self._look(flight, frame)
        outcome = self.way.step(flight)
        if outcome == "done":
            self._tell(flight, self.findings.finish())
        lane, lanes, found = self.way.lane, len(self.lanes.lanes), len(self.findings.found)
        far = sum(thing.told_far and not thing.is_found for thing in self.findings.things)
        share = 1.0 if outcome == "done" else lane / lanes
        flight.publish(Searched(found, far, lane + 1, lanes, share))
        return outcome

    def _require_down(self) -> None:
        """Raises Unflyable for a camera whose first frame looks elsewhere."""
        frame = self.camera.latest()
        if frame is None:
            return
        if direction(frame, _middle(frame)).z > _DOWN:
            raise Unflyable(f"the camera '{self.params.camera}' does not look down", "camera")
        self.has_looked = True

    def _footprint_now(self) -> Footprint | None:
        """What the camera sees, by its newest frame, at whatever tilt; None before the first."""
        frame = self.camera.latest()
        return None if frame is None else _footprint_seen(self.params, frame.intrinsics)

    def _look(self, flight: Flight, frame: Frame) -> None:
        """Give a frame to the detectors, and tell what they have found."""
        level = _ground(flight, frame.position.x, frame.position.y)
        sightings = [each for detect in self.found_by for each in detect(frame, level)]

        def ground(x: float, y: float) -> float:
            return _ground(flight, x, y)

        self._tell(flight, self.findings.take(frame, sightings, ground))
        flight.picture(self.name, lambda: _drawn(frame, level, self.findings))

    def _tell(self, flight: Flight, news: Iterable[News]) -> None:
        for thing, status in news:
            if status == "new" and thing.frame is not None:
                thing.picture = thing.name
                flight.keep_photo(thing.name, self.params.camera, thing.frame)
                thing.frame = None
            told = FoundThing(thing.name, thing.kind, thing.position, status, thing.picture)
            flight.raise_event("thing.found", told)

    def progress(self) -> dict[str, Any]:
        footprint, way = self.footprint, self.way
        return {
            "begin": list(self.begin),
            "yaw": self.yaw,
            "footprint": footprint and astuple(footprint),
            "way": way.progress() if way else self.resumed.get("way"),
            "things": self.findings.progress() if way else self.resumed.get("things", []),
        }


def _drawn(frame: Frame, ground: float, findings: Findings) -> Pixels:
    """What is in view: green where it is found in this pass, blue where it is far off or known; and
    the circle in which things are found.
    """
    (below,) = pixels_of(frame, [frame.position._replace(z=ground)])
    reach = findings.radius * frame.intrinsics.fx / max(0.1, frame.position.z - ground)
    picture = circle(frame.image, below, reach, WHITE)
    for thing in findings.in_view:
        is_new = thing.is_found and not thing.is_known
        color = GREEN if is_new else BLUE
        picture = circle(picture, thing.pixel, _MARK, color, thing.name or thing.kind)
    return text_line(picture, f"{len(findings.found)} found")


def _middle(frame: Frame) -> tuple[float, float]:
    """The pixel in the middle of a frame."""
    return (frame.intrinsics.width - 1) / 2, (frame.intrinsics.height - 1) / 2


def _ground(flight: Flight, x: float, y: float) -> float:
    """The height of the ground at a place, mission frame, metres: that of home if none is known."""
    if flight.frame.ground_height is None:
        return 0.0
    return flight.frame.point({"x": x, "y": y, "above_ground": 0.0}, flight.observation).z


def _footprint(spacing: float) -> Footprint:
    return Footprint(spacing, _AHEAD * spacing)


def _footprint_seen(params: Any, lens: Intrinsics) -> Footprint:
    """The footprint of a camera's picture from the height of the flight."""
    width, length = params.height * lens.width / lens.fx, params.height * lens.height / lens.fy
    across = max(0.1, width * (1 - params.overlap))
    return Footprint(across, _SURE * length / 2, _SURE * max(0.0, (width - across) / 2))


def _lanes(params: Any, footprint: Footprint, begin: Point) -> Lanes:
    corners, holes = outlines_of(params.area, params.holes)
    return lanes_over(corners, holes, footprint, params.speed, (begin.x, begin.y), params.axis)
