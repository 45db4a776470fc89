"""Settings of this process that people's code may have changed, and that a flight depends on."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Mapping
from typing import Any, NamedTuple, Self

_SIGNALS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM")
    if hasattr(signal, name)
)
"""The signals by which a flight is stopped, and that of the limit on calls."""


class ProcessSettings(NamedTuple):
    """The handlers of signals, what traces and profiles, and how deep calls may go."""

    handlers: Mapping[int, Any]
    """Empty in a thread that may not set any."""
    trace: Any
    profile: Any
    recursion: int

    @classmethod
    def now(cls) -> Self:
        """The present settings."""
        main = threading.current_thread() is threading.main_thread()
        handlers = {number: signal.getsignal(number) for number in _SIGNALS if main}
        return cls(handlers, sys.gettrace(), sys.getprofile(), sys.getrecursionlimit())

    def restore(self) -> None:
        """Set again what has been changed since; calls may go deeper than before."""
        if sys.gettrace() is not self.trace:
            sys.settrace(self.trace)
        if sys.getprofile() is not self.profile:
            sys.setprofile(self.profile)
        if sys.getrecursionlimit() < self.recursion:
            sys.setrecursionlimit(self.recursion)
        for number, handler in self.handlers.items():
            if signal.getsignal(number) != handler:
                signal.signal(number, handler)
