"""Following a path: its set-points in time, which wait for a vehicle that is held up."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf, sqrt
from typing import Any

from behaviors.guidance import BRAKING, CATCH_UP, MAX_LEAD, RAMP, SMOOTHING
from behaviors.moving_average import MovingAverage
from behaviors.pace import Pace
from behaviors.path import Path
from hal.vehicle import PERIOD, Observation, Position
from vencejo.geometry import Point, distance

_KNOWN = 3
"""Periods whose places are known: the present and the next two."""
_MOVING = 0.01
"""Speed below which a path does not wait, m/s."""
_SAME_TIME, _SAME_PLACE = 1e-6, 1e-6
"""Times, s, and places, m, that are nearer to each other than this are one."""


class _Clock:
    """The time on a path: it runs with the vehicle's clock, or more slowly where it must wait."""

    def __init__(self, duration: float, ramp: float) -> None:
        self._duration, self._ramp = duration, ramp
        self._rate = 0.0 if ramp else 1.0
        self.time = 0.0

    @property
    def ended(self) -> bool:
        return self.time >= self._duration - _SAME_TIME

    def step(self, most: float, dt: float) -> float:
        """Let ``dt`` seconds pass, at the rate ``most`` at most; the time on the path."""
        change = dt / (self._ramp or RAMP)
        wanted = min(1.0, most, self._stopping_rate(dt))
        self._rate += max(-change, min(change, wanted - self._rate))
        self.time += self._rate * dt
        return self.time

    def halt(self) -> None:
        """Stop, to go on anew."""
        self._rate = 0.0

    def _stopping_rate(self, dt: float) -> float:
        if not self._ramp:
            return inf
        left, loss = self._duration - self.time, BRAKING / self._ramp
        return min(sqrt((loss * dt / 2) ** 2 + 2 * loss * left) - loss * dt / 2, left / dt)

    def progress(self) -> list[float]:
        """Its state, as JSON."""
        return [self.time, self._rate]

    def resume(self, progress: Sequence[float]) -> None:
        """Go on from the progress of a clock of the same path."""
        self.time, self._rate = progress


class _Smoothing:
    """Takes the steps out of an acceleration: the mean of a few numbers over SMOOTHING periods."""

    def __init__(self, numbers: Iterable[float]) -> None:
        self._averages = [MovingAverage([number] * SMOOTHING) for number in numbers]

    def push(self, numbers: Iterable[float]) -> list[float]:
        return [average.push(n) for average, n in zip(self._averages, numbers, strict=True)]

    def progress(self) -> list[list[float]]:
        """Its state, as JSON."""
        return [average.progress() for average in self._averages]

    def resume(self, progress: Sequence[Sequence[float]]) -> None:
        """Go on from the progress of another one."""
        self._averages = [MovingAverage.resumed(each) for each in progress]


class PathFollower:
    """Gives the set-points of a path: each period ``step``, then ``setpoint``.

    A path whose pace is from rest to rest is smoothed as the reference of a goto is, by the mean of
    its places: they cut a bend of the acceleration a by a·T²/24, where T is the time averaged. One
    whose pace has no steps itself is flown exactly: there the time is smoothed, with which it comes
    to speed within ``ramp`` seconds and stops before its end.
    """

    def __init__(self, path: Path, pace: Pace, ramp: float = 0.0) -> None:
        self.path, self.pace, self._ramp = path, pace, ramp
        self._clock = _Clock(pace.duration, ramp)
        self._periods = MovingAverage([PERIOD] * SMOOTHING)
        begin = path.place(0.0)
        self._smoothing = _Smoothing([0.0] if ramp else [0.0, *begin])
        self._steps = [(0.0, begin)] * _KNOWN
        """The way along the path and the place of this period and those after it."""

    @property
    def way(self) -> float:
        """The way along the path of where the vehicle is to be now, metres."""
        return self._steps[0][0]

    @property
    def place(self) -> Point:
        """Where the vehicle is to be now, mission frame."""
        return self._steps[0][1]

    @property
    def ended(self) -> bool:
        """Whether that is the end, where it stays."""
        return self._clock.ended and distance(self.place, self.path.places[-1]) < _SAME_PLACE

    @property
    def velocity(self) -> Point:
        """The mean velocity until the next period, m/s."""
        (_, here), (_, there), _ = self._steps
        return there.minus(here).times(1 / self._periods.mean)

    def step(self, vehicle: Observation, dt: float) -> None:
        """Go on by a period, unless the vehicle is held up."""
        self._periods.push(dt)
        time = self._clock.step(self._rate_for(vehicle), dt)
        self._steps = [*self._steps[1:], self._next(time)]

    def _next(self, time: float) -> tuple[float, Point]:
        if self._ramp:
            (time,) = self._smoothing.push([time])
            way, _ = self.pace.at(time)
            return way, self.path.place(way)
        way, _ = self.pace.at(time)
        way, *place = self._smoothing.push([way, *self.path.place(way)])
        return way, Point(*place)

    def _rate_for(self, vehicle: Observation) -> float:
        """The largest rate at which a vehicle is not left behind."""
        velocity, lead = self.velocity, distance(self.place, vehicle.position)
        speed = velocity.norm()
        if speed < _MOVING:
            return 1.0 if lead < MAX_LEAD else 0.0
        flown = vehicle.velocity
        along = flown.x * velocity.x + flown.y * velocity.y + flown.z * velocity.z
        return max(0.0, along / speed + (MAX_LEAD - lead) * CATCH_UP) / speed

    def halt(self) -> None:
        """Stop where it is now, to come to speed anew from there."""
        (way, place), time = self._steps[0], self._clock.time
        self._clock.halt()
        self._smoothing = _Smoothing([time] if self._ramp else [way, *place])
        self._steps = [(way, place)] * _KNOWN

    def setpoint(self, yaw: float) -> Position:
        """Where the vehicle is to be now, with the velocity and acceleration until the next."""
        (_, here), (_, there), (_, then) = self._steps
        change = then.minus(there).minus(there.minus(here))
        acceleration = change.times(1 / self._periods.mean**2)
        return Position(here, self.velocity, yaw, acceleration=acceleration)

    def progress(self) -> dict[str, Any]:
        """Its state, as JSON."""
        return {
            "clock": self._clock.progress(),
            "periods": self._periods.progress(),
            "smoothing": self._smoothing.progress(),
            "steps": [[way, *place] for way, place in self._steps],
        }

    def resume(self, progress: Mapping[str, Any]) -> None:
        """Go on from the progress of a follower of the same path."""
        self._clock.resume(progress["clock"])
        self._periods = MovingAverage.resumed(progress["periods"])
        self._smoothing.resume(progress["smoothing"])
        self._steps = [(way, Point(*place)) for way, *place in progress["steps"]]
