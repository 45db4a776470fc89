"""Ctrl-C, SIGTERM and SIGHUP: once asks the mission, twice lands, thrice stops the program."""

from __future__ import annotations

import signal
from types import FrameType, TracebackType


class Interrupts:
    """Counts requests to stop while it is entered; the flight loop looks at ``count``.

    Ctrl-C adds one; SIGTERM and a closed terminal (SIGHUP) count as two. At three KeyboardInterrupt
    is raised wherever the program is.
    """

    def __init__(self) -> None:
        self.count = 0
        self._before: dict[int, signal.Handlers] = {}

    def request(self, weight: int = 1) -> None:
        """Count a request to stop that came by other means than a signal."""
        self.count = self.count + 1 if weight == 1 else max(self.count + 1, weight)
        if self.count >= 3:
            raise KeyboardInterrupt

    def __enter__(self) -> Interrupts:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
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
