"""Faults: each names a problem, its place in a file, and a remedy.

A mistake of the user raises :class:`UserError`; the command line prints its faults without a
traceback. A failure of the vehicle or its link raises :class:`VehicleError`. Any other exception is
a defect of the program.
"""

from __future__ import annotations

import errno
from bisect import bisect
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher, get_close_matches
from functools import lru_cache
from heapq import nlargest
from pathlib import Path
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
    return kind(code, f"{message}: {reason_of(error)}", where, hint)


def reason_of(error: OSError) -> str:
    """The system's reason; or that there is no working directory any more, where that is it."""
    if error.errno == errno.ENOENT:
        try:
            Path.cwd()
        except FileNotFoundError:
            return "the folder you are in has been deleted"
    return error.strerror or str(error)


class Stopped(BaseException):
    """The operator stops the program: all that guards people's code lets through.

    A command that it ends has this ``exit_code``.
    """

    exit_code = 130


class Correction(str):
    """A hint that names the text to write, ``right``, in place of another one, ``wrong``.

    It is given only where that is certain; ``wrong`` stands in the line of the fault.
    """

    wrong: str
    right: str

    def __new__(cls, wrong: str, right: str, hint: str | None = None) -> Self:
        made = super().__new__(cls, hint or f"did you mean '{right}'?")
        made.wrong, made.right = wrong, right
        return made

    def __reduce__(self) -> tuple[type[Correction], tuple[str, str, str]]:
        return Correction, (self.wrong, self.right, str(self))


_CERTAIN, _APART = 0.75, 0.05
"""Least similarity of a word to the one that was certainly meant, and what others have less."""
_ALL_COMPARED = 100
"""Number of known words up to which a wrong one is compared with them all."""


def certain(word: str, known: Iterable[str]) -> str | None:
    """The known word that was certainly meant: similar, and more so than every other one.

    None among very many, since comparing them all would take long.
    """
    options = {*known}
    if len(options) > _ALL_COMPARED:
        return None
    alike = SequenceMatcher(b=word)
    ratios = []
    for other in options:
        alike.set_seq1(other)
        ratios.append((alike.ratio(), other))
    (best, found), (second, _) = sorted([*ratios, (0.0, ""), (0.0, "")], reverse=True)[:2]
    return found if best >= max(_CERTAIN, second + _APART) else None


def nearest(word: str, known: Iterable[str], otherwise: str | None = None) -> str | None:
    """A hint: the known word most similar to ``word``, or else ``otherwise``, or else a list.

    None when no word is known and there is no ``otherwise``; a Correction where it is certain.
    """
    options = sorted(set(known))
    alike = _of_like_letters(word, options)
    meant = certain(word, alike) if len(options) <= _ALL_COMPARED else None
    if meant is not None:
        return Correction(word, meant)
    close = get_close_matches(word, alike, n=1, cutoff=0.6)
    if close:
        return f"did you mean '{close[0]}'?"
    if otherwise is not None:
        return otherwise
    if not options:
        return None
    listed = ", ".join(options[:12])
    return f"known: {listed}{', …' if len(options) > 12 else ''}"


def _of_like_letters(word: str, options: Sequence[str]) -> list[str]:
    """The few options whose letters are most like those of a word; of very many, only those around
    it in the alphabet. A file may have thousands of wrong words, and comparing them in earnest with
    all others would take minutes.
    """
    at, letters = bisect(options, word), _letters(word)
    if len(options) > _ALL_COMPARED:
        options = options[max(0, at - _ALL_COMPARED // 2) : at + _ALL_COMPARED // 2]

    def likeness(option: str) -> float:
        others = _letters(option)
        return len(letters & others) / (1 + len(letters) + len(others))

    return nlargest(5, options, likeness)


@lru_cache(1000)
def _letters(word: str) -> frozenset[str]:
    return frozenset(word)
