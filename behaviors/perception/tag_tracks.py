"""Tags followed from picture to picture: which are there, where they are, and their sightings.

A tag counts as visible once it was found in ``needed`` of the last ``of`` pictures, and until it
was found in none of them: so neither a false detection nor a missed one shows. Where positions are
known a filter of constant velocity bridges the pictures in which it was missed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import hypot, isnan, sqrt

from behaviors.perception.projection import pixels_of
from behaviors.perception.tags import ROUNDEL, Place, Tag
from behaviors.perception.target_filter import TargetFilter
from hal.vehicle import Frame
from vencejo.geometry import Point, distance

NEAR = 0.5
"""Distance from where it is expected within which a tag is the same one, metres."""
_NEAR_IN_PICTURE = 0.25
"""That where no position is known, as a share of the picture's width."""
_STEP = 0.05
"""What counts as an approach to the middle of the picture, as a share of its height."""
_AWAY = 0.01
"""How much farther from the middle than it was a tag must be to have passed it, as such a share."""
_ENDED = 0.5
"""Seconds without having come nearer after which an approach to the middle has ended."""


@dataclass(frozen=True)
class Sighting:
    """A tag as it was seen at one moment."""

    kind: str
    id: int
    time: float
    place: Place
    position: Point | None
    distance: float | None


class _Approach:
    """Notices where a tag comes nearest to the middle of the picture.

    One approach after another: a new one begins when the tag has gone away from the middle.
    """

    def __init__(self, first: Sighting, height: int) -> None:
        """``height`` is that of the picture, pixels."""
        self._step, self._away = _STEP * height, _AWAY * height
        self._told = first.place.radius
        self._nearest = first

    def follow(self, seen: Sighting) -> Sighting | None:
        """The nearest sighting of an approach that has ended; None otherwise."""
        radius = seen.place.radius
        if radius < self._nearest.place.radius:
            self._nearest = seen
        turned_away = radius > self._nearest.place.radius + self._away
        ended = self.end() if turned_away or seen.time - self._nearest.time > _ENDED else None
        if radius > self._told + 2 * self._step:
            self._told, self._nearest = radius, seen
        return ended

    def end(self) -> Sighting | None:
        """The nearest sighting, if it has not been told."""
        if self._nearest.place.radius > self._told - self._step:
            return None
        self._told = self._nearest.place.radius
        return self._nearest


class Track:
    """One tag, from picture to picture."""

    def __init__(self, tag: Tag, of: int) -> None:
        self.kind = tag.kind
        self.id = tag.id
        """Of a marker; of a roundel, its number."""
        self.tag = tag
        """As it was found last."""
        self.is_visible = False
        self.time = 0.0
        """Capture time of the picture in which it was found last, seconds."""
        self.place = Place(0.0, 0.0, 0.0)
        """In the newest picture; where it is expected, if it was missed there."""
        self.pixel = tag.pixel
        self._filter = TargetFilter()
        self._found: deque[bool] = deque(maxlen=of)
        self.approach: _Approach | None = None

    def take(self, frame: Frame, tag: Tag) -> None:
        """Note that it was found in a picture."""
        self._found.append(True)
        self.tag, self.time, self.pixel = tag, frame.time, tag.pixel
        self.place = Place.of(frame, tag.pixel)
        if tag.position is not None:
            self._filter.update(tag.position, tag.covariance, frame.time)

    def miss(self, frame: Frame) -> None:
        """Note that it was not found in a picture."""
        self._found.append(False)
        if self._filter.is_known:
            x, y = pixels_of(frame, [self._filter.position_at(frame.time)])[0].tolist()
            if not isnan(x):  # it is not behind the camera
                self.pixel = (x, y)
                self.place = Place.of(frame, self.pixel)

    @property
    def times_found(self) -> int:
        """Of the last pictures."""
        return sum(self._found)

    @property
    def velocity(self) -> Point | None:
        """World axes of the frame's pose, m/s; None where no position is known."""
        return self._filter.velocity if self._filter.is_known else None

    def position_at(self, time: float) -> Point | None:
        """Where it is expected at a time; None where no position is known."""
        return self._filter.position_at(time) if self._filter.is_known else None

    def misfit(self, frame: Frame, tag: Tag) -> float:
        """How far a tag in a new picture is from this one, as a share of what may be."""
        here = self.position_at(frame.time)
        if here is not None and tag.position is not None:
            spread = 3 * sqrt(float(tag.covariance.trace()))
            return distance(here, tag.position) / (NEAR + spread)
        away = hypot(self.pixel[0] - tag.pixel[0], self.pixel[1] - tag.pixel[1])
        return away / (_NEAR_IN_PICTURE * frame.intrinsics.width)

    def sighting(self) -> Sighting:
        position = self.tag.position
        return Sighting(self.kind, self.id, self.time, self.place, position, self.tag.distance)


