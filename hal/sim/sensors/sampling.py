"""The capture times of a sensor, by its rate."""

from __future__ import annotations

from math import ceil, floor
from typing import NamedTuple

from hal.sim.physics import STEPS_PER_SECOND
from hal.sim.pose_history import LONGEST_INTERVAL

SLOWEST, FASTEST = 1 / LONGEST_INTERVAL, float(STEPS_PER_SECOND)
"""Captures per second: each needs a physics step of its own."""
_ROUNDING = 1e-9
"""Rounding errors of a number of steps are smaller than this."""


class Capture(NamedTuple):
    """One capture of a sensor."""

    sequence: int
    """Its number, from 0 at the beginning of the run."""
    step: int
    """Physics steps that had been made."""

    @property
    def time(self) -> float:
        """Seconds since the run began."""
        return self.step / STEPS_PER_SECOND


def newest_capture(rate: float, steps: int) -> Capture:
    """The newest capture of a sensor, once so many physics steps have been made.

    ``rate`` is in captures per second. A capture is made at the first step at or after its time.
    """
    interval = STEPS_PER_SECOND / rate
    sequence = floor(steps / interval + _ROUNDING)
    return Capture(sequence, ceil(sequence * interval - _ROUNDING))
