"""Guidance: a reference that moves smoothly to a target, for the vehicle to follow.

The reference is a point with a velocity. In each period of length dt it wants to move straight at
its target with the least of

- the speed that was asked for,
- √((b·dt/2)² + 2·b·s) − b·dt/2: the speed from which it stops within the way s that is left,
  when it slows down by b·dt each period (v² = 2·b·s, less what it moves during a period),
- s/dt: what takes it there in this period,
- u + (MAX_LEAD − l)·CATCH_UP, where u is the vehicle's speed along the line and l its distance
  from the reference: the reference waits for a vehicle that is slow or held up. (MAX_LEAD is the
  leash length of ArduPilot's ``AC_WPNav``.)

It nears that speed by ACCELERATION·dt at most, and at the same rate loses what moves it across
that line, so that it comes onto its line soon, whatever it did before. The planned deceleration b
stays below ACCELERATION, to have some left when the target or the speed changes on the way. (The
stopping law is that of the square-root controller in ArduPilot's ``AC_PosControl``.) The vehicle
is given both place and velocity, and so neither lags behind nor overshoots.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from behaviors.params import Face, Heading
from hal.vehicle import Observation, Position
from vencejo.geometry import Point, bearing, distance, horizontal_distance, wrap

ACCELERATION = 2.0
"""Acceleration of the reference along its line, and across it, m/s²."""
BRAKING = 1.2
"""Deceleration with which the reference plans its stop, m/s²."""
MAX_LEAD = 0.6
"""Distance from the reference at which a vehicle that cannot follow is waited for, metres."""
CATCH_UP = 1.0
"""Gain from the missing lead to speed, 1/s: low enough for ACCELERATION, so that it settles."""
MIN_TRAVEL = 0.3
"""Distance over the ground below which a direction is not defined and the heading kept, metres."""
NEARBY = 1.0
"""An interrupted behaviour continues if the vehicle is at most this far from there, metres."""
STILL = Point(0.0, 0.0, 0.0)


class Reference:
    """A moving reference point, mission frame."""

    def __init__(self, position: Point, velocity: Point) -> None:
        self.position = position
        self.velocity = velocity

    def progress(self) -> list[float]:
        """Position and velocity, as JSON: six numbers."""
        return [*self.position, *self.velocity]

    @classmethod
    def resumed(cls, progress: Sequence[float]) -> Reference:
        """Continue from the progress of another reference."""
        return cls(Point(*progress[:3]), Point(*progress[3:]))

    def step(self, target: Point, speed: float, vehicle: Observation, dt: float) -> None:
        """Move towards ``target`` for ``dt`` seconds, at ``speed`` m/s at most."""
        x, y, z = self.position
        dx, dy, dz = target[0] - x, target[1] - y, target[2] - z
        left = sqrt(dx * dx + dy * dy + dz * dz)
        ux, uy, uz = (dx / left, dy / left, dz / left) if left > 1e-9 else STILL
        vx, vy, vz = self.velocity
        along = vx * ux + vy * uy + vz * uz
        vx, vy, vz = vx - along * ux, vy - along * uy, vz - along * uz
        across = sqrt(vx * vx + vy * vy + vz * vz)
        kept = max(0.0, 1 - ACCELERATION * dt / across) if across else 0.0

        lost = BRAKING * dt / 2
        wanted = min(speed, sqrt(lost * lost + 2 * BRAKING * left) - lost, left / dt)
        flown = vehicle.velocity
        follows = flown.x * ux + flown.y * uy + flown.z * uz
        lead = distance(self.position, vehicle.position)
        wanted = min(wanted, max(0.0, follows + (MAX_LEAD - lead) * CATCH_UP))
        # Motion across the line counts towards the speed asked for.
        wanted = min(wanted, sqrt(max(0.0, speed * speed - (across * kept) ** 2)))
        along += max(-ACCELERATION * dt, min(ACCELERATION * dt, wanted - along))

        vx, vy, vz = vx * kept + along * ux, vy * kept + along * uy, vz * kept + along * uz
        self.velocity = Point(vx, vy, vz)
        self.position = Point(x + vx * dt, y + vy * dt, z + vz * dt)

    def stop(self, vehicle: Observation, dt: float) -> None:
        """Slow down along the present direction of motion, and stay where that ends."""
        self.step(self.position, 0.0, vehicle, dt)

    def setpoint(self, yaw: float) -> Position:
        return Position(self.position, self.velocity, yaw)


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
