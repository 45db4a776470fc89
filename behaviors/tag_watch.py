"""A watch for tags: the newest frames of a camera, looked through, and what was seen in them."""

from __future__ import annotations

from typing import Any

from behaviors.flight import Flight
from behaviors.perception.projection import tilt_of
from behaviors.perception.tag_tracks import Sighting, TagTracks, Track
from behaviors.perception.tags import TagFinder
from behaviors.plan import Unflyable

FORGOTTEN = 1.0
"""Seconds without a picture that counts after which no tag is visible any more."""


class TagWatch:
    """Looks for tags with one camera: ``look`` in every period."""

    def __init__(
        self,
        flight: Flight,
        camera: str,
        finder: TagFinder,
        tracks: TagTracks,
        most_tilt: float | None = None,
    ) -> None:
        """Pictures taken at more than ``most_tilt`` radians are ignored.

        Raises hal's Unavailable where there is no such camera.
        """
        self._camera = flight.camera(camera)
        self._finder = finder
        self._tracks = tracks
        self._most_tilt = most_tilt
        self._sequence = -1
        self._time = flight.now
        """Capture time of the last picture that counted, seconds."""

    def look(self, flight: Flight) -> list[Sighting]:
        """Look through the newest frame, if it is a new one; what was sighted in it."""
        frame = self._camera.latest()
        if frame is None or frame.sequence == self._sequence:
            return []
        self._sequence = frame.sequence
        if self._most_tilt is not None and tilt_of(flight.observation.attitude) > self._most_tilt:
            return []
        self._time = frame.time
        return self._tracks.update(frame, self._finder.find(frame, _ground_below(flight)))

    def visible(self, now: float) -> list[Track]:
        """The tags in view."""
        return self._tracks.visible if now - self._time <= FORGOTTEN else []


def finder_of(
    dictionary: str, ids: list[Any] | None, size: float | None, *, roundels: bool = True
) -> TagFinder:
    """The finder of a behaviour's parameters. Raises Unflyable."""
    whole = ids is None or all(isinstance(each, int) for each in ids)
    if not whole:
        raise Unflyable("the ids of markers are whole numbers", "ids")
    try:
        return TagFinder(dictionary, ids, size, roundels=roundels)
    except ValueError as error:
        raise Unflyable(str(error), "ids") from None


def _ground_below(flight: Flight) -> float:
    """The height of the ground below the vehicle, mission frame; home's where it is not known."""
    frame, seen = flight.frame, flight.observation
    if frame.ground_height is None:
        return 0.0
    x, y, _ = seen.position
    return frame.point({"x": x, "y": y, "above_ground": 0.0}, seen).z
