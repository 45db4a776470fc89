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
    """End the process where this ends, also when threads have been started that go on."""
    before = set(threading.enumerate())
    code: object = 0
    try:
        yield
    except SystemExit as stop:
        code = stop.code
        raise
    finally:
        if any(not thread.daemon for thread in set(threading.enumerate()) - before):
            leave(code if isinstance(code, int) else bool(code))
