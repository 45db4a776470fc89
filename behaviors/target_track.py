"""The track of a coloured target through the frames of a camera: seen, hidden for a while, lost."""

from __future__ import annotations

from math import exp, inf

from behaviors.guidance import STILL
from behaviors.perception.color import ColorRange
from behaviors.perception.quadrotors import Sighting, sightings
from behaviors.perception.target_filter import TargetFilter
from hal.scene.arrays import Float64s
from hal.vehicle import Frame
from vencejo.geometry import Point

CONFIRMED = 3
"""Frames in a row in which something new must be seen before it is the target."""
KEPT = 0.2
"""Seconds for which an unseen target keeps its velocity."""
FADING = 1.0
"""Time constant with which it fades afterwards, seconds."""
_NEAREST = 0.3
"""Least range of a target that the edge of the image cuts, metres."""
_MANOEUVRE = 6.0
"""Standard deviation of the acceleration for which the filter is ready, m/s²: with less it follows
sharp turns late.
"""
_SETTLING = 0.25
"""Time constant with which its acceleration is followed, seconds."""
_MOST_ACCELERATION = 4.0
"""Of what is told of the target, m/s²."""


class TargetTrack:
    """Where a target is and how it moves, mission frame, by the frames it was shown."""

    def __init__(self, wanted: ColorRange, size: float) -> None:
        """``size``: of the target along its axes, metres."""
        self._wanted = wanted
        self._size = size
        self._filter = TargetFilter(_MANOEUVRE)
        self._acceleration = STILL
        self._count = 0
        """Frames in which it was seen, in a row, up to CONFIRMED."""
        self.sighting: Sighting | None = None
        """What of the last frame was taken for it; None where nothing was."""
        self.seen_at = -inf
        """When it was last seen, seconds."""

    @property
    def is_known(self) -> bool:
        """Whether it has been seen well enough to be followed."""
        return self._count >= CONFIRMED

    def look(self, frame: Frame) -> None:
        """Look for it in a new frame."""
        found = sightings(frame, self._wanted, self._size)
        whole = [each for each in found if each.range < inf]
        best = self._nearest(whole, frame)
        if best is None and not self.is_known:
            self._filter, self._count = TargetFilter(_MANOEUVRE), 0
            best = self._nearest(whole, frame)
        if best is None and self.is_known:
            best = self._doubtful(found, frame)
        elif best is not None:
            self._update(best.position(), best.covariance(frame.intrinsics.fx), frame.time)
        self.sighting = best
        if best is not None:
            self._count = min(CONFIRMED, self._count + 1)
            self.seen_at = frame.time

    def _nearest(self, whole: list[Sighting], frame: Frame) -> Sighting | None:
        """What is most likely the target."""
        focal = frame.intrinsics.fx
        places = [(each.position(), each.covariance(focal)) for each in whole]
        best = self._filter.nearest(places, frame.time)
        return None if best is None else whole[best]

    def _doubtful(self, found: list[Sighting], frame: Frame) -> Sighting | None:
        """What may be the target though it is not where that is expected, or cut by the edge."""
        focal = frame.intrinsics.fx
        for each in found:
            if each.range < inf:
                # The filter follows what stays outside its gate.
                taken = self._update(each.position(), each.covariance(focal), frame.time)
            else:
                # Its direction counts, at the range that is expected.
                far = max(_NEAREST, self._filter.position_at(frame.time).minus(each.eye).norm())
                place, doubt = each.position(far), each.covariance(focal, far)
                taken = self._update(place, doubt, frame.time)
            if taken:
                return each
        return None

    def _update(self, place: Point, covariance: Float64s, time: float) -> bool:
        before, then = self._filter.velocity, self._filter.time
        taken = self._filter.update(place, covariance, time)
        if taken and then is not None and time > then:
            share = min(1.0, (time - then) / _SETTLING)
            change = self._filter.velocity.minus(before)
            told = Point(*(each / (time - then) for each in change))
            self._acceleration = Point(
                *(
                    max(-_MOST_ACCELERATION, min(_MOST_ACCELERATION, old + share * (new - old)))
                    for old, new in zip(self._acceleration, told, strict=True)
                )
            )
        return taken

    def position_at(self, now: float) -> Point:
        """Where it is, the velocity fading while it is not seen."""
        age = max(0.0, now - self._time)
        fading = max(0.0, age - KEPT)
        return self._filter.position_at(
            self._time + min(age, KEPT) + FADING * (1 - exp(-fading / FADING))
        )

    def velocity_at(self, now: float) -> Point:
        """m/s."""
        left = exp(-max(0.0, now - self._time - KEPT) / FADING)
        return Point(*(each * left for each in self._filter.velocity))

    def acceleration_at(self, now: float) -> Point:
        """m/s²; soon none while it is not seen."""
        left = exp(-max(0.0, now - self._time - KEPT) / _SETTLING)
        return Point(*(each * left for each in self._acceleration))

    @property
    def _time(self) -> float:
        return self._filter.time or 0.0
