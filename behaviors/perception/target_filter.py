"""The track of one target: a Kalman filter of constant velocity in the world.

The state is position and velocity; the acceleration is white noise of a given strength (the
discrete white-noise acceleration model: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with
Applications to Tracking and Navigation", 2001, §6.3.2). Measurements are positions with their
covariances, at the times at which their pictures were taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hal.scene.arrays import Float64s
from vencejo.geometry import Point

GATE = 16.27
"""The squared Mahalanobis distance beyond which a measurement is not of the target: in three
dimensions it takes 99.9 % of those that are."""
REIDENTIFIED = 5
"""Measurements outside the gate that agree with each other, after which they are the target."""
_SPEED = 2.0
"""Standard deviation of the speed of a target seen for the first time, m/s."""


class TargetFilter:
    """Where a target is and how it moves, through occlusions; unknown before the first update."""

    def __init__(self, acceleration: float = 2.0, gate: float = GATE) -> None:
        """``acceleration``: the standard deviation of the target's, m/s²."""
        self._acceleration = acceleration
        self._gate = gate
        self._state: Float64s = np.zeros(6)
        self._covariance: Float64s = np.zeros((6, 6))
        self.time: float | None = None
        """The time of the last measurement taken; None before the first."""
        self._rival: TargetFilter | None = None
        """The track of the measurements outside the gate."""
        self._agreeing = 0
        """The number of measurements of the rival in a row."""

    @property
    def is_known(self) -> bool:
        return self.time is not None

    @property
    def velocity(self) -> Point:
        """At the last measurement, and since, m/s."""
        return Point(*map(float, self._state[3:]))

    def age(self, now: float) -> float:
        """Seconds since the last measurement; infinite before the first."""
        return np.inf if self.time is None else now - self.time

    def position_at(self, time: float) -> Point:
        """Where the target is at a time, if its velocity has not changed since it was seen."""
        ahead = 0.0 if self.time is None else time - self.time
        return Point(*map(float, self._state[:3] + ahead * self._state[3:]))

    def deviation_at(self, time: float) -> float:
        """The standard deviation of :meth:`position_at` along its least certain axis, metres."""
        _, covariance = self._predicted(time)
        return float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3])[-1]))

    @property
    def speed_deviation(self) -> float:
        """The standard deviation of the velocity at the last measurement, along its least certain
        axis, m/s.
        """
        return float(np.sqrt(np.linalg.eigvalsh(self._covariance[3:, 3:])[-1]))

    def distance(self, position: Sequence[float], covariance: Float64s, time: float) -> float:
        """The squared Mahalanobis distance of a measurement from where the target is expected."""
        state, expected = self._predicted(time)
        error = np.asarray(position) - state[:3]
        return float(error @ np.linalg.solve(expected[:3, :3] + covariance, error))

    def nearest(
        self, measured: Sequence[tuple[Sequence[float], Float64s]], time: float
    ) -> int | None:
        """The number of the measurement that is most likely the target; None where none may be.

        Each is a position and its covariance. Before the first update it is the first one.
        """
        if not measured or self.time is None:
            return 0 if measured else None
        far = [self.distance(position, covariance, time) for position, covariance in measured]
        best = int(np.argmin(far))
        return best if far[best] <= self._gate else None

    def update(self, position: Sequence[float], covariance: Float64s, time: float) -> bool:
        """Take a measurement with its covariance (3, 3), m²; False for one outside the gate.

        When REIDENTIFIED measurements outside the gate have followed each other that agree with
        one another, the target is where they are. One that is older than the last counts as of its
        time.
        """
        if self.time is None:
            self._begin(position, covariance, time)
            return True
        if self.distance(position, covariance, time) > self._gate:
            return self._taken_over(position, covariance, time)
        self._rival, self._agreeing = None, 0
        state, expected = self._predicted(time)
        gain = np.linalg.solve(expected[:3, :3] + covariance, expected[:3, :]).T
        self._state = state + gain @ (np.asarray(position) - state[:3])
        # Joseph's form keeps it symmetric and positive.
        rest = np.eye(6)
        rest[:, :3] -= gain
        self._covariance = rest @ expected @ rest.T + gain @ covariance @ gain.T
        self.time = max(time, self.time)
        return True

    def _begin(self, position: Sequence[float], covariance: Float64s, time: float) -> None:
        self._state = np.array([*position, 0.0, 0.0, 0.0], float)
        self._covariance = np.zeros((6, 6))
        self._covariance[:3, :3] = covariance
        self._covariance[3:, 3:] = np.eye(3) * _SPEED**2
        self.time = time

    def _taken_over(self, position: Sequence[float], covariance: Float64s, time: float) -> bool:
        """Follow what is outside the gate; True when that is the target now."""
        rival = self._rival
        if rival is None or rival.distance(position, covariance, time) > self._gate:
            rival = self._rival = TargetFilter(self._acceleration, self._gate)
            self._agreeing = 0
        rival.update(position, covariance, time)
        self._agreeing += 1
        if self._agreeing < REIDENTIFIED:
            return False
        self._state, self._covariance, self.time = rival._state, rival._covariance, rival.time
        self._rival, self._agreeing = None, 0
        return True

    def _predicted(self, time: float) -> tuple[Float64s, Float64s]:
        """State and covariance at a time, not before the last measurement's."""
        dt = 0.0 if self.time is None else max(0.0, time - self.time)
        step = np.eye(6)
        step[:3, 3:] = np.eye(3) * dt
        noise = np.zeros((6, 6))
        q = self._acceleration**2
        noise[:3, :3] = np.eye(3) * q * dt**4 / 4
        noise[:3, 3:] = noise[3:, :3] = np.eye(3) * q * dt**3 / 2
        noise[3:, 3:] = np.eye(3) * q * dt**2
        return step @ self._state, step @ self._covariance @ step.T + noise

    def progress(self) -> dict[str, Any]:
        """Its state, as JSON."""
        return {
            "time": self.time,
            "state": self._state.tolist(),
            "covariance": self._covariance.tolist(),
        }

    def go_on(self, progress: Mapping[str, Any]) -> None:
        """Continue from the progress of another filter."""
        self.time = progress["time"]
        self._state = np.array(progress["state"], float)
        self._covariance = np.array(progress["covariance"], float)
