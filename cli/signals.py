"""Ctrl-C, SIGTERM and SIGHUP: once asks the mission, twice lands, thrice stops the program."""

from __future__ import annotations

import os
import signal
from types import FrameType, TracebackType

from cli.ending import leave
from vencejo.errors import Stopped

_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
LAST_WORDS = b"\nstopped; a vehicle in flight is left to its own failsafe\n"


class Interrupts:
    """Counts requests to stop while it is entered; the flight loop looks at ``count``.

    Ctrl-C adds one; SIGTERM and a closed terminal (SIGHUP) count as two. At ``last`` Stopped is
    raised wherever the program is. Should a person's code swallow even that, the next request ends
    the process at once.
    """

    def __init__(self, last: int = 3) -> None:
        self.count = 0
        self._last = last
        self._told = False
        """Whether Stopped has been raised."""
        self._before: dict[int, signal.Handlers] = {}

    def request(self, weight: int = 1) -> None:
        """Count a request to stop that came by other means than a signal."""
        self.count = self.count + 1 if weight == 1 else max(self.count + 1, weight)
        if self.count < self._last:
            return
        if self._told:
            os.write(2, LAST_WORDS)
            leave(Stopped.exit_code)
        self._told = True
        raise Stopped

    def __enter__(self) -> Interrupts:
        for number in _SIGNALS:
            self._before[number] = signal.signal(number, self._handle)  # type: ignore[assignment]
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.request(1 if number == signal.SIGINT else 2)
