"""A watch for tags: the newest frames of a camera, looked through, and what was seen in them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from behaviors.flight import Flight
from behaviors.new_frames import NewFrames
from behaviors.perception.annotations import BLUE, GREEN, circle, marker, rejected
from behaviors.perception.tag_tracks import Sighting, TagTracks, Track
from behaviors.perception.tags import Place, TagFinder
from behaviors.plan import Unflyable
from hal.scene.arrays import Pixels
from hal.vehicle import Frame

FORGOTTEN = 1.0
"""Seconds without a picture that counts after which no tag is visible any more."""
_LEAST_CIRCLE = 8.0
"""Radius of the smallest circle that is drawn about a tag, pixels."""


class TagWatch:
    """Looks for tags with one camera: ``look`` in every period."""

    def __init__(
        self,
        flight: Flight,
        name: str,
        camera: str,
        finder: TagFinder,
        tracks: TagTracks,
        most_tilt: float | None = None,
    ) -> None:
        """``name`` is that of the annotated pictures. Frames taken at more than ``most_tilt``
        radians are ignored. Raises hal's Unavailable where there is no such camera.
        """
        self._frames = NewFrames(flight.camera(camera), most_tilt)
        self._finder = finder
        self._tracks = tracks
        self._name = name
        self._time = flight.now
        """Capture time of the last picture that counted, seconds."""

    def look(self, flight: Flight, is_near: Callable[[Place], bool]) -> list[Sighting] | None:
        """Look through the newest frame; what was sighted in it, or None if it is no new one.

        Annotated pictures have a green circle about what ``is_near`` to where it is wanted.
        """
        frame = self._frames.next(flight.observation)
        if frame is None:
            return None
        self._time = frame.time
        sighted = self._tracks.update(frame, self._finder.find(frame, _ground_below(flight)))
        flight.picture(self._name, lambda: self._drawn(frame, is_near))
        return sighted

    def _drawn(self, frame: Frame, is_near: Callable[[Place], bool]) -> Pixels:
        """The frame with its tags: found ones with their axes, each with a circle about it."""
        image = rejected(frame.image, self._finder.rejected)
        for track in self._tracks.visible:
            if track.time == frame.time:
                image = marker(image, track.tag.corners)
            color = GREEN if is_near(track.place) else BLUE
            radius = max(_LEAST_CIRCLE, 0.9 * float(np.ptp(track.tag.corners, axis=0).max()))
            image = circle(image, track.pixel, radius, color, f"{track.id}")
        return image

    def progress(self) -> list[list[float] | None]:
        """The roundels that it knows, as JSON."""
        return self._tracks.progress()

    def visible(self, now: float) -> list[Track]:
        """The tags in view."""
        return self._tracks.visible if now - self._time <= FORGOTTEN else []


def finder_of(
    dictionary: str,
    ids: list[Any] | None,
    size: float | None,
    *,
    roundels: bool = True,
    parameter: str = "ids",
) -> TagFinder:
    """The finder of a behaviour's parameters; ``parameter`` is the name of the one that holds the
    ids. Raises Unflyable.
    """
    try:
        return TagFinder(dictionary, ids, size, roundels=roundels)
    except ValueError as error:
        raise Unflyable(str(error), parameter) from None


def _ground_below(flight: Flight) -> float:
    """The height of the ground below the vehicle, mission frame; home's where it is not known."""
    frame, seen = flight.frame, flight.observation
    if frame.ground_height is None:
        return 0.0
    x, y, _ = seen.position
    return frame.point({"x": x, "y": y, "above_ground": 0.0}, seen).z
