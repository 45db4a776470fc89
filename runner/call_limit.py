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
from typing import TYPE_CHECKING, Any, NoReturn

from behaviors import Calls, CodeFailed, TookTooLong
from behaviors.calls import place_in

if TYPE_CHECKING:
    # Commands that fly nothing do without what only flights need.
    from runner.run_folder import Summary

CALL_LIMIT = 5.0
"""The usual limit, seconds of wall time."""
GRACE = 1.0
"""Seconds in which a call that was told to end may still clean up."""
LONGEST_TICK = 0.25
"""Seconds between two looks at the call under way, at most."""
_ROOM = 1000
"""Levels of recursion for bringing the program to its end, beside those the call has taken."""


class CallLimit:
    """Limits calls into people's code while it is entered."""

    def __init__(
        self,
        seconds: float | None = CALL_LIMIT,
        give_up: Callable[[CodeFailed], NoReturn] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """``seconds``: None for no limit. ``give_up`` ends the program, called from within a call
        that goes on all the same; without it, the call is told to end again and again. ``clock``
        gives seconds.
        """
        self.seconds = seconds
        self.calls = Calls(clock)
        self._clock = clock
        self.land: Callable[[str], Summary] | None = None
        """In flight: ends all missions for a reason, lands the vehicles, and gives the summary;
        nothing of the flight may go on afterwards. None before and after."""
        self._give_up = give_up
        self._told = 0, 0.0
        """The last call that was told to end, and since when it has been, by the clock."""
        self._is_given_up = False
        self._tick = 0.0
        """Seconds between two looks; 0 while there is no timer."""
        self._before: Any = None
        """The handler and the timer that were set before."""

    def __enter__(self) -> CallLimit:
        main = threading.current_thread() is threading.main_thread()
        if self.seconds is not None and main and hasattr(signal, "setitimer"):
            self._tick = min(self.seconds / 10, LONGEST_TICK)
            handler = signal.signal(signal.SIGALRM, self._ring)
            timer = signal.setitimer(signal.ITIMER_REAL, self._tick, self._tick)
            self._before = handler, timer
        return self

    def __exit__(self, *exc: object) -> None:
        if self._tick:
            self._tick = 0.0
            handler, timer = self._before
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, handler)
            signal.setitimer(signal.ITIMER_REAL, *timer)

    def renew(self) -> None:
        """Set the timer again, should a person's code have stopped it."""
        if self._tick and signal.getitimer(signal.ITIMER_REAL)[1] == 0.0:
            signal.setitimer(signal.ITIMER_REAL, self._tick, self._tick)

    def _ring(self, number: int, frame: FrameType | None) -> None:
        self.look(frame)

    def look(self, frame: FrameType | None) -> None:
        """End the call under way if it lasts too long: what the timer does. ``frame`` is where it
        is.
        """
        calls, now = self.calls, self._clock()
        if not calls.current or self._is_given_up or self.seconds is None:
            return
        if now - calls.began < self.seconds:
            return
        call, since = self._told
        if call != calls.current:
            call, since = self._told = calls.current, now
        took = f"the call took longer than {self.seconds:g} s"
        if now - since < GRACE or self._give_up is None:
            raise TookTooLong(f"{took} (--call-limit)")
        self._is_given_up = True
        sys.setrecursionlimit(sys.getrecursionlimit() + _ROOM)
        self._give_up(CodeFailed(f"{took} and could not be ended (--call-limit)", place_in(frame)))
