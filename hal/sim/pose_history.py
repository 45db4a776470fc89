"""The poses of a vehicle at the last physics steps, for sensors that captured in the past."""

from __future__ import annotations

from collections import deque

from hal.sim.physics import STEPS_PER_SECOND, State
from vencejo.geometry import Point, Pose, product

LONGEST_INTERVAL = 1.0
"""Seconds: the slowest sensor captures this often."""
_KEPT = round(STEPS_PER_SECOND * LONGEST_INTERVAL) + 8


class PoseHistory:
    """The states of one vehicle's body after the last physics steps; the newest is now."""

    def __init__(self) -> None:
        self._states: deque[State] = deque(maxlen=_KEPT)
        self.append = self._states.append
        """Take in the state after a step."""

    def pose(self, steps_ago: int, offset: float = 0.0) -> Pose:
        """The body's pose some steps ago, world frame.

        ``offset`` moves on from there at the velocities of that step, seconds; below 0, back.
        """
        at, attitude, velocity, turning = self._states[-1 - steps_ago]
        if offset:
            at = Point(*at).plus((velocity[0] * offset, velocity[1] * offset, velocity[2] * offset))
            x, y, z = (rate * offset / 2 for rate in turning)
            # A small turn: its quaternion's length differs from 1 by less than a thousandth.
            attitude = product((x, y, z, 1.0), attitude)
            length = sum(part * part for part in attitude) ** 0.5
            qx, qy, qz, qw = attitude
            attitude = qx / length, qy / length, qz / length, qw / length
        return Point(*at), attitude
