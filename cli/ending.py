"""The end of the process: nothing that people's code leaves behind keeps it alive."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn


def leave(code: int) -> NoReturn:
    """End the process at once, whatever still runs in it; what was written is flushed."""
    for stream in (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__):
        with suppress(Exception):
            if stream is not None:
                stream.flush()
    os._exit(code)


@contextmanager
def not_kept_alive() -> Iterator[None]:
    """End the process where this ends, also when threads or processes have been started that go on.

    Python would wait for them.
    """
    before = _at_work()
    code: object = 0
    try:
        yield
    except SystemExit as stop:
        code = stop.code
        raise
    finally:
        if _at_work() - before:
            leave(code if isinstance(code, int) else bool(code))


def _at_work() -> set[object]:
    """The threads and child processes for which Python waits at its end."""
    threads = {thread for thread in threading.enumerate() if not thread.daemon}
    multiprocessing = sys.modules.get("multiprocessing")
    children = multiprocessing.active_children() if multiprocessing else ()
    return {*threads, *(child for child in children if not child.daemon)}
