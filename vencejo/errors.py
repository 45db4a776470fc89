"""Faults: each names a problem, its place in a file, and a remedy.

A mistake of the user raises :class:`UserError`; the command line prints its faults without a
traceback. A failure of the vehicle or its link raises :class:`VehicleError`. Any other exception is
a defect of the program.
"""

from __future__ import annotations

import errno
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal, Self

Severity = Literal["error", "warning"]


@dataclass(frozen=True, slots=True, order=True)
class Where:
    """A place in a file; line and column count from 1, a line of 0 means the file as a whole."""

    file: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}" if self.line else self.file

    def right(self, columns: int) -> Where:
        """The place ``columns`` further to the right in the same line."""
        return Where(self.file, self.line, self.column + columns)


@dataclass(frozen=True, slots=True)
class Fault:
    """One problem: a stable code, a sentence, and if known its place and a hint to the remedy."""

    code: str
    message: str
    where: Where | None = None
    hint: str | None = None
    severity: Severity = "error"

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        hint = f"\n  hint: {self.hint}" if self.hint else ""
        return f"{place}{self.severity}: {self.message} [{self.code}]{hint}"


class UserError(Exception):
    """One or more mistakes of the user. A command that raises it ends with ``exit_code``."""

    exit_code = 2

    def __init__(
        self, code: str, message: str, where: Where | None = None, hint: str | None = None
    ) -> None:
        self.faults: tuple[Fault, ...] = (Fault(code, message, where, hint),)
        super().__init__(message)

    @classmethod
    def of(cls, faults: Iterable[Fault]) -> Self:
        """One error with several faults; there must be one at least."""
        faults = tuple(faults)
        first = faults[0]
        error = cls(first.code, first.message, first.where, first.hint)
        error.faults = faults
        return error

    @property
    def code(self) -> str:
        return self.faults[0].code

    def __str__(self) -> str:
        return "\n".join(map(str, self.faults))


class VehicleError(UserError):
    """The vehicle, its simulator or the link to it failed."""

    exit_code = 3


class OutputError(UserError):
    """All went well, but the result could not be written: a full disk, for instance."""

    exit_code = 4


_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)


def cannot_write(
    error: OSError, code: str, message: str, where: Where | None = None, hint: str | None = None
) -> UserError:
    """The error to raise where a file could not be written; ``message`` gets the system's reason.

    It is an OutputError where the disk is to blame, else the place given is.
    """
    kind = OutputError if error.errno in _NO_ROOM else UserError
    return kind(code, f"{message}: {error.strerror or error}", where, hint)


class Stopped(BaseException):
    """The operator stops the program: all that guards people's code lets through.

    A command that it ends has this ``exit_code``.
    """

    exit_code = 130


def nearest(word: str, known: Iterable[str], otherwise: str | None = None) -> str | None:
    """A hint: the known word most similar to ``word``, or else ``otherwise``, or else a list.

    None when no word is known and there is no ``otherwise``.
    """
    options = sorted(set(known))
    close = get_close_matches(word, options, n=1, cutoff=0.6)
    if close:
        return f"did you mean '{close[0]}'?"
    if otherwise is not None:
        return otherwise
    if not options:
        return None
    listed = ", ".join(options[:12])
    return f"known: {listed}{', …' if len(options) > 12 else ''}"
