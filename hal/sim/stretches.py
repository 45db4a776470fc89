"""The stretches of moving things' paths: straight, with a constant turn, of one mission period."""

from __future__ import annotations

from math import atan2, copysign, hypot

from hal.sim.physics import STEP, Triple
from vencejo.geometry import Pose, product
from worlds.motion import STRETCH

STRETCH_STEPS = round(STRETCH / STEP)
"""Physics steps of a stretch."""
STRETCH_TIME = STRETCH_STEPS * STEP
"""Seconds of a stretch."""


def velocities(begin: Pose, end: Pose, seconds: float) -> tuple[Triple, Triple]:
    """The velocity (m/s) and angular velocity (rad/s) that lead from one pose to another.

    World frame; it turns the shorter way.
    """
    (i, j, k, w), attitude = begin[1], end[1]
    way = end[0].minus(begin[0])
    turn = product(attitude, (-i, -j, -k, w))
    sine = hypot(*turn[:3])
    angle = 2 * atan2(sine, abs(turn[3]))
    per_second = 1 / seconds
    rate = copysign(angle / sine * per_second, turn[3]) if sine else 0.0
    return (
        (way.x * per_second, way.y * per_second, way.z * per_second),
        (turn[0] * rate, turn[1] * rate, turn[2] * rate),
    )
