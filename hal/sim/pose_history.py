"""The poses of a vehicle at the last physics steps, for the capture times of its sensors."""

from __future__ import annotations

from collections import deque

from hal.sim.physics import STEPS_PER_SECOND, BodyState
from vencejo.geometry import Point, Pose, product

LONGEST_INTERVAL = 1.0
"""Longest interval between two captures of a sensor, seconds."""
_SPARE = 8
"""Physics steps that are kept besides."""


class PoseHistory:
    """The states of one vehicle's body after the last physics steps, the present one included."""

    def __init__(self, seconds: float) -> None:
        """``seconds``: for how long poses are kept; many are slow to walk through in memory."""
        kept = round(STEPS_PER_SECOND * seconds) + _SPARE
        self._states: deque[BodyState] = deque(maxlen=kept)
        self.append = self._states.append
        """Add the state after a physics step."""

    def pose(self, steps_ago: int, offset: float = 0.0) -> Pose:
        """The body's pose some physics steps ago, world frame.

        ``offset`` extrapolates from there by seconds, at the velocities of that step.
        """
        at, attitude, velocity, turning = self._states[-1 - steps_ago]
        if offset:
            at = Point(*at).plus((velocity[0] * offset, velocity[1] * offset, velocity[2] * offset))
            x, y, z = (rate * offset / 2 for rate in turning)
            # A small turn: its quaternion's length differs from 1 by less than a thousandth.
            attitude = product(attitude, (x, y, z, 1.0))
            length = sum(part * part for part in attitude) ** 0.5
            qx, qy, qz, qw = attitude
            attitude = qx / length, qy / length, qz / length, qw / length
        return Point(*at), attitude
