"""The poses of moving things. World frame, metres, radians, seconds since the run began."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import dist, floor, pi

from vencejo.geometry import Point, Pose, bearing, product, wrap, yaw_quaternion
from worlds.things import Motion, Thing

STRETCH = 0.025
"""Seconds that a thing moves in a straight line, one mission period; then it is on its path."""
_GENTLE = pi / 18
"""Greatest bend of a path, radians, round which a thing turns gradually: for the corners of curves,
which are sampled."""
_TURN_TIME = 0.25
"""Seconds before and after a gentle bend in which a thing turns; less where its legs are shorter.
"""


def pose_at(thing: Thing, time: float) -> Pose:
    """The pose of a thing, its own frame to world.

    A moving thing whose heading follows its path has its own attitude on top of that heading.
    """
    if thing.motion is None:
        return thing.at, thing.attitude
    place, heading = _interpolated(track_of(thing.motion), time)
    if not thing.motion.turns:
        return place, thing.attitude
    return place, product(yaw_quaternion(heading), thing.attitude)


def _interpolated(track: Track, time: float) -> tuple[Point, float]:
    """Place and heading, linear between the ends of stretches.

    Physics moves things that way, and images have to agree with it.
    """
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
    """A path as a closed course of straight legs: there and back, where it is no loop."""

    corners: tuple[Point, ...]
    """The beginning of each leg, and the end of the last."""
    distances: tuple[float, ...]
    """The distance along the course to each corner, metres."""
    headings: tuple[float, ...]
    """The heading of each leg, radians."""
    speed: float
    """m/s."""

    def at(self, time: float) -> tuple[Point, float]:
        """Place and heading at a time, exactly on the course."""
        rounds, passed = divmod(self.speed * time, self.distances[-1])
        leg = min(bisect_right(self.distances, passed), len(self.headings)) - 1
        a, b = self.corners[leg], self.corners[leg + 1]
        done = (passed - self.distances[leg]) / self._length(leg)
        along = b.minus(a)
        place = a.plus((along.x * done, along.y * done, along.z * done))
        if done < 0.5:
            # It begins facing along the path; it has not come round the corner where it begins.
            before = leg - 1 if leg or rounds else leg
            return place, self._heading_near_corner(before, leg, passed - self.distances[leg])
        following = (leg + 1) % len(self.headings)
        to_corner = passed - self.distances[leg + 1]
        return place, self._heading_near_corner(leg, following, to_corner)

    def _heading_near_corner(self, before: int, after: int, offset: float) -> float:
        """The heading ``offset`` metres behind the corner of two legs; below 0, before it."""
        bend = wrap(self.headings[after] - self.headings[before])
        shorter = min(self._length(before), self._length(after))
        turn_time = _TURN_TIME if abs(bend) < _GENTLE else STRETCH
        reach = min(turn_time * self.speed, shorter / 2)
        share = min(1.0, max(0.0, (offset + reach) / (2 * reach)))
        return wrap(self.headings[before] + bend * share)

    def _length(self, leg: int) -> float:
        leg %= len(self.headings)
        return self.distances[leg + 1] - self.distances[leg]


@lru_cache(maxsize=1000)
def track_of(motion: Motion) -> Track:
    """The course of a motion."""
    points = list(motion.points)
    corners = [*points, points[0]] if motion.loop else [*points, *reversed(points[:-1])]
    corners = [a for a, b in pairwise(corners) if a != b] + [corners[-1]]
    distances = [0.0]
    for a, b in pairwise(corners):
        distances.append(distances[-1] + dist(a, b))
    return Track(tuple(corners), tuple(distances), _headings(corners), motion.speed)


def _headings(corners: list[Point]) -> tuple[float, ...]:
    """The heading of each leg; a vertical one has none of its own and keeps the one before."""
    level = [(a, b) for a, b in pairwise(corners) if a[:2] != b[:2]]
    heading = bearing(*level[-1]) if level else 0.0
    headings = []
    for a, b in pairwise(corners):
        if a[:2] != b[:2]:
            heading = bearing(a, b)
        headings.append(heading)
    return tuple(headings)
