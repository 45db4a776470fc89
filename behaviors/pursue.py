"""pursue: find a coloured drone, and stay near it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import atan2, hypot, sqrt
from typing import Any, ClassVar

from behaviors.behavior import Behavior
from behaviors.find_color import color_of
from behaviors.flight import Flight
from behaviors.guidance import STILL
from behaviors.new_frames import NewFrames
from behaviors.params import BehaviorParams, live, param, value
from behaviors.perception.annotations import BLUE, GREEN, YELLOW, circle, rejected, text_line
from behaviors.perception.color import ColorRange
from behaviors.perception.projection import pixels_of
from behaviors.plan import Legs, PlanStart, Unflyable, is_known
from behaviors.target_search import SWEEP, TargetSearch, sweep
from behaviors.target_track import TargetTrack
from behaviors.tracking_reference import Aim, TrackingReference
from fsm.host import Outcome
from hal.scene.arrays import Pixels
from hal.vehicle import Frame, Observation
from vencejo.geometry import Point, bearing, distance, wrap

_UNSEEN = 0.5
"""Seconds without a sight of the target after which it is lost."""
_SLOWLY = 0.05
"""Share of the height of the camera that is followed in each frame: tilt moves it up and down."""
_MARGIN = 0.06
"""Seconds of the target's way that it stays farther away: it learns late of a turn, and is nearer
then.
"""
_MARK = 30.0
"""Radius of the circle about the target in pictures for people, pixels."""
_STEEPEST = 0.36
"""Slope at which it looks up or down at the target at most: it stays farther away instead."""
_PREDICTED = 2.0
"""Seconds for which it is followed where it is expected."""


@dataclass(frozen=True, slots=True)
class Pursued:
    """Where the target is, as far as it is known, and how it moves."""

    visible: bool = False
    """Whether it is in the last picture."""
    distance: float = value("m")
    """From the vehicle."""
    bearing: float = value("rad")
    """From the nose, to the left."""
    elevation: float = value("rad")
    """Above the level of the camera."""
    position: Point = STILL
    velocity: Any = field(default_factory=lambda: {"x": 0.0, "y": 0.0, "z": 0.0})
    """m/s, mission frame."""
    losses: int = 0
    """How often it was lost from sight."""


@dataclass(frozen=True, slots=True)
class Found:
    """A target that came into sight."""

    distance: float = value("m")
    after: float = value("s")
    """For how long it was not seen."""


@dataclass(frozen=True, slots=True)
class Lost:
    """A target that went out of sight."""

    position: Point = STILL
    """Where it was seen last; the origin for one that was never seen."""


class Pursue(Behavior):
    """Find a drone of a colour and size, and stay ``distance`` from it, the nose towards it.

    It looks about for it, higher, lower and then farther away; goes where it is expected when it
    is hidden, then looks where it vanished. Backs away from one that comes near. Ends in ``lost``
    after ``patience`` without a sight of it.
    """

    name = "pursue"

    class Params(BehaviorParams):
        target: Any = param(help="{color: red, size: 52 cm}: a name or a range, and its width")
        camera: str = param("front", help="that it looks through", names="camera")
        distance: float = live(3.0, unit="m", min=1.0, max=20.0, help="to stay at")
        nearest: float = param(1.5, unit="m", min=0.5, help="it never comes nearer by itself")
        above: float = live(0.0, unit="m", help="height over the target's")
        dead_distance: float = live(0.03, unit="m", min=0.0, help="error that is left alone")
        dead_height: float = live(0.03, unit="m", min=0.0, help="error that is left alone")
        dead_bearing: float = live(0.02, unit="rad", min=0.0, help="error that is left alone")
        speed: float = param(3.0, unit="m/s", min=0.1, max=20.0, help="at most")
        least_height: float = param(0.8, unit="m", min=0.3, help="above home")
        reach: float = param(6.0, unit="m", min=0.0, help="how far it flies to look for it")
        patience: float = param(30.0, unit="s", min=0.5, help="without a sight of it, then lost")

    outcomes: ClassVar[Mapping[str, type | None]] = {"lost": Lost}
    events: ClassVar[Mapping[str, type | None]] = {"target.found": Found, "target.lost": Lost}
    publishes = Pursued
    requires = ("position", "velocity")
    needs_flight = True

    @classmethod
    def plan(cls, params: Any, start: PlanStart) -> Legs | None:
        if is_known(params.target):
            _target(params)
        return None

    def start(self, flight: Flight, progress: Mapping[str, Any] | None = None) -> None:
        params, seen = self.params, flight.observation
        color, size = _target(params)
        self.track = TargetTrack(color, size)
        self.reference = TrackingReference(seen, flight.limits, params.speed)
        self.search: TargetSearch | None = None
        self.frames = NewFrames(flight.camera(params.camera))
        self.losses = (progress or {}).get("losses", 0)
        self.is_lost = True
        self.unseen_since = seen.time
        self.eye_height = 0.0
        """Of the camera over the vehicle's place, metres."""

    def step(self, flight: Flight) -> Outcome | str | None:
        params, seen = self.params, flight.observation
        frame = self.frames.next(flight.observation)
        if frame is not None:
            self.track.look(frame)
            flight.picture("pursue", lambda: self._drawn(frame))
            self.eye_height += _SLOWLY * (frame.position.z - seen.position.z - self.eye_height)
        self._tell(flight)
        unseen = seen.time - self.unseen_since
        if unseen >= params.patience:
            return Outcome("lost", {"position": self._last_place()})
        self.reference.step(self._aim(unseen, flight), seen, flight.dt)
        flight.command(self.reference.setpoint())
        return None

    def progress(self) -> dict[str, Any]:
        return {"losses": self.losses}

    def _tell(self, flight: Flight) -> None:
        """Raise what has changed, and publish what is known."""
        track, now = self.track, flight.now
        if track.is_known and track.seen_at > self.unseen_since:
            if self.is_lost:
                far = distance(track.position_at(now), flight.observation.position)
                flight.raise_event("target.found", Found(far, track.seen_at - self.unseen_since))
            self.is_lost, self.unseen_since = False, track.seen_at
        elif not self.is_lost and now - self.unseen_since > _UNSEEN:
            self.is_lost = True
            self.losses += 1
            flight.raise_event("target.lost", Lost(self._last_place()))
        flight.publish(self._pursued(flight.observation))

    def _pursued(self, seen: Observation) -> Pursued:
        track = self.track
        if not track.is_known:
            return Pursued(losses=self.losses)
        place, (x, y, z) = track.position_at(seen.time), track.velocity_at(seen.time)
        level = hypot(place.x - seen.position.x, place.y - seen.position.y)
        return Pursued(
            visible=track.sighting is not None,
            distance=distance(place, seen.position),
            bearing=wrap(bearing(seen.position, place) - seen.yaw),
            elevation=atan2(place.z - seen.position.z - self.eye_height, level),
            position=place,
            velocity={"x": x, "y": y, "z": z},
            losses=self.losses,
        )

    def _drawn(self, frame: Frame) -> Pixels:
        """What it has found in a frame, and where the target is expected: blue when unseen."""
        track, image, words = self.track, frame.image, "looking for it"
        seen = track.sighting
        if seen is not None:
            image = rejected(image, [seen.outline], YELLOW)
        if track.is_known:
            place = track.position_at(frame.time)
            x, y = map(float, pixels_of(frame, [place])[0])
            image = circle(image, (x, y), _MARK, BLUE if seen is None else GREEN)
            words = f"{distance(place, frame.position):.1f} m"
        return text_line(image, words)

    def _last_place(self) -> Point:
        track = self.track
        return track.position_at(track.seen_at) if track.is_known else STILL

    def _aim(self, unseen: float, flight: Flight) -> Aim:
        """Where to be and to look: by the target, or where it may be."""
        params, reference, track = self.params, self.reference, self.track
        if not track.is_known or unseen > _PREDICTED + SWEEP:
            if self.search is None:
                here = reference.place
                self.search = TargetSearch(here, reference.yaw, params.least_height, params.reach)
            return self.search.step(reference, flight.dt)
        self.search = None
        aim = self._follow(flight.now)
        if unseen <= _PREDICTED:
            return aim
        yaw, rate = sweep(bearing(reference.place, self._expected(flight.now)), unseen - _PREDICTED)
        return aim._replace(yaw=yaw, yaw_rate=rate)

    def _expected(self, now: float) -> Point:
        """The target, at the height from which it is to be looked at."""
        params = self.params
        place = self.track.position_at(now)
        height = max(params.least_height, place.z - self.eye_height + params.above)
        return place._replace(z=height)

    def _follow(self, now: float) -> Aim:
        """The place at the distance asked for, on the line to the target; only along that line
        does its motion matter, for the rest it is enough to turn.

        On that line, with the target's velocity along it s and across it w at a distance d, the
        line turns at w/d; so the place moves at s, and is accelerated along the line by the
        target's acceleration and w²/d, across it by s·w/d.
        """
        params, reference = self.params, self.reference
        target, speed = self._expected(now), self.track.velocity_at(now)
        push = self.track.acceleration_at(now)
        gap = target.minus(reference.place)
        far = max(0.1, hypot(gap.x, gap.y))
        ux, uy = gap.x / far, gap.y / far
        along, across = speed.x * ux + speed.y * uy, speed.y * ux - speed.x * uy
        turning = across / far
        wanted = sqrt(max(params.nearest**2, params.distance**2 - params.above**2))
        wanted += _MARGIN * hypot(speed.x, speed.y)
        drop = reference.place.z + self.eye_height - self.track.position_at(now).z
        wanted = max(wanted, abs(drop) / _STEEPEST)
        error = _beyond(far - wanted, params.dead_distance)
        if far < params.nearest:
            along = min(along, 0.0)
        gain = push.x * ux + push.y * uy + across * turning
        side = along * turning
        return Aim(
            place=Point(
                reference.place.x + error * ux,
                reference.place.y + error * uy,
                reference.place.z + _beyond(gap.z, params.dead_height),
            ),
            velocity=Point(along * ux, along * uy, speed.z),
            acceleration=Point(gain * ux - side * uy, gain * uy + side * ux, push.z),
            yaw=reference.yaw
            + _beyond(wrap(atan2(gap.y, gap.x) - reference.yaw), params.dead_bearing),
            yaw_rate=turning,
        )


def _beyond(error: float, dead: float) -> float:
    """How much of an error, of either sign, is outside a dead band."""
    return error - dead if error > dead else error + dead if error < -dead else 0.0


def _target(params: Any) -> tuple[ColorRange, float]:
    """The colour and the size (m) of the target. Raises Unflyable."""
    given = params.target
    if not isinstance(given, Mapping) or set(given) != {"color", "size"}:
        hint = "target: {color: red, size: 52 cm}"
        raise Unflyable("a target has a colour and a size", "target", hint)
    size = given["size"]
    if isinstance(size, bool) or not isinstance(size, (int, float)) or not 0.05 <= size <= 10.0:
        message = f"a target of the size {size!r:.40}; it must be from 5 cm to 10 m"
        raise Unflyable(message, "target", "size: 52 cm")
    return color_of(given["color"], "target"), float(size)
