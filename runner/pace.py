"""Pacing: keeps a simulated flight at a speed people can follow. The only place that sleeps."""

from __future__ import annotations

import time
from collections.abc import Callable

NAP = 0.05
"""Longest sleep at once, seconds: a signal is answered within it."""


class Pace:
    """Waits until the wall clock has caught up with the vehicle's, at ``factor`` times its speed.

    A factor of None never waits.
    """

    def __init__(
        self,
        factor: float | None,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.factor = factor
        self._clock = clock
        self._sleep = sleep
        self._began: float | None = None

    def wait(self, now: float, interrupted: Callable[[], bool] = lambda: False) -> None:
        """Return when ``now`` seconds of the vehicle are due, or when interrupted."""
        if self.factor is None:
            return
        if self._began is None:
            self._began = self._clock() - now / self.factor
        due = self._began + now / self.factor
        while (left := due - self._clock()) > 0 and not interrupted():
            self._sleep(min(left, NAP))
