"""Where a moving thing is at a time. World frame, metres, radians, seconds since the run began."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import dist, floor

from vencejo.geometry import Point, Quaternion, bearing, product, wrap, yaw_quaternion
from worlds.things import Motion, Thing

STRETCH = 0.025
"""Seconds that a thing moves straight on (a mission period): at their ends it is on its path."""
_TURN = 0.5
"""Seconds before and after a corner in which a thing turns, as far as its legs are long enough."""


def pose_at(thing: Thing, time: float) -> tuple[Point, Quaternion]:
    """The place of a thing's origin and its attitude.

    A moving thing whose heading follows its path has its own attitude on top of that heading.
    """
    if thing.motion is None:
        return thing.at, thing.attitude
    place, heading = _carried(track_of(thing.motion), time)
    if not thing.motion.turns:
        return place, thing.attitude
    return place, product(yaw_quaternion(heading), thing.attitude)


def _carried(track: Track, time: float) -> tuple[Point, float]:
    """Place and heading: physics and pictures have to agree also between the ends of stretches."""
    number = floor(time / STRETCH + 1e-6)
    share = time / STRETCH - number
    if abs(share) < 1e-6:
        return track.at(time)
    place, heading = track.at(number * STRETCH)
    end, final = track.at((number + 1) * STRETCH)
    way = end.minus(place)
    place = place.plus((way.x * share, way.y * share, way.z * share))
    return place, wrap(heading + wrap(final - heading) * share)


@dataclass(frozen=True, slots=True)
class Track:
    """A path as a closed round of straight legs: there and back, where it is no loop."""

    corners: tuple[Point, ...]
    """Where each leg begins, and at last where the round ends."""
    ways: tuple[float, ...]
    """The way along the round to each corner, metres."""
    headings: tuple[float, ...]
    """Of each leg, radians."""
    speed: float

    def at(self, time: float) -> tuple[Point, float]:
        """Place and heading."""
        way = self.speed * time % self.ways[-1]
        leg = min(bisect_right(self.ways, way), len(self.headings)) - 1
        a, b = self.corners[leg], self.corners[leg + 1]
        done = (way - self.ways[leg]) / self._length(leg)
        along = b.minus(a)
        place = a.plus((along.x * done, along.y * done, along.z * done))
        if done < 0.5:
            return place, self._round_corner(leg - 1, leg, way - self.ways[leg])
        following = (leg + 1) % len(self.headings)
        return place, self._round_corner(leg, following, way - self.ways[leg + 1])

    def _round_corner(self, before: int, after: int, offset: float) -> float:
        """The heading, a way before (below 0) or after the corner of two legs."""
        bend = wrap(self.headings[after] - self.headings[before])
        shorter = min(self._length(before), self._length(after))
        reach = min(_TURN * self.speed, shorter / 2)
        share = min(1.0, max(0.0, (offset + reach) / (2 * reach)))
        return wrap(self.headings[before] + bend * share)

    def _length(self, leg: int) -> float:
        leg %= len(self.headings)
        return self.ways[leg + 1] - self.ways[leg]


@lru_cache(maxsize=1000)
def track_of(motion: Motion) -> Track:
    """The round of a motion."""
    points = list(motion.points)
    corners = [*points, points[0]] if motion.loop else [*points, *reversed(points[:-1])]
    corners = [a for a, b in pairwise(corners) if a != b] + [corners[-1]]
    ways = [0.0]
    for a, b in pairwise(corners):
        ways.append(ways[-1] + dist(a, b))
    return Track(tuple(corners), tuple(ways), _headings(corners), motion.speed)


def _headings(corners: list[Point]) -> tuple[float, ...]:
    """Where each leg leads; an upright one has no heading of its own and keeps the one before."""
    level = [(a, b) for a, b in pairwise(corners) if a[:2] != b[:2]]
    heading = bearing(*level[-1]) if level else 0.0
    headings = []
    for a, b in pairwise(corners):
        if a[:2] != b[:2]:
            heading = bearing(a, b)
        headings.append(heading)
    return tuple(headings)
