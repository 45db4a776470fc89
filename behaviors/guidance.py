"""Guidance: a reference that moves smoothly to a target, for the vehicle to follow.

The reference is a point with a velocity, and follows another one, the carrot. In each period
of length dt the carrot wants to move straight at its target with the least of

- the speed that was asked for,
- √((b·dt/2)² + 2·b·s) − b·dt/2: the speed from which it stops within the way s that is left,
  when it slows down by b·dt each period (v² = 2·b·s, less what it moves during a period),
- s/dt: what takes it there in this period,
- u + (MAX_LEAD − l)·CATCH_UP, where u is the vehicle's speed along the line and l its distance
  from the reference: the reference waits for a vehicle that is slow or held up. (MAX_LEAD is the
  leash length of ArduPilot's ``AC_WPNav``.)

It nears that speed by its acceleration a at most, which is ACCELERATION or, at low speeds, what
takes RAMP seconds; and loses what moves it across that line by ACCELERATION, so that it comes onto
its line soon, whatever it did before. The planned deceleration b is BRAKING of a, to have some left
when the target or the speed changes on the way. (The stopping law is that of the square-root
controller in ArduPilot's ``AC_PosControl``.)

The reference is the mean of the carrot's places over the last SMOOTHING periods. So there are no
steps in its acceleration: a vehicle, which must tilt first, could not follow them, and would catch
up at a higher speed than was asked for. Nor is it ever faster than its carrot was, or past it. The
vehicle is given place, velocity and acceleration, and so neither lags behind nor overshoots.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, sqrt

from behaviors.moving_average import MovingAverage
from behaviors.params import Face, Heading
from hal.vehicle import PERIOD, Observation, Position
from vencejo.geometry import Point, bearing, distance, horizontal_distance, wrap

ACCELERATION = 2.0
"""Largest acceleration of the carrot along its line, and that across it, m/s²."""
RAMP = 0.7
"""Least time in which the carrot comes to speed, seconds."""
BRAKING = 0.6
"""Deceleration with which the carrot plans its stop, as a share of its acceleration."""
SMOOTHING = 24
"""Periods over which the carrot's places are averaged."""
MAX_LEAD = 0.6
"""Distance from the reference at which a vehicle that cannot follow is waited for, metres."""
CATCH_UP = 1.0
"""Gain from the missing lead to speed, 1/s: low enough for ACCELERATION, so that it settles."""
MIN_TRAVEL = 0.3
"""Distance over the ground below which a direction is not defined and the heading kept, metres."""
NEARBY = 1.0
"""An interrupted behaviour continues if the vehicle is at most this far from there, metres."""
STILL = Point(0.0, 0.0, 0.0)
_LEVEL = 0.01
"""Square of the level part of a direction below which it is upright."""
_DELAY = (SMOOTHING - 1) / 2 * PERIOD
"""Time by which the reference is behind its carrot, seconds."""


def acceleration_at(speed: float) -> float:
    """The acceleration with which a speed is neared, m/s²."""
    return min(ACCELERATION, speed / RAMP)


