"""The pace of a path: how far along it the vehicle is at each time.

:func:`paced` makes the fastest one within the speed that was asked for and what the vehicle can do.
First each part of the path gets the speed that its bend allows (v² ≤ a/κ, where κ is the curvature
and a the acceleration that the tilt gives), then a pass forwards and one backwards keep the
acceleration along the path (the velocity profile of the time-optimal path parametrisation, with
bounds that hold for a whole part: J. E. Bobrow et al., *Time-Optimal Control of Robotic
Manipulators Along Specified Paths*, 1985).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import hypot, inf, sqrt, tan

from behaviors.guidance import BRAKING, acceleration_at
from behaviors.path import Path
from hal.limits import Limits
from vencejo.geometry import Point, distance

TURN_RATE = 4.0
"""Largest rate at which the direction of flight turns, rad/s; faster, smoothing cuts the bend."""
CORNERING = 5.0
"""Largest acceleration in a bend, m/s²: with more, a vehicle comes out of it too fast."""
_GRAVITY = 9.81
_SHARE = 0.75
"""Share of the largest tilt that a path may need; the rest is for wind, drag and errors."""
_TILT = 0.35
"""The largest tilt of a vehicle that does not tell it, radians."""
_SLOW = 1e-6
"""Speeds below this are none, m/s."""


@dataclass(frozen=True)
class Agility:
    """What a vehicle can do, as far as paths ask."""

    acceleration: float
    """Over the ground, m/s²."""
    speed: float = inf
    """Over the ground, m/s."""
    climb: float = inf
    """Up or down, m/s."""

    @classmethod
    def of(cls, limits: Limits) -> Agility:
        """That of a vehicle with these limits: the tilt gives g·tan(tilt)."""
        tilt = _TILT if limits.max_tilt is None else limits.max_tilt
        return cls(_SHARE * _GRAVITY * tan(tilt), limits.max_speed or inf, limits.max_climb or inf)

    @classmethod
    def at_start(cls, limits: Limits, progress: Sequence[float | None] | None) -> Agility:
        """That of a progress, so that a path stays what it was; without one, of the limits."""
        return cls.of(limits) if progress is None else cls.resumed(progress)

    def progress(self) -> list[float | None]:
        """Its numbers, as JSON."""
        bounds = self.acceleration, self.speed, self.climb
        return [None if each == inf else each for each in bounds]

    @classmethod
    def resumed(cls, progress: Sequence[float | None]) -> Agility:
        """That of a progress."""
        return cls(*(inf if each is None else each for each in progress))

    def most(self, direction: Point) -> float:
        """The largest speed in a direction, m/s."""
        level, rise = hypot(direction.x, direction.y), abs(direction.z)
        fastest = self.speed / level if level > _SLOW else inf
        return min(fastest, self.climb / rise) if rise > _SLOW else fastest


@dataclass(frozen=True)
class Pace:
    """The way along a path by the time, with a cubic between nodes. It begins at time 0."""

    times: Sequence[float]
    """Seconds."""
    ways: Sequence[float]
    """Metres."""
    speeds: Sequence[float]
    """m/s."""

    @property
    def duration(self) -> float:
        return self.times[-1]

    @property
    def fastest(self) -> float:
        return max(self.speeds)

    def at(self, time: float) -> tuple[float, float]:
        """The way and the speed at a time, kept between begin and end."""
        if time <= 0.0 or len(self.times) == 1:
            return self.ways[0], self.speeds[0]
        if time >= self.times[-1]:
            return self.ways[-1], self.speeds[-1]
        k = bisect_right(self.times, time) - 1
        h = self.times[k + 1] - self.times[k]
        t = (time - self.times[k]) / h
        r = 1.0 - t
        a, b, u, v = self.ways[k], self.ways[k + 1], self.speeds[k], self.speeds[k + 1]
        way = r * r * (1.0 + 2.0 * t) * a + t * t * (3.0 - 2.0 * t) * b
        way += t * r * (r * u - t * v) * h
        speed = 6.0 * t * r * (b - a) / h + r * (1.0 - 3.0 * t) * u + t * (3.0 * t - 2.0) * v
        return way, speed


def even(path: Path, speed: float) -> Pace:
    """The pace at one speed, m/s, from the first moment on."""
    return Pace([way / speed for way in path.ways], path.ways, [speed] * len(path.ways))


def timed(path: Path, ways: Sequence[float], times: Sequence[float]) -> Pace:
    """The pace that is at each of some ways, which grow, at its time; the first is at time 0.

    The speed at each is such that it never flies backwards (the harmonic mean of those before and
    after it: F. N. Fritsch, J. Butland, *A Method for Constructing Local Monotone Piecewise Cubic
    Interpolants*, 1984). Between them are as many nodes as the path has there, so that none of its
    bends is overlooked.
    """
    means = [
        (b - a) / (u - t) for (a, b), (t, u) in zip(pairwise(ways), pairwise(times), strict=True)
    ]
    inner = [2 * u * v / (u + v) for u, v in pairwise(means)]
    pace = Pace(times, ways, [means[0], *inner, means[-1]])
    nodes: list[float] = []
    for (a, b), (t, u) in zip(pairwise(ways), pairwise(times), strict=True):
        parts = bisect_left(path.ways, b) - bisect_left(path.ways, a) + 1
        nodes += [t + (u - t) * k / parts for k in range(parts)]
    nodes.append(times[-1])
    moments = [pace.at(node) for node in nodes]
    return Pace(nodes, [way for way, _ in moments], [speed for _, speed in moments])


def slowed(directions: Sequence[Point], pace: Pace, agility: Agility) -> Pace:
    """A pace so much slower that the vehicle can fly it; ``directions`` are the path's at each of
    its nodes.
    """
    velocities = [d.times(v) for d, v in zip(directions, pace.speeds, strict=True)]
    turns = (
        distance(a, b) / (u - t)
        for a, b, t, u in zip(velocities, velocities[1:], pace.times, pace.times[1:], strict=False)
    )
    factor = max(1.0, sqrt(max(turns) / agility.acceleration))
    for direction, speed in zip(directions, pace.speeds, strict=True):
        factor = max(factor, speed / agility.most(direction))
    if factor == 1.0:
        return pace
    return Pace([t * factor for t in pace.times], pace.ways, [v / factor for v in pace.speeds])


def bend_speed(bend: float, agility: Agility) -> float:
    """The speed at which a bend of a curvature, 1/m, is flown, m/s: infinite where it is none."""
    if bend <= _SLOW:
        return inf
    return min(sqrt(min(CORNERING, agility.acceleration) / bend), TURN_RATE / bend)


def paced(path: Path, asked: Sequence[float], agility: Agility) -> Pace:
    """The fastest pace of a path, from rest to rest.

    ``asked`` is the speed asked for from each node to the next one, m/s.
    """
    bends = path.bends()
    most = [
        min(
            speed,
            bend_speed(bend, agility),
            agility.most(path.directions[k]),
            agility.most(path.directions[k + 1]),
        )
        for k, (speed, bend) in enumerate(zip(asked, bends, strict=True))
    ]
    speeds = [0.0, *map(min, most, most[1:]), 0.0] if most else [0.0]
    lengths = [b - a for a, b in zip(path.ways, path.ways[1:], strict=False)]
    gains = [acceleration_at(speed) for speed in most]
    for k, length in enumerate(lengths):
        speeds[k + 1] = min(speeds[k + 1], sqrt(speeds[k] ** 2 + 2 * gains[k] * length))
    for k in reversed(range(len(lengths))):
        loss = BRAKING * gains[k]
        speeds[k] = min(speeds[k], sqrt(speeds[k + 1] ** 2 + 2 * loss * lengths[k]))
    raw = _Steps()
    for k, length in enumerate(lengths):
        raw.add_part(speeds[k], speeds[k + 1], most[k], gains[k], length)
    return raw.pace()


class _Steps:
    """Puts together a pace of parts with constant accelerations."""

    def __init__(self) -> None:
        self._times, self._ways, self._speeds = [0.0], [0.0], [0.0]

    def add_part(self, begin: float, end: float, most: float, gain: float, length: float) -> None:
        """Add a way that is flown as fast as can be: faster, even, and slower again."""
        loss = BRAKING * gain
        # The speed at which both meet if there is no even part between them.
        peak = sqrt((2 * gain * loss * length + loss * begin**2 + gain * end**2) / (gain + loss))
        peak = max(begin, end, min(most, peak))
        rise, fall = (peak**2 - begin**2) / (2 * gain), (peak**2 - end**2) / (2 * loss)
        for way, speed in ((rise, peak), (length - rise - fall, peak), (fall, end)):
            self._add(way, speed)

    def _add(self, way: float, speed: float) -> None:
        mean = (self._speeds[-1] + speed) / 2
        if way > _SLOW and mean > _SLOW:
            self._times.append(self._times[-1] + way / mean)
            self._ways.append(self._ways[-1] + way)
            self._speeds.append(speed)

    def pace(self) -> Pace:
        return Pace(self._times, self._ways, self._speeds)
