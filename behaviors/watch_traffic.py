"""watch_traffic: tell what drives below, and how fast."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import atan2, hypot
from typing import Any, ClassVar

import cv2
import numpy as np

from behaviors.behavior import Behavior
from behaviors.find_color import color_of
from behaviors.flight import Flight
from behaviors.guidance import STILL
from behaviors.new_frames import NewFrames
from behaviors.params import BehaviorParams, param, value
from behaviors.perception.annotations import blob as drawn_blob
from behaviors.perception.blobs import Blob, blobs, touches_edge
from behaviors.perception.color import ColorRange, mask
from behaviors.perception.projection import ground_points
from behaviors.plan import Legs, PlanStart, Unflyable, is_known, require_order
from fsm.host import Outcome
from hal.scene.arrays import Pixels
from hal.vehicle import Frame
from vencejo.geometry import Point

MEASURED = 0.5
"""Seconds for which a car is watched before its speed is told."""
FASTEST = 40.0
"""Speed above which two sights are not of one car, m/s."""
APART = 1.5
"""Metres by which a car may be from where it was expected."""
GONE = 1.0
"""Seconds after which a car that is seen no more is another one."""
_CLOSING = np.ones((7, 7), np.uint8)
"""What joins the parts of a car, pixels."""
_MEMORY = 60
"""Sights of a car that its speed is measured by, at most."""


@dataclass(frozen=True, slots=True)
class Traffic:
    """What is below now."""

    cars: int = 0
    """In the picture, and measured."""
    seen: int = 0
    """All so far."""
    speed: float = value("m/s")
    """Of the fastest one in the picture, over the ground."""


@dataclass(frozen=True, slots=True)
class Car:
    """A car whose speed is known."""

    id: int = 0
    """A number of its own, from 1."""
    color: str = ""
    position: Point = STILL
    """Mission frame."""
    speed: float = value("m/s")
    """Over the ground."""
    heading: float = value("rad")
    """The direction in which it drives."""


@dataclass
class _Track:
    """The sights of one car."""

    color: str
    sights: list[tuple[float, float, float]] = field(default_factory=list)
    """Time and place."""
    id: int = 0
    """0 until it was told."""

    @property
    def last(self) -> float:
        return self.sights[-1][0]

    @property
    def duration(self) -> float:
        return self.last - self.sights[0][0]

    def motion(self) -> tuple[float, float, float, float]:
        """Place at the last sight, and velocity: the straight line through all sights."""
        times, xs, ys = np.array(self.sights).T
        since = times - times[-1]
        if len(since) < 3 or self.duration <= 0:
            return float(xs[-1]), float(ys[-1]), 0.0, 0.0
        (u, x), (v, y) = np.polyfit(since, xs, 1), np.polyfit(since, ys, 1)
        return float(x), float(y), float(u), float(v)

    def misses(self, time: float, x: float, y: float) -> float:
        """How far a place is from where the car is expected, metres."""
        u, v, vx, vy = self.motion()
        since = time - self.last
        far = hypot(x - u - vx * since, y - v - vy * since)
        return far if len(self.sights) >= 3 else max(0.0, far - FASTEST * since)


class WatchTraffic(Behavior):
    """Watch for cars with a camera that looks down, and measure their speed. Never ends by itself.

    A car is a thing of one of the colours and of the size of a car. ``car.seen`` is raised once for
    each, when it has been watched for half a second. It commands nothing: put it on a state with
    states.
    """

    name = "watch_traffic"

    class Params(BehaviorParams):
        camera: str = param("ventral", help="that looks down", names="camera")
        colors: list[Any] = param(("red", "blue", "yellow"), help="of the cars: names or ranges")
        height: float = param(0.75, unit="m", min=0.0, max=10.0, help="of their sides, on average")
        ground: float = param(0.0, unit="m", help="height of the road above home")
        min_size: float = param(3.0, min=0.01, help="square metres seen from above, at least")
        max_size: float = param(15.0, min=0.01, help="square metres, at most")

    outcomes: ClassVar[Mapping[str, type | None]] = {}
    events: ClassVar[Mapping[str, type | None]] = {"car.seen": Car}
    publishes = Traffic
    controls = ()

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if is_known(params.colors):
            _colors(params.colors)
        require_order(params, "min_size", "max_size")
        return []

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        self.frames = NewFrames(flight.camera(self.params.camera))
        self.colors = _colors(self.params.colors)
        require_order(self.params, "min_size", "max_size")
        self.tracks: list[_Track] = []
        self.seen: int = (progress or {}).get("seen", 0)

    def step(self, flight: Flight) -> Outcome | str | None:
        frame = self.frames.next(flight.observation)
        if frame is None:
            return None
        now: list[tuple[Blob, _Track]] = []
        for name, wanted in self.colors.items():
            for found, place in self._cars(frame, wanted):
                now.append((found, self._track(name, frame.time, place)))
        self.tracks = [track for track in self.tracks if frame.time - track.last <= GONE]
        self._tell(flight, [track for _, track in now])
        flight.picture("traffic", lambda: _drawn(frame, now))
        return None

    def _cars(self, frame: Frame, wanted: ColorRange) -> list[tuple[Blob, Point]]:
        """The cars of a colour that are wholly in a picture, and where they are."""
        params = self.params
        level = params.ground + params.height
        focal = frame.intrinsics.fx * frame.intrinsics.fy
        scale = max(0.1, frame.position.z - level) ** 2 / focal
        # A car's windows are of another colour: only its outline is to be whole.
        body = cv2.morphologyEx(mask(frame.image, wanted), cv2.MORPH_CLOSE, _CLOSING)
        found = blobs(np.asarray(body, np.uint8), params.min_size / scale, params.max_size / scale)
        whole = [each for each in found if not touches_edge(each, frame.image)]
        places = ground_points(frame, [_middle(each) for each in whole], level)
        return [
            (each, Point(*map(float, place)))
            for each, place in zip(whole, places, strict=True)
            if not np.isnan(place).any()
        ]

    def _track(self, color: str, time: float, place: Point) -> _Track:
        """The car that is seen at a place, with that sight."""
        mine = [track for track in self.tracks if track.color == color and track.last < time]
        nearest = min(mine, key=lambda track: track.misses(time, place.x, place.y), default=None)
        if nearest is None or nearest.misses(time, place.x, place.y) > APART:
            nearest = _Track(color)
            self.tracks.append(nearest)
        nearest.sights.append((time, place.x, place.y))
        del nearest.sights[:-_MEMORY]
        return nearest

    def _tell(self, flight: Flight, now: list[_Track]) -> None:
        """Raise the event of each car that has become known, and publish what is below."""
        measured = [track for track in now if track.duration >= MEASURED]
        fastest = 0.0
        for track in measured:
            x, y, u, v = track.motion()
            fastest = max(fastest, hypot(u, v))
            if not track.id:
                self.seen += 1
                track.id = self.seen
                place = Point(x, y, self.params.ground)
                car = Car(track.id, track.color, place, hypot(u, v), atan2(v, u))
                flight.raise_event("car.seen", car)
        flight.publish(Traffic(len(measured), self.seen, fastest))

    def progress(self) -> dict[str, Any]:
        return {"seen": self.seen}


def _middle(found: Blob) -> tuple[float, float]:
    """The centroid of a blob's convex hull, pixels."""
    moments = cv2.moments(cv2.convexHull(found.contour))
    if moments["m00"] <= 0:
        return found.x, found.y
    return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]


def _colors(given: Any) -> dict[str, ColorRange]:
    """The colours of a list, by name. Raises Unflyable."""
    names = given if isinstance(given, (list, tuple)) else [given]
    if not names:
        raise Unflyable("no car has no colour: name one or more", "colors", "colors: [red, blue]")
    return {str(each): color_of(each, "colors") for each in names}


def _drawn(frame: Frame, now: list[tuple[Blob, _Track]]) -> Pixels:
    """The picture with the cars and their speeds."""
    image = frame.image
    for found, track in now:
        *_, u, v = track.motion()
        label = f"{hypot(u, v):.1f} m/s" if track.duration >= MEASURED else track.color
        image = drawn_blob(image, found, label)
    return image
