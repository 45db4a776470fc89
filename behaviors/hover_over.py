"""hover_over: stay above a tag."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.chase import Chase, turned_towards
from behaviors.flight import Flight
from behaviors.guidance import NEARBY, STILL, stopping_place
from behaviors.params import BehaviorParams, live, param, value
from behaviors.perception.tag_tracks import TagTracks, Track
from behaviors.perception.tags import ROUNDEL, TagFinder
from behaviors.plan import Legs, PlanStart, is_known
from behaviors.tag_watch import TagWatch, finder_of
from fsm.host import Outcome
from vencejo.geometry import Point, distance, horizontal_distance, wrap
from worlds.markers import DICTIONARIES

FOLLOWED = 1.0
"""Seconds for which a lost tag is followed by its last velocity; then the place is held."""
TURN_RATE = 1.0
"""Rate at which the vehicle turns to be aligned, rad/s."""
CAMERA = "ventral"


@dataclass(frozen=True, slots=True)
class Over:
    """How well it is above the tag; the last values stay when the tag is lost."""

    visible: bool = False
    id: int | None = None
    """Of the marker; of a roundel, its number."""
    offset: float = value("m")
    """Distance over the ground from the place above the tag."""
    angle: float = value("rad")
    """The turn to the left after which it is aligned."""
    above: bool = False
    """Whether the tag is visible and offset and, if it aligns, angle are within the tolerances."""
    position: Point | None = None
    """Of the tag, mission frame."""
    heading: float | None = value("rad", None)
    """The direction in which the tag points."""


class HoverOver(Behavior):
    """Stay above a tag that lies, still or moving, with the nose where the tag points.

    The tag is a roundel or a marker; the one nearest to the middle of the picture when it is first
    seen. It keeps its height. Until the tag is seen it stops; when it is lost it follows the tag's
    last velocity for a second, and then holds its place until the tag is seen again. Never ends by
    itself.
    """

    name = "hover_over"

    class Params(BehaviorParams):
        target: str = param(ROUNDEL, choices=(ROUNDEL, "marker"), help="the kind of tag")
        id: int | None = param(None, min=0, help="of the marker; without it, any")
        dictionary: str = param(
            "4X4_50", choices=tuple(DICTIONARIES), help="of the marker, by OpenCV's name"
        )
        size: float | None = param(
            None, unit="m", min=0.005, max=20.0, help="side of the marker, diameter of the roundel"
        )
        align: bool = param(True, help="whether the nose is turned to where the tag points")
        height: float | None = live(None, unit="m", help="above home; without it, the present one")
        speed: float = live(1.0, unit="m/s", min=0.05, max=5.0, help="at the most")
        tolerance: float = live(0.1, unit="m", min=0.01, help="offset that is still above")
        yaw_tolerance: float = live(8.0, unit="deg", min=0.5, help="angle that is still aligned")

    outcomes: ClassVar[Mapping[str, type | None]] = {}
    publishes = Over
    requires = ("position", "velocity", f"camera.{CAMERA}")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if all(map(is_known, (params.target, params.id, params.dictionary))):
            _finder(params, None)
        return None  # where the tag is, is known in flight

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, seen = self.params, flight.observation
        finder = _finder(params, params.size)
        tracks = TagTracks()
        tracks.go_on((progress or {}).get("roundels", ()))
        self.watch = TagWatch(flight, self.name, CAMERA, finder, tracks)
        self.chase = Chase(seen)
        self.height, self.yaw = seen.position.z, seen.yaw
        self.here = seen.position
        self.tag: Track | None = None
        self.held = stopping_place(seen)
        """Where it stays while there is no tag to follow; the height is another matter."""
        self.over = Over()
        if progress:
            self.height = progress["height"]
            if distance(progress["here"], seen.position) <= NEARBY:
                self.yaw = progress["yaw"]
                self.chase.go_on(progress["chase"])

    def step(self, flight: Flight) -> Outcome | str | None:
        self.here = flight.observation.position
        self.watch.look(flight, lambda place: self.over.above)
        visible = self.watch.visible(flight.now)
        if visible and self.tag not in visible:
            self.tag = min(visible, key=lambda track: track.place.radius)
        self._follow(flight)
        flight.command(self.chase.setpoint(self.yaw))
        self.over = self._seen(flight, self.tag in visible)
        flight.publish(self.over)
        return None

    def _follow(self, flight: Flight) -> None:
        """Move the reference on, towards the place above the tag."""
        params, seen, dt, tag = self.params, flight.observation, flight.dt, self.tag
        height = self.height if params.height is None else params.height
        followed = tag is not None and flight.now - tag.time <= FOLLOWED
        place = tag.position_at(flight.now) if tag is not None and followed else None
        if tag is None or place is None:
            self.chase.step(self.held._replace(z=height), STILL, params.speed, seen, dt)
            return
        moves = (tag.velocity or STILL)._replace(z=0.0)
        self.chase.step(place._replace(z=height), moves, params.speed, seen, dt)
        self.held = stopping_place(seen)
        if params.align and tag.tag.heading is not None:
            self.yaw = turned_towards(self.yaw, tag.tag.heading, TURN_RATE, dt)

    def _seen(self, flight: Flight, visible: bool) -> Over:
        tag, seen, params = self.tag, flight.observation, self.params
        place = None if tag is None else tag.position_at(flight.now)
        if tag is None or place is None or not visible:
            last = self.over
            return Over(False, last.id, last.offset, last.angle, False, last.position, last.heading)
        offset = horizontal_distance(seen.position, place)
        heading = tag.tag.heading
        angle = wrap(heading - seen.yaw) if params.align and heading is not None else 0.0
        above = offset <= params.tolerance and abs(angle) <= params.yaw_tolerance
        return Over(True, tag.id, offset, angle, above, place, heading)

    def progress(self) -> dict[str, Any]:
        return {
            "height": self.height,
            "yaw": self.yaw,
            "here": list(self.here),
            "chase": self.chase.progress(),
            "roundels": self.watch.progress(),
        }


def _finder(params: Any, size: float | None) -> TagFinder:
    """What finds the tag of the parameters. Raises Unflyable."""
    wants_roundel = params.target == ROUNDEL
    ids = [] if wants_roundel else None if params.id is None else [params.id]
    return finder_of(params.dictionary, ids, size, roundels=wants_roundel, parameter="id")
