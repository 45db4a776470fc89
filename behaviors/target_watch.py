"""A watch for one target: looks at a camera's new frames, and keeps the target's track."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, cos, sin
from typing import Any

from behaviors.flight import Flight
from behaviors.guidance import STILL
from behaviors.new_frames import NewFrames
from behaviors.perception.annotations import BLUE, GREEN, circle, marker, rejected, text_line
from behaviors.perception.projection import pixels_of
from behaviors.perception.target_filter import TargetFilter
from behaviors.perception.targets import Look, Sighting, Target
from hal.scene.arrays import Pixels
from hal.vehicle import Frame
from vencejo.geometry import Point

_HEADING_SHARE = 0.25
"""Share of a new heading in the mean."""
_NEWEST = 0.3
"""Seconds for which a sighting counts as the present."""
_SETTLING = 0.5
"""Time constant of the mean acceleration, seconds."""
_MOST_ACCELERATION = 4.0
"""Along each axis, m/s²."""
_MARK = 6.0
"""Radius of the circle that shows where it is expected, pixels."""


class TargetWatch:
    """Call ``look`` in each period; positions are in the mission frame."""

    def __init__(
        self,
        flight: Flight,
        camera: str,
        target: Target,
        *,
        acceleration: float = 1.0,
        most_tilt: float | None = None,
    ) -> None:
        """``acceleration`` (m/s²) is the standard deviation of the target's; frames seen while
        tilted by more than ``most_tilt`` (radians) are ignored. Raises hal's Unavailable.
        """
        self._frames = NewFrames(flight.camera(camera), most_tilt)
        self._target = target
        self.track = TargetFilter(acceleration)
        self.frame: Frame | None = None
        """The newest frame that was looked at."""
        self.seen = Look(())
        """What it shows."""
        self.sighting: Sighting | None = None
        """The target in it; None where it is not seen."""
        self.acceleration = STILL
        """Of the target, mean of the last half second in which it was seen, m/s²."""
        self._turned: tuple[float, float] | None = None
        """Cosine and sine of the heading, averaged."""

    @property
    def heading(self) -> float | None:
        """That of a marker, radians; None before it was seen."""
        return None if self._turned is None else atan2(self._turned[1], self._turned[0])

    def look(self, flight: Flight) -> bool:
        """Look at the newest frame, and tell whether it is a new one."""
        frame = self._frames.next(flight.observation)
        if frame is None:
            return False
        self.frame, self.seen = frame, self._target.look(frame)
        self.sighting = self._chosen(frame.time)
        return True

    def _chosen(self, time: float) -> Sighting | None:
        """The sighting that is the target, with which its track goes on."""
        sightings, track = self.seen.sightings, self.track
        if not sightings:
            return None
        number = track.nearest([(each.position, each.covariance) for each in sightings], time)
        # Where none fits, the largest may be the target that has gone elsewhere.
        best = sightings[number or 0]
        before, then = track.velocity, track.time
        if not track.update(best.position, best.covariance, time):
            return None
        if then is not None and time > then:
            self._accelerate(track.velocity.minus(before), time - then)
        if best.heading is not None:
            self._turn(best.heading)
        return best

    def _accelerate(self, change: Point, dt: float) -> None:
        """Take a change of the velocity, m/s, into the mean acceleration."""
        share = min(1.0, dt / _SETTLING)
        told = (
            max(-_MOST_ACCELERATION, min(_MOST_ACCELERATION, old + share * (new / dt - old)))
            for old, new in zip(self.acceleration, change, strict=True)
        )
        self.acceleration = Point(*told)

    def _turn(self, heading: float) -> None:
        c, s = cos(heading), sin(heading)
        if self._turned is not None:
            a, b = self._turned
            c, s = a + (c - a) * _HEADING_SHARE, b + (s - b) * _HEADING_SHARE
        self._turned = c, s

    def show(self, flight: Flight, name: str, words: str) -> None:
        """Show people the newest frame: what was found in it, where the target is expected (green
        while it is seen, else blue), what was rejected (red), and some words.
        """
        if self.frame is not None:
            flight.picture(name, lambda: self._drawn(words))

    def _drawn(self, words: str) -> Pixels:
        assert self.frame is not None
        frame, seen = self.frame, self.sighting
        image = rejected(frame.image, self.seen.rejected)
        for each in self.seen.sightings:
            if each.heading is None:
                image = rejected(image, [each.outline], GREEN)
            else:
                image = marker(image, each.outline)
        place = self.position_at(frame.time)
        if place is not None:
            color = BLUE if seen is None else GREEN
            x, y = map(float, pixels_of(frame, [place])[0])
            image = circle(image, (x, y), _MARK, color)
        return text_line(image, words)

    def age(self, now: float) -> float:
        """Seconds since it was seen; infinite before."""
        return self.track.age(now)

    def is_visible(self, now: float) -> bool:
        return self.age(now) <= _NEWEST

    def position_at(self, now: float) -> Point | None:
        """Where it is, or would be if it has gone on as it was seen last; None before."""
        return self.track.position_at(now) if self.track.is_known else None

    def progress(self) -> dict[str, Any]:
        """Its track, as JSON."""
        turned = None if self._turned is None else list(self._turned)
        return {"track": self.track.progress(), "turned": turned}

    def go_on(self, progress: Mapping[str, Any]) -> None:
        """Continue from the progress of another watch."""
        self.track.go_on(progress["track"])
        turned = progress["turned"]
        self._turned = None if turned is None else (turned[0], turned[1])
