"""The new frames of a camera: each once, and none that was taken while the vehicle was tilted."""

from __future__ import annotations

from collections import deque

from behaviors.perception.projection import tilt_of
from hal.vehicle import Camera, Frame, Observation

_REMEMBERED = 40
"""Periods: a frame is not older than a second when it is read first."""


class NewFrames:
    """Call ``next`` in each period."""

    def __init__(self, camera: Camera, most_tilt: float | None = None) -> None:
        """Frames taken while the vehicle was tilted by more than ``most_tilt`` radians are left
        out.
        """
        self._camera = camera
        self._most_tilt = most_tilt
        self._sequence: int | None = None
        self._tilts: deque[tuple[float, float]] = deque(maxlen=_REMEMBERED)
        """Time, seconds, and tilt, radians, in the last periods."""

    def next(self, seen: Observation) -> Frame | None:
        """The camera's newest frame; None where it was given before, or is left out."""
        if self._most_tilt is not None:
            self._tilts.append((seen.time, tilt_of(seen.attitude)))
        frame = self._camera.latest()
        if frame is None or frame.sequence == self._sequence:
            return None
        self._sequence = frame.sequence
        return None if self._was_tilted(frame.time) else frame

    def _was_tilted(self, time: float) -> bool:
        """Whether the vehicle was tilted too far at a time."""
        if self._most_tilt is None:
            return False
        _, tilt = min(self._tilts, key=lambda each: abs(each[0] - time))
        return tilt > self._most_tilt
