"""Faults: what is wrong, where, and what to do about it.

A mistake of the person who uses the tool is a :class:`UserError`; the command line prints its
faults and never a traceback. Everything else that is raised is a mistake of ours.
"""

from __future__ import annotations

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
        """The place some columns further on in the same line."""
        return Where(self.file, self.line, self.column + columns)


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong: a stable code, a sentence, a place and the way out."""

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
    """One or more faults in what a person wrote. Ends a command with ``exit_code``."""

    exit_code = 2

    def __init__(
        self, code: str, message: str, where: Where | None = None, hint: str | None = None
    ) -> None:
        self.faults: tuple[Fault, ...] = (Fault(code, message, where, hint),)
        super().__init__(message)

    @classmethod
    def of(cls, faults: Iterable[Fault]) -> Self:
        """One error that carries several faults."""
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
    """The vehicle, its simulator or the link to it failed: no fault of the mission."""

    exit_code = 3


def nearest(word: str, known: Iterable[str], otherwise: str | None = None) -> str | None:
    """A hint that names the known word most like ``word``, or else lists the few there are."""
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