class Reference:
    """A moving reference point, mission frame."""

    def __init__(self, position: Point, velocity: Point) -> None:
        self.position = position
        """Where the vehicle is to be now."""
        self.velocity = velocity
        """Its mean until the next period."""
        self.acceleration = STILL
        """Its change since the last period, per second."""
        self._next = position
        """Where the vehicle is to be in the next period."""
        # The carrot has moved at that velocity, so that the mean of its places is the position.
        self._carrot = position.plus(velocity.times(_DELAY))
        self._carrot_velocity = velocity
        self._x, self._y, self._z = (
            MovingAverage(at - speed * PERIOD * (SMOOTHING - 1 - k) for k in range(SMOOTHING))
            for at, speed in zip(self._carrot, velocity, strict=True)
        )
        self._periods = MovingAverage([PERIOD] * SMOOTHING)

    def progress(self) -> list[list[float]]:
        """Its state, as JSON: position, velocity, the carrot, and what its means are made of."""
        averages = self._x, self._y, self._z, self._periods
        points = self._next, self.velocity, self._carrot, self._carrot_velocity
        return [*map(list, points), *(average.progress() for average in averages)]

    @classmethod
    def resumed(cls, progress: Sequence[Sequence[float]]) -> Reference:
        """Continue from the progress of another reference."""
        place, velocity, carrot, carrot_velocity = (Point(*each) for each in progress[:4])
        reference = cls(place, velocity)
        reference._carrot, reference._carrot_velocity = carrot, carrot_velocity
        reference._x, reference._y, reference._z, reference._periods = map(
            MovingAverage.resumed, progress[4:]
        )
        return reference

    def step(self, target: Point, speed: float, vehicle: Observation, dt: float) -> None:
        """Move towards ``target`` for ``dt`` seconds, at ``speed`` m/s at most."""
        self.position = self._next
        self._move_carrot(target, speed, vehicle, dt)
        x, y, z = self._carrot
        along_x, along_y, along_z = self._x, self._y, self._z
        self._next = Point(along_x.push(x), along_y.push(y), along_z.push(z))
        per_second = 1 / (SMOOTHING * self._periods.push(dt))
        vx, vy, vz = self.velocity
        ux, uy, uz = (
            along_x.change * per_second,
            along_y.change * per_second,
            along_z.change * per_second,
        )
        self.acceleration = Point((ux - vx) / dt, (uy - vy) / dt, (uz - vz) / dt)
        self.velocity = Point(ux, uy, uz)

    def _move_carrot(self, target: Point, speed: float, vehicle: Observation, dt: float) -> None:
        x, y, z = self._carrot
        dx, dy, dz = target[0] - x, target[1] - y, target[2] - z
        left = sqrt(dx * dx + dy * dy + dz * dz)
        ux, uy, uz = (dx / left, dy / left, dz / left) if left > 1e-9 else STILL
        vx, vy, vz = self._carrot_velocity
        along = vx * ux + vy * uy + vz * uz
        vx, vy, vz = vx - along * ux, vy - along * uy, vz - along * uz
        across = sqrt(vx * vx + vy * vy + vz * vz)
        kept = 1 - ACCELERATION * dt / across if across > ACCELERATION * dt else 0.0

        most = acceleration_at(max(speed, abs(along)))
        lost = BRAKING * most * dt / 2
        wanted = min(speed, sqrt(lost * lost + 2 * BRAKING * most * left) - lost, left / dt)
        flown = vehicle.velocity
        follows = flown.x * ux + flown.y * uy + flown.z * uz
        lead = distance(self.position, vehicle.position)
        wanted = min(wanted, max(0.0, follows + (MAX_LEAD - lead) * CATCH_UP))
        # Motion across the line counts towards the speed asked for.
        wanted = min(wanted, sqrt(max(0.0, speed * speed - (across * kept) ** 2)))
        change, most = wanted - along, most * dt
        along += most if change > most else -most if change < -most else change

        vx, vy, vz = vx * kept + along * ux, vy * kept + along * uy, vz * kept + along * uz
        self._carrot_velocity = Point(vx, vy, vz)
        self._carrot = Point(x + vx * dt, y + vy * dt, z + vz * dt)

    def stop(self, vehicle: Observation, dt: float) -> None:
        """Slow down along the present direction of motion, and stay where that ends."""
        self.step(self._carrot, 0.0, vehicle, dt)

    def setpoint(self, yaw: float) -> Position:
        return Position(self.position, self.velocity, yaw, acceleration=self.acceleration)


def stopping_place(seen: Observation) -> Point:
    """Where a reference comes to rest that stops now."""
    speed = seen.velocity.norm()
    return seen.position.plus(seen.velocity.times(speed / (2 * ACCELERATION) + _DELAY))


def yaw_along(direction: Point, present_yaw: float) -> float:
    """The yaw of a nose along a direction, a unit vector; ``present_yaw`` where that is upright."""
    level = direction.x * direction.x + direction.y * direction.y
    return atan2(direction.y, direction.x) if level > _LEVEL else present_yaw


def yaw_towards(
    heading: Heading, here: Point, target: Point, start_yaw: float, present_yaw: float
) -> float:
    """The yaw that a heading asks for at the present position, radians.

    ``travel`` and ``face`` keep ``present_yaw``, the last one asked for, while the point they look
    at is nearer than MIN_TRAVEL.
    """
    if isinstance(heading, Face) or heading == "travel":
        ahead = heading.point if isinstance(heading, Face) else target
        near = horizontal_distance(here, ahead) < MIN_TRAVEL
        return present_yaw if near else bearing(here, ahead)
    if isinstance(heading, str):
        return start_yaw
    return wrap(heading)
