"""The search for a target that is not in sight: look about where it may be, then farther out."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, pi, sin

from behaviors.guidance import STILL
from behaviors.tracking_reference import Aim, TrackingReference
from vencejo.geometry import Point, distance, wrap

TURN_RATE = 0.9
"""Rate of the yaw while it looks about, rad/s: in a third of a second the view is another one."""
SWEEP = 6.0
"""Seconds for which it looks about a direction, ever farther to both sides, before all round."""
_SWEEP_BEGIN, _SWEEP_GROWTH, _SWEEP_RATE = 0.35, 0.35, 1.3
"""Half of the angle of that at first (rad), its growth (rad/s), and the angular frequency (1/s)."""
_STEP = 1.5
"""Height between two turns, metres."""
_RINGS = 6
"""Places on each ring."""
_THERE = 0.3
"""Distance at which a place counts as reached, metres."""


class TargetSearch:
    """One search, from the place where it begins."""

    def __init__(self, here: Point, yaw: float, least_height: float, reach: float) -> None:
        """``least_height``: above home, metres; ``reach``: how far from ``here`` it may fly."""
        self._places = _places(here, least_height, reach)
        self._place = next(self._places)
        self._yaw = yaw
        self._turned = 0.0

    def step(self, reference: TrackingReference, dt: float) -> Aim:
        """Turn, from place to place; each is left after a whole turn."""
        if distance(reference.place, self._place) < _THERE:
            self._turned += TURN_RATE * dt
            if self._turned >= 2 * pi:
                self._turned = 0.0
                self._place = next(self._places)
        self._yaw = wrap(self._yaw + TURN_RATE * dt)
        return Aim(self._place, STILL, STILL, self._yaw, TURN_RATE)


def sweep(bearing: float, since: float) -> tuple[float, float]:
    """The yaw (rad) and its rate (rad/s) for a look about a direction after ``since`` seconds."""
    width = min(pi, _SWEEP_BEGIN + _SWEEP_GROWTH * since)
    phase = _SWEEP_RATE * since
    return wrap(bearing + width * sin(phase)), width * _SWEEP_RATE * cos(phase)


def _places(here: Point, least_height: float, reach: float) -> Iterator[Point]:
    """Here, above, below, then ring by ring round it, up to ``reach`` and again; metres."""
    heights = [here.z, here.z + _STEP, max(least_height, here.z - _STEP)]
    while True:
        yield from (here._replace(z=height) for height in heights)
        rings = int(reach // 3.0)
        for ring in range(1, rings + 1):
            for k in range(_RINGS):
                angle = 2 * pi * k / _RINGS
                x, y = here.x + 3.0 * ring * cos(angle), here.y + 3.0 * ring * sin(angle)
                yield Point(x, y, heights[0])
