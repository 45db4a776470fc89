"""Standard output and standard error, whose failures end no flight.

A full disk, a pipe whose reader has gone and an encoding without ``→`` belong to whoever reads, not
to the vehicle: what cannot be written is left out, and the command's exit code tells.
"""

from __future__ import annotations

import codecs
import errno
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from io import TextIOBase, TextIOWrapper
from pathlib import Path
from typing import Any, TextIO

import click

from vencejo.errors import OutputError, Where, cannot_write
from vencejo.files import write_whole

_GONE = (errno.EPIPE, errno.EIO, errno.ECONNRESET)
"""Errors of a stream that nobody reads any more: a closed pipe, terminal or connection."""
_PLAIN = {"→": "->", "✔": "ok", "✘": "failed", "×": "x", "—": "-", "–": "-", "…": "...", "·": "."}
"""Replacements for characters that the encoding of a stream lacks; others become ``?``."""
_REPLACE = "vencejo.plain"


def _replace(error: UnicodeError) -> tuple[str, int]:
    """An error handler for ``codecs`` that writes similar characters."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_PLAIN.get(character, "?") for character in lacking), error.end


codecs.register_error(_REPLACE, _replace)


class Output(TextIOBase):
    """A text stream that never raises: after its first failure it swallows what is written.

    Characters that its encoding lacks are replaced. None as ``stream`` (a descriptor that was
    closed before the program began) swallows everything, and that is no failure.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self._failure: OSError | None = None
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors=_REPLACE)

    @property
    def gone(self) -> bool:
        """True when nobody reads it any more: its pipe or terminal is closed."""
        return self._failure is not None and self._failure.errno in _GONE

    @property
    def lost(self) -> str:
        """The reason why it could not be written while somebody reads; empty for none."""
        if self._failure is None or self.gone:
            return ""
        return self._failure.strerror or str(self._failure)

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return getattr(self._stream, "encoding", None) or "utf-8"

    @property
    def unicode(self) -> bool:
        """True when it can show every character."""
        return codecs.lookup(self.encoding).name.startswith("utf")

    def write(self, text: str) -> int:
        if self._stream is not None and self._failure is None:
            try:
                self._stream.write(text)
            except (OSError, ValueError) as error:
                self._fail(error)
        return len(text)

    def flush(self) -> None:
        if self._stream is not None and self._failure is None:
            try:
                self._stream.flush()
            except (OSError, ValueError) as error:
                self._fail(error)

    def _fail(self, error: OSError | ValueError) -> None:
        # ValueError: somebody has closed the stream itself.
        closed = OSError(errno.EBADF, "it was closed")
        self._failure = error if isinstance(error, OSError) else closed
        # What is still buffered goes nowhere, so that the interpreter's end stays quiet.
        with suppress(OSError, ValueError, AttributeError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)

    def fileno(self) -> int:
        if self._stream is None:
            raise OSError(errno.EBADF, "it was closed")
        return self._stream.fileno()

    def isatty(self) -> bool:
        with suppress(ValueError):
            return self._stream is not None and self._stream.isatty()
        return False

    def writable(self) -> bool:
        return True


def written_code(code: int, out: TextIO | Output, err: TextIO | Output) -> int:
    """Flush both streams at the end of a command and tell whether the output could not be written.

    ``code`` is the exit code so far; where all went well it becomes that of OutputError.
    """
    out.flush()
    if isinstance(out, Output) and out.lost:
        message = f"the output could not be written: {out.lost}"
        err.write(f"{OutputError('output-lost', message)}\n")
    err.flush()
    lost = any(isinstance(stream, Output) and stream.lost for stream in (out, err))
    # What was found or flown stands in the other codes; these two say that all went well so far.
    return OutputError.exit_code if lost and code in (0, 1) else code


def write_file(path: Path, data: bytes | memoryview, hint: str | None = None) -> None:
    """Write a file that a person asked for, whole or not at all. Raises UserError."""
    try:
        write_whole(path, data)
    except OSError as error:
        message = "this file cannot be written"
        raise cannot_write(error, "cannot-write", message, Where(str(path)), hint) from None


def echo_json(
    value: object, *, indent: int | None = None, default: Callable[[Any], Any] | None = None
) -> None:
    """Print a value as JSON; nothing of it is replaced, whatever the encoding of the output.

    ``indent`` and ``default`` are those of ``json.dumps``.
    """
    import json  # late: most commands print none, and have a shorter start without it

    out: object = sys.stdout
    escaped = isinstance(out, Output) and not out.unicode
    click.echo(json.dumps(value, ensure_ascii=escaped, indent=indent, default=default))
