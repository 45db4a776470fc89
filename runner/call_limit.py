"""The limit on the wall time of one call into people's code, kept by a timer's signal.

While it is entered, a timer that repeats (``ITIMER_REAL``) sends SIGALRM; its handler looks at the
call that is under way, and costs nothing in between. In a call that lasts too long it raises
TookTooLong, at the line that is being run. Code that swallows this and goes on is given up: the
handler itself, which nothing can swallow, brings the program to its end.

A signal's handler runs between two steps of Python: a single call into a library that computes for
an hour without coming back is only ended when it returns. Without timers (on Windows), and in a
thread that is not the main one, there is no limit.
"""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any, NoReturn

from behaviors import Calls, CodeFailed, TookTooLong
from behaviors.calls import place_in
from runner.run_folder import Summary

CALL_LIMIT = 5.0
"""The usual limit, seconds of wall time."""
GRACE = 1.0
"""Seconds in which a call that was told to end may still clean up."""
LONGEST_TICK = 0.25
"""Seconds between two looks at the call under way, at most."""
_ROOM = 1000
"""Levels of recursion for bringing the program to its end, beside those the call has taken."""
_STOPPING = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""The signals by which a person stops the program."""


class CallLimit:
    """Limits calls into people's code while it is entered."""

    def __init__(
        self,
        seconds: float | None = CALL_LIMIT,
        give_up: Callable[[CodeFailed], NoReturn] | None = None,
    ) -> None:
        """``seconds``: None for no limit. ``give_up`` ends the program, called from within a call
        that goes on all the same; without it, the call is told to end again and again.
        """
        self.seconds = seconds
        self.calls = Calls(time.monotonic)
        self.land: Callable[[str], Summary] | None = None
        """In flight: ends all missions for a reason, lands the vehicles, and gives the summary;
        nothing of the flight may go on afterwards. None before and after."""
        self._give_up = give_up
        self._is_given_up = False
        self._tick = 0.0
        """Seconds between two looks; 0 while there is no timer."""
        self._before: Any = None
        self._kept: dict[int, Any] = {}

    def __enter__(self) -> CallLimit:
        main = threading.current_thread() is threading.main_thread()
        if self.seconds is not None and main and hasattr(signal, "setitimer"):
            self._tick = min(self.seconds / 10, LONGEST_TICK)
            self._before = signal.signal(signal.SIGALRM, self._look)
            signal.setitimer(signal.ITIMER_REAL, self._tick, self._tick)
        return self

    def __exit__(self, *exc: object) -> None:
        if self._tick:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, self._before)
            self._tick = 0.0

    def keep_handlers(self) -> None:
        """Remember who handles the signals now; see :meth:`restore_handlers`."""
        if threading.current_thread() is threading.main_thread():
            kept = (*_STOPPING, signal.SIGALRM) if self._tick else _STOPPING
            self._kept = {number: signal.getsignal(number) for number in kept}

    def restore_handlers(self) -> None:
        """Undo what a person's code has done to signals: it must stay possible to end it."""
        for number, handler in self._kept.items():
            if signal.getsignal(number) != handler:
                signal.signal(number, handler)
        if self._tick and signal.getitimer(signal.ITIMER_REAL)[1] == 0.0:
            signal.setitimer(signal.ITIMER_REAL, self._tick, self._tick)

    def _look(self, number: int, frame: FrameType | None) -> None:
        """End the call under way if it lasts too long."""
        calls = self.calls
        if not calls.current or self._is_given_up or self.seconds is None:
            return
        beyond = time.monotonic() - calls.began - self.seconds
        if beyond < 0:
            return
        message = f"the call took longer than {self.seconds:g} s (--call-limit)"
        if beyond < GRACE or self._give_up is None:
            raise TookTooLong(message)
        self._is_given_up = True
        sys.setrecursionlimit(sys.getrecursionlimit() + _ROOM)
        message = message.replace("(", "and could not be ended (")
        self._give_up(CodeFailed(message, place_in(frame)))
