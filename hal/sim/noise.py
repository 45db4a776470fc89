"""Command noise: random velocity added to the commanded one."""

from __future__ import annotations

from random import Random

_DRIFT = 0.03
"""Largest drift per axis, m/s."""
_DRIFT_TIME = 200
"""Mission periods until the drift is drawn anew: 5 s."""
_SMALL = 0.05
"""Largest noise per axis and mission period, m/s."""


class CommandNoise:
    """Uniform drift, drawn every 5 s, plus uniform noise, drawn every mission period.

    The model and the figures of Gazebo's AR.Drone plugins (``motionDriftNoise``,
    ``motionDriftNoiseTime``, ``motionSmallNoise``).
    """

    def __init__(self, scale: float, random: Random) -> None:
        self._scale = scale
        self._random = random
        self._age = 0
        self._drift = (0.0, 0.0, 0.0)

    def next(self) -> tuple[float, float, float]:
        """The noise of the next mission period, m/s, world frame."""
        if not self._scale:
            return 0.0, 0.0, 0.0
        if self._age % _DRIFT_TIME == 0:
            self._drift = self._draw(_DRIFT)
        self._age += 1
        drift, small = self._drift, self._draw(_SMALL)
        return drift[0] + small[0], drift[1] + small[1], drift[2] + small[2]

    def _draw(self, most: float) -> tuple[float, float, float]:
        draw, most = self._random.uniform, most * self._scale
        return draw(-most, most), draw(-most, most), draw(-most, most)
