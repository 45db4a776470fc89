"""People's code inside a command: limited in time, without a terminal, and never in the way.

What it prints goes to standard error, so that standard output holds what the command says, and JSON
stays JSON. It cannot read from the terminal. What it does to the streams, to signals and to the
working directory ends with it.
"""

from __future__ import annotations

import io
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NoReturn

import click

from behaviors import CodeFailed
from cli.ending import leave
from cli.signals import LAST_WORDS, Interrupts
from runner.call_limit import CallLimit
from runner.process_settings import ProcessSettings
from vencejo.errors import Stopped, UserError, Where

if TYPE_CHECKING:
    # Commands that fly nothing do without what only flights need.
    from runner.run_folder import Summary


@contextmanager
def user_code(
    seconds: float | None, landed: Callable[[Summary], int] | None = None
) -> Iterator[CallLimit]:
    """Run people's code inside this: ``seconds`` is the limit on one call, None for none.

    Where a call cannot be ended the program is: at once, or in flight when all vehicles are down;
    ``landed`` is then given the summary, and gives the exit code.
    """

    def give_up(failure: CodeFailed) -> NoReturn:
        code = UserError.exit_code
        try:
            if limit.land is None or landed is None:
                place = failure.where and Where(failure.where.file, failure.where.line, 1)
                raise UserError("broken-code", failure.message, place)
            code = landed(limit.land(str(failure)))
        except UserError as error:
            click.echo(str(error), err=True)
            code = error.exit_code
        except Stopped:
            os.write(2, LAST_WORDS)
            code = Stopped.exit_code
        except Exception:
            code = 1
            sys.excepthook(*sys.exc_info())
        finally:
            leave(code)

    limit = CallLimit(seconds, give_up)
    with Interrupts(last=1), limit, _apart():
        yield limit


@contextmanager
def _apart() -> Iterator[None]:
    """Give people's code streams of its own, and come back to the working directory.

    Threads that it leaves behind keep them.
    """
    stdin, stdout, stderr = sys.stdin, sys.stdout, sys.stderr
    before = set(threading.enumerate())
    folder: Path | None = None
    with suppress(OSError):  # it may have been removed
        folder = Path.cwd()
    settings = ProcessSettings.now()
    aside = _Aside(stderr)
    sys.stdin, sys.stdout, sys.stderr = _NoInput(), aside, _Aside(stderr)
    try:
        yield
    finally:
        settings.restore()
        left = set(threading.enumerate()) - before
        sys.stdin, sys.stderr = stdin, stderr
        sys.stdout = _Aside(stderr, main=stdout) if left else stdout
        if threading.active_count() > 1:
            _IN_USE.append(aside)
        with suppress(OSError):
            os.chdir(folder or os.curdir)


_IN_USE: list[object] = []
"""Streams that threads may be printing to: Python's ``print`` does not keep them itself."""


class _NoInput(io.TextIOBase):
    """A standard input from which nothing can be read."""

    def readable(self) -> bool:
        return True

    def read(self, size: int | None = -1) -> str:
        raise EOFError("there is no terminal to read from: give values by parameters (-p)")

    def readline(self, size: int = -1) -> str:  # type: ignore[override]
        return self.read()


class _Aside(io.TextIOBase):
    """Another stream, which does not end when this one is closed."""

    def __init__(self, stream: IO[str], main: IO[str] | None = None) -> None:
        """``main``: the stream for what the main thread writes, by default the same."""
        self._others: Any = stream
        self._main: Any = main or stream

    @property
    def _stream(self) -> Any:
        is_main = threading.current_thread() is threading.main_thread()
        return self._main if is_main else self._others

    def __getattr__(self, name: str) -> Any:
        """What makes it a stream of files: ``buffer``, for instance."""
        return getattr(self._stream, name)

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return str(self._stream.encoding)

    def writable(self) -> bool:
        return True

    def write(self, text: str) -> int:
        return int(self._stream.write(text))

    def flush(self) -> None:
        with suppress(ValueError):
            self._stream.flush()

    def fileno(self) -> int:
        return int(self._stream.fileno())

    def isatty(self) -> bool:
        return bool(self._stream.isatty())

    def close(self) -> None:
        """Leave the other stream open."""
