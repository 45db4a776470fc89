"""How near the vehicles of a run come to each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import inf, sqrt
from typing import NamedTuple

from vencejo.geometry import Point


class Nearest(NamedTuple):
    """The least distance of two vehicles while at least one of them was off the ground."""

    vehicles: tuple[str, str]
    distance: float
    """Metres, between the vehicles' own places."""
    time: float
    """Seconds of the session's clock."""


class Separation:
    """The least distance between each two vehicles."""

    def __init__(self, names: Sequence[str]) -> None:
        self._pairs = list(combinations(names, 2))
        self._least = [inf] * len(self._pairs)
        """Squared, in the order of the pairs: there are many, in every period."""
        self._times = [0.0] * len(self._pairs)

    def update(self, time: float, places: Sequence[Point], flying: Sequence[bool]) -> None:
        """The vehicles are at these places of the world frame, metres, on the ground or not."""
        least, pair = self._least, 0
        for first, ((x, y, z), aloft) in enumerate(zip(places, flying, strict=True), 1):
            for other in range(first, len(places)):
                if aloft or flying[other]:
                    u, v, w = places[other]
                    squared = (x - u) * (x - u) + (y - v) * (y - v) + (z - w) * (z - w)
                    if squared < least[pair]:
                        least[pair], self._times[pair] = squared, time
                pair += 1

    def nearest(self) -> tuple[Nearest, ...]:
        """Of each pair of which one has flown, in the order of the vehicles."""
        found = zip(self._pairs, self._least, self._times, strict=True)
        return tuple(Nearest(p, sqrt(squared), t) for p, squared, t in found if squared < inf)
