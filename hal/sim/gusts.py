"""Gusts: the wind rises along a cosine and falls again, and travels with the mean wind."""

from __future__ import annotations

from bisect import bisect_right
from math import cos, pi
from random import Random

from worlds.world import Gusts

_BEFORE = 300.0
"""Random gusts begin that long before the run, so that places down the wind have some too."""


class GustTrain:
    """The gusts of a world: each takes the same time at each place that it passes.

    The share of a gust is (1 − cos 2πt/T)/2 for 0 ≤ t ≤ T, T its duration: the rise of the discrete
    gust of MIL-F-8785C (3.7) and its fall back, together the gust of CS 25.341.
    """

    def __init__(self, gusts: Gusts, random: Random) -> None:
        self._gusts = gusts
        self._random = random
        self._begins = list(gusts.at) if gusts.at else [-_BEFORE + random.uniform(0.0, gusts.every)]

    def share(self, time: float) -> float:
        """How far the wind has risen, 0 to 1.

        ``time`` is that at which the air, which travels with the mean wind, is at the origin,
        seconds of the session's clock.
        """
        begins, duration = self._begins, self._gusts.duration
        if not self._gusts.at:
            while begins[-1] <= time:
                pause = self._random.expovariate(1.0 / (self._gusts.every - duration))
                begins.append(begins[-1] + duration + pause)
        number = bisect_right(begins, time)
        since = time - begins[number - 1] if number else duration
        return 0.0 if since >= duration else (1.0 - cos(2.0 * pi * since / duration)) / 2.0
