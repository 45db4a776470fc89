"""find_road: tell where the road lies in the picture, by a few of its rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.find_color import color_of
from behaviors.flight import Flight
from behaviors.new_frames import NewFrames
from behaviors.params import BehaviorParams, param, value
from behaviors.perception.annotations import section
from behaviors.perception.color import mask
from behaviors.perception.road_sections import Runs, Sections, road_sections
from behaviors.plan import Legs, PlanStart, is_known
from fsm.host import Outcome
from hal.scene.arrays import Pixels
from hal.vehicle import Frame


@dataclass(frozen=True, slots=True)
class RoadInPicture:
    """Where the road is in the last picture; pixels from its middle."""

    frames: int = 0
    """Pictures looked at."""
    visible: bool = False
    x: float = 0.0
    """Of the reference point, to the right of the middle column."""
    y: float = 0.0
    """Of the reference point, above the middle row."""
    angle: float = value("rad")
    """Of the reference point, from straight ahead, clockwise."""
    upper: int = 0
    """Sections of road on the upper rows."""
    lower: int = 0
    """Sections of road on the lower rows."""
    middle_at_edge: bool = False
    """Whether one on the middle rows reaches the edge of the picture."""


class FindRoad(Behavior):
    """Look for a road on a few rows of each picture of a camera. Never ends by itself.

    It does what the published road follower did. It commands nothing: put it on a state with
    states, which fly by what it publishes.
    """

    name = "find_road"

    class Params(BehaviorParams):
        camera: str = param("ventral", help="that looks down", names="camera")
        color: Any = param("asphalt", help="of the road: a name, {hsv: [low, high]} or {rgb: …}")
        begin: int = param(5, min=1, help="pixels in a row of its colour that begin a section")
        end: int = param(5, min=1, help="pixels in a row of others that end it")
        apart: int = param(10, min=1, help="rows from each main row to the two about it")
        roll_pitch_thr: float | None = param(
            None, unit="rad", min=0.0, help="pictures taken while it is tilted more are ignored"
        )

    outcomes: ClassVar[Mapping[str, type | None]] = {}
    publishes = RoadInPicture
    controls = ()

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if is_known(params.color):
            color_of(params.color)
        return []

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        self.frames = NewFrames(flight.camera(self.params.camera), self.params.roll_pitch_thr)
        self.wanted = color_of(self.params.color)
        self.looks = 0
        self.last_x = 0.0

    def step(self, flight: Flight) -> Outcome | str | None:
        params = self.params
        frame = self.frames.next(flight.observation)
        if frame is None:
            return None
        self.looks += 1
        runs = Runs(params.begin, params.end)
        found = road_sections(mask(frame.image, self.wanted), self.last_x, params.apart, runs)
        if found.section is not None:
            self.last_x = found.x
        flight.publish(
            RoadInPicture(
                self.looks, found.section is not None, found.x, found.y, found.angle,
                found.upper, found.lower, found.middle_at_edge,
            )
        )  # fmt: skip
        flight.picture("road", lambda: _drawn(frame, found))
        return None


def _drawn(frame: Frame, found: Sections) -> Pixels:
    """The picture with the section and the reference point."""
    if found.section is None:
        return frame.image
    row, begin, end = found.section
    height, width = frame.image.shape[:2]
    point = (found.x + (width - 1) / 2, (height - 1) / 2 - found.y)
    return section(frame.image, (begin, row), (end, row), point)
