"""A reference that follows a moving target, for the vehicle to follow: no jump, whatever the target
does.

It closes an error e at √(2·b·e) at most, from which it can stop (b is BRAKING of its acceleration),
and near the target at GAIN·e; on top of that comes the target's own velocity. Its speed, its
acceleration and the change of that are bounded, and so are the rate of its yaw and the change of
that. Unlike :class:`behaviors.guidance.Reference`, which smooths by waiting, it has no delay.
"""

from __future__ import annotations

from math import copysign, cos, hypot, sin, sqrt
from typing import NamedTuple

from behaviors.guidance import BRAKING, MAX_LEAD, STILL
from behaviors.pace import Agility
from hal.limits import Limits
from hal.vehicle import Observation, Position
from vencejo.geometry import Point, wrap

GAIN = 2.0
"""From an error of the place to a speed, 1/s."""
STIFFNESS = 6.0
"""From an error of the velocity to an acceleration, 1/s."""
JERK = 15.0
"""Largest change of the acceleration, m/s³: a vehicle must tilt first."""
BACKWARDS = 2.1
"""Largest acceleration against the nose, m/s²: a nose that is raised farther, by 12° and what the
vehicle overshoots, loses sight of what is ahead.
"""
CLIMB_ACCELERATION = 1.5
"""Largest acceleration upwards or downwards, m/s²."""
_YAW_GAIN = 4.0
"""From an error of the yaw to a rate, 1/s."""
_YAW_ACCELERATION = 6.0
"""Largest change of the yaw's rate, rad/s²."""
_YAW_RATE = 1.5
"""Largest rate of the yaw of a vehicle that does not tell it, rad/s."""
_YAW_SHARE = 0.9
"""Share of the vehicle's own limit that is used."""


class Aim(NamedTuple):
    """Where the reference is to be, mission frame, and how that moves."""

    place: Point
    velocity: Point
    acceleration: Point
    yaw: float
    """Radians."""
    yaw_rate: float
    """rad/s."""


class TrackingReference:
    """Where the vehicle is to be: place, velocity, acceleration, yaw and its rate."""

    def __init__(self, seen: Observation, limits: Limits, speed: float) -> None:
        """``speed``: over the ground, m/s, at most."""
        agility = Agility.of(limits)
        self._agility = agility.acceleration
        self._speed = min(speed, agility.speed)
        self._climb = min(speed, agility.climb)
        self._turn = _YAW_SHARE * limits.max_yaw_rate if limits.max_yaw_rate else _YAW_RATE
        self.place = seen.position
        self.velocity = seen.velocity
        self.acceleration = STILL
        self.yaw = seen.yaw
        self.yaw_rate = 0.0

    def step(self, aim: Aim, seen: Observation, dt: float) -> None:
        """Follow an aim for ``dt`` seconds."""
        self._wait_for(seen)
        gap = aim.place.minus(self.place)
        vx, vy = self._level_velocity(aim, gap)
        vz = _bound(aim.velocity.z + _closing(gap.z, CLIMB_ACCELERATION), self._climb)
        ax, ay, az = self.acceleration
        # Bounded by itself first, so that the error of the velocity wins whatever is told.
        told = _short(aim.acceleration.x, aim.acceleration.y, self._agility)
        wanted = _short(
            told[0] + (vx - self.velocity.x) * STIFFNESS,
            told[1] + (vy - self.velocity.y) * STIFFNESS,
            self._agility,
        )
        wanted = self._keeping_sight(*wanted)
        rising = _bound(aim.acceleration.z, CLIMB_ACCELERATION)
        up = _bound(rising + (vz - self.velocity.z) * STIFFNESS, CLIMB_ACCELERATION)
        most = JERK * dt
        dx, dy = _short(wanted[0] - ax, wanted[1] - ay, most)
        self.acceleration = Point(ax + dx, ay + dy, az + _bound(up - az, most))
        self.velocity = self.velocity.plus(self.acceleration.times(dt))
        self.place = self.place.plus(self.velocity.times(dt))
        self._turn_to(aim, dt)

    def _keeping_sight(self, x: float, y: float) -> tuple[float, float]:
        """An acceleration, backwards no more than BACKWARDS."""
        east, north = cos(self.yaw), sin(self.yaw)
        short = max(0.0, -BACKWARDS - (x * east + y * north))
        return x + short * east, y + short * north

    def _level_velocity(self, aim: Aim, gap: Point) -> tuple[float, float]:
        far = hypot(gap.x, gap.y)
        share = _closing(far, self._agility) / far if far > 1e-9 else 0.0
        return _short(aim.velocity.x + gap.x * share, aim.velocity.y + gap.y * share, self._speed)

    def _wait_for(self, seen: Observation) -> None:
        """Stay within reach of a vehicle that is slow or held up."""
        lead = self.place.minus(seen.position)
        far = lead.norm()
        if far > MAX_LEAD:
            self.place = seen.position.plus(lead.times(MAX_LEAD / far))

    def _turn_to(self, aim: Aim, dt: float) -> None:
        wanted = _bound(aim.yaw_rate + _YAW_GAIN * wrap(aim.yaw - self.yaw), self._turn)
        self.yaw_rate += _bound(wanted - self.yaw_rate, _YAW_ACCELERATION * dt)
        self.yaw = wrap(self.yaw + self.yaw_rate * dt)

    def setpoint(self) -> Position:
        return Position(self.place, self.velocity, self.yaw, acceleration=self.acceleration)


def _closing(gap: float, most: float) -> float:
    """The speed at which a gap (m, of either sign) is closed with an acceleration of ``most``."""
    return copysign(min(GAIN * abs(gap), sqrt(2 * BRAKING * most * abs(gap))), gap)


def _bound(value: float, most: float) -> float:
    return max(-most, min(most, value))


def _short(x: float, y: float, most: float) -> tuple[float, float]:
    """A vector, or where it is longer than ``most`` that much of it."""
    long = hypot(x, y)
    return (x, y) if long <= most else (x * most / long, y * most / long)