class TagTracks:
    """The tags before one camera; give it the tags of each new frame."""

    def __init__(self, needed: int = 2, of: int = 5) -> None:
        self._needed = needed
        self._of = of
        self._tracks: list[Track] = []
        self._roundels: list[Point | None] = []
        """Where each roundel was last, by its number from 1 on; None where it is not known."""

    def progress(self) -> list[list[float] | None]:
        """Where each roundel was last, as JSON."""
        return [place and list(place) for place in self._roundels]

    def go_on(self, progress: Iterable[Sequence[float] | None]) -> None:
        """Go on with the numbers of the roundels of other tracks."""
        self._roundels = [Point(*place) if place else None for place in progress]

    @property
    def visible(self) -> list[Track]:
        return [track for track in self._tracks if track.is_visible]

    def update(self, frame: Frame, tags: Sequence[Tag]) -> list[Sighting]:
        """Take the tags of a new frame.

        Returns what was sighted: each tag that has come into view, and each that has been as near
        to the middle of the picture as it came, at the moment when it was.
        """
        left = list(self._tracks)
        for track, tag in self._pairs(frame, tags):
            if track is None:
                track = Track(tag, self._of)
                self._tracks.append(track)
            else:
                left.remove(track)
            track.take(frame, tag)
        for track in left:
            track.miss(frame)
        sighted = [each for track in self._tracks for each in self._judged(frame, track)]
        self._tracks = [track for track in self._tracks if track.times_found]
        return sighted

    def _pairs(self, frame: Frame, tags: Sequence[Tag]) -> list[tuple[Track | None, Tag]]:
        """Each tag with its track, the likeliest pairs first; without one it is new."""
        pairs = sorted(
            (track.misfit(frame, tag), t, k)
            for t, track in enumerate(self._tracks)
            for k, tag in enumerate(tags)
            if track.kind == tag.kind and (tag.kind == ROUNDEL or track.id == tag.id)
        )
        chosen: dict[int, Track] = {}
        taken: set[int] = set()
        for misfit, t, k in pairs:
            if misfit <= 1.0 and k not in chosen and t not in taken:
                chosen[k] = self._tracks[t]
                taken.add(t)
        return [(chosen.get(k), tag) for k, tag in enumerate(tags)]

    def _judged(self, frame: Frame, track: Track) -> list[Sighting]:
        """Bring a track's visibility up to date; what was sighted of it."""
        sighted: list[Sighting | None] = []
        if not track.is_visible and track.times_found >= self._needed:
            track.is_visible = True
            if track.kind == ROUNDEL:
                track.id = self._number_of(track.tag.position)
            first = track.sighting()
            track.approach = _Approach(first, frame.intrinsics.height)
            sighted.append(first)
        elif track.approach is not None and track.time == frame.time:
            sighted.append(track.approach.follow(track.sighting()))
            if track.kind == ROUNDEL:
                self._roundels[track.id - 1] = track.tag.position
        elif track.approach is not None and not track.times_found:
            track.is_visible = False
            sighted.append(track.approach.end())
        return [each for each in sighted if each is not None]

    def _number_of(self, position: Point | None) -> int:
        """The number of a roundel: that of the one that was seen there before, or a new one."""
        near = [
            (distance(position, known), number)
            for number, known in enumerate(self._roundels, 1)
            if position is not None and known is not None and distance(position, known) < NEAR
        ]
        if near:
            return min(near)[1]
        self._roundels.append(position)
        return len(self._roundels)
