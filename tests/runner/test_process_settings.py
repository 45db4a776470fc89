"""What people's code does to its process ends with it."""

from __future__ import annotations

import signal
import sys
import threading

from runner.process_settings import ProcessSettings


def test_what_was_changed_is_set_again() -> None:
    before = ProcessSettings.now()
    try:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGALRM):
            signal.signal(number, signal.SIG_IGN)
        sys.setrecursionlimit(before.recursion - 100)
        sys.setprofile(lambda *_: None)
    finally:
        before.restore()
    assert ProcessSettings.now() == before


def test_calls_may_go_deeper_than_before() -> None:
    before = ProcessSettings.now()
    sys.setrecursionlimit(before.recursion + 100)
    before.restore()
    try:
        assert sys.getrecursionlimit() == before.recursion + 100
    finally:
        sys.setrecursionlimit(before.recursion)


def test_another_thread_leaves_signals_alone() -> None:
    found: list[ProcessSettings] = []
    thread = threading.Thread(target=lambda: found.append(ProcessSettings.now()))
    thread.start()
    thread.join()
    (settings,) = found
    assert not settings.handlers
    settings.restore()
