"""Command noise: random velocity and turn rate added to the commanded ones."""

from __future__ import annotations

from random import Random

_DRIFT = 0.03
"""Largest drift per axis, m/s; of the turn rate, rad/s."""
_DRIFT_TIME = 200
"""Mission periods until the drift is drawn anew: 5 s."""
_SMALL = 0.05
"""Largest noise per axis and mission period, m/s; of the turn rate, rad/s."""
Noise = tuple[float, float, float, float]
"""Of the velocity along x, y and z, m/s, and of the turn rate, rad/s, in the command's own frame:
that of the heading for what is commanded in it, else the world's."""
NO_NOISE: Noise = (0.0, 0.0, 0.0, 0.0)


class CommandNoise:
    """Uniform drift, drawn every 5 s, plus uniform noise, drawn every mission period.

    The model, its four axes and the figures of Gazebo's AR.Drone plugins (``motionDriftNoise``,
    ``motionDriftNoiseTime``, ``motionSmallNoise``); there small noise comes with each command, here
    with each mission period.
    """

    def __init__(self, scale: float, random: Random) -> None:
        self._scale = scale
        self._random = random
        self._age = 0
        self._drift = NO_NOISE

    def next(self) -> Noise:
        """The noise of the next mission period."""
        if not self._scale:
            return NO_NOISE
        if self._age % _DRIFT_TIME == 0:
            self._drift = self._draw(_DRIFT)
        self._age += 1
        a, b, c, d = self._drift
        x, y, z, turn = self._draw(_SMALL)
        return a + x, b + y, c + z, d + turn

    def _draw(self, most: float) -> Noise:
        draw, most = self._random.uniform, most * self._scale
        return draw(-most, most), draw(-most, most), draw(-most, most), draw(-most, most)
