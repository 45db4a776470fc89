"""Guidance: a reference that moves smoothly to a target, for the vehicle to follow.

The reference is a point with a velocity. It accelerates towards the target at a limited rate and
brakes in time, so that the vehicle's position control, fed both, neither lags nor overshoots.
"""

from __future__ import annotations

from math import sqrt

from behaviors.params import Face, Heading
from hal.vehicle import Position
from vencejo.geometry import Point, bearing, distance, horizontal_distance, wrap

ACCELERATION = 2.0
"""How fast the reference changes its velocity, m/s²."""
BRAKING = 1.2
"""The deceleration it plans its stop with, m/s²; below ACCELERATION, so that it can keep it."""
LEASH = 0.6
"""How far the reference may run ahead of the vehicle, metres."""
MIN_TRAVEL = 0.3
"""Over less ground than this, ``travel`` keeps the heading: the direction means nothing there."""


class Reference:
    """A moving reference point, mission frame."""

    def __init__(self, position: Point, velocity: Point) -> None:
        self.position = position
        self.velocity = velocity

    def step(self, target: Point, speed: float, vehicle: Point, dt: float) -> None:
        """Move on by ``dt`` seconds towards ``target`` at up to ``speed`` m/s.

        Waits when the vehicle falls back, so that a vehicle that is held up is not overwhelmed.
        """
        dx, dy, dz = target.minus(self.position)
        left = sqrt(dx * dx + dy * dy + dz * dz)
        lead = distance(self.position, vehicle)
        # v² = 2·a·s, less the way of one period so that the stop is not overrun.
        wanted = min(speed, sqrt(2 * BRAKING * left)) if left > 1e-9 else 0.0
        if lead > LEASH:
            wanted *= max(0.0, 1 - (lead - LEASH) / LEASH)
        scale = wanted / left if left > 1e-9 else 0.0
        vx, vy, vz = self.velocity
        ax, ay, az = dx * scale - vx, dy * scale - vy, dz * scale - vz
        change = sqrt(ax * ax + ay * ay + az * az)
        most = ACCELERATION * dt
        if change > most:
            ax, ay, az = ax * most / change, ay * most / change, az * most / change
        vx, vy, vz = vx + ax, vy + ay, vz + az
        if left <= sqrt(vx * vx + vy * vy + vz * vz) * dt or left < 1e-3:
            self.position, self.velocity = target, Point(0.0, 0.0, 0.0)
            return
        x, y, z = self.position
        self.position = Point(x + vx * dt, y + vy * dt, z + vz * dt)
        self.velocity = Point(vx, vy, vz)

    def setpoint(self, yaw: float) -> Position:
        return Position(self.position, self.velocity, yaw)


def yaw_towards(
    heading: Heading, here: Point, target: Point, start_yaw: float, present_yaw: float
) -> float:
    """The yaw that a heading asks for just now, radians.

    ``travel`` looks along the way while there is some left, then keeps what it has.
    """
    if isinstance(heading, Face):
        near = horizontal_distance(here, heading.point) < MIN_TRAVEL
        return present_yaw if near else bearing(here, heading.point)
    if heading == "travel":
        far = horizontal_distance(here, target) > MIN_TRAVEL
        return bearing(here, target) if far else present_yaw
    if isinstance(heading, str):
        return start_yaw
    return wrap(heading)
