"""Calls into people's code: behaviours, actions, and the files that they stand in.

Such code may raise anything, also what is no Exception (``sys.exit()``), and may never return. So
every call goes through :meth:`Calls.run`, which turns whatever is raised into :class:`CodeFailed`,
a sentence with the place in that person's file. How long a call has lasted is for the program at
the edge to look at (see :mod:`runner.call_limit`): no signal is set here.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Iterable
from pathlib import PurePath
from types import FrameType
from typing import Any, NamedTuple, TypeVar

from fsm.values.functions import EvaluationError
from vencejo.errors import Stopped, UserError, Where

T = TypeVar("T")
OURS = frozenset({"vencejo", "fsm", "behaviors", "hal", "worlds", "runner", "cli"})
"""The packages whose lines are no place in a person's file."""
CALLERS = frozenset(f"behaviors.{name}" for name in ("calls", "activity", "pilot", "registry"))
"""The modules that call people's code."""
MAX_TEXT = 500
"""Characters of an exception's own text that are told."""


class TookTooLong(BaseException):
    """A call lasts longer than it may: raised inside it, by whoever limits calls."""


class CodeFailed(Exception):
    """A person's code did not do what it was called for; the text says why and in which line."""

    def __init__(
        self, message: str, where: Where | None = None, cause: BaseException | None = None
    ) -> None:
        self.message = one_line(message)
        super().__init__(self.message + (f" ({where.file}:{where.line})" if where else ""))
        self.where = where
        """The line, in a file without its folder; None when it is not known."""
        self.cause = cause
        """The exception that its code raised; None for none."""


class Calls:
    """The calls into people's code of one program."""

    __slots__ = ("_clock", "_made", "began", "current")

    def __init__(self, clock: Callable[[], float] | None = None) -> None:
        """``clock`` gives seconds; without one it is not known how long a call lasts."""
        self._clock = clock or float
        self._made = 0
        self.current = 0
        """The number of the call under way; 0 between calls."""
        self.began = 0.0
        """When the present call began, by the clock."""

    def run(self, function: Callable[..., T], *arguments: Any) -> T:
        """Call a person's function. Raises CodeFailed, and nothing else but Stopped."""
        outer = self.current
        self.began = self._clock()
        self.current = self._made = self._made + 1
        # Signals are handled within calls and loops only: there is neither between the end of the
        # call and its being noted, so that nobody raises TookTooLong outside of this `try`.
        try:
            result = function(*arguments)
        except BaseException as error:
            self.current = outer
            raised = error
        else:
            self.current = outer
            return result
        raise self._failure(raised)

    def _failure(self, error: BaseException) -> BaseException:
        """What to raise instead of an exception of a person's code."""
        if isinstance(error, (Stopped, CodeFailed)):
            return error
        return CodeFailed(self.run(_told, error), _place_of_error(error), error)


def _told(error: BaseException) -> str:
    """An exception in one line. Asks the exception for its text, which is a person's code too."""
    if isinstance(error, UserError):
        return error.faults[0].message
    if isinstance(error, (EvaluationError, TookTooLong)):
        return str(error)
    name = type(error).__name__
    try:
        return f"{name}: {error}".removesuffix(": ")
    except Stopped:
        raise
    except BaseException:
        return name  # it cannot even tell itself


def one_line(text: str) -> str:
    """A text from elsewhere as part of a message: short, in one line, without control characters
    and half characters (lone surrogates), which no file takes.
    """
    shown = " ".join(text[: 2 * MAX_TEXT].encode("utf-8", "replace").decode().split())
    shown = "".join(letter if letter.isprintable() else "?" for letter in shown)
    return shown if len(shown) <= MAX_TEXT else shown[: MAX_TEXT - 1] + "…"


# -- places -------------------------------------------------------------------------------------


class _Line(NamedTuple):
    """A line of code under way."""

    file: str
    number: int
    module: str


def place_in(frame: FrameType | None) -> Where | None:
    """The line of a person's code that is under way in this frame or in those that called it."""
    lines = [_line(each, number) for each, number in traceback.walk_stack(frame)]
    return _place(reversed(lines))


def place_of_function(function: Any) -> Where | None:
    """The line in which a function or method is defined; None for what has no code."""
    code = getattr(function, "__code__", None)
    return Where(PurePath(code.co_filename).name, code.co_firstlineno) if code else None


def _place_of_error(error: BaseException) -> Where | None:
    """The line in which an exception was raised, or from which the call came that raised it."""
    if isinstance(error, EvaluationError):
        return None  # it tells of a value that the mission gave
    if isinstance(error, SyntaxError) and error.lineno and (error.filename or "<")[0] != "<":
        return Where(PurePath(str(error.filename)).name, error.lineno)
    lines = [_line(each, number) for each, number in traceback.walk_tb(error.__traceback__)]
    return _place(lines)


def _line(frame: FrameType, number: int | None) -> _Line:
    return _Line(frame.f_code.co_filename, number or 0, str(frame.f_globals.get("__name__")))


def _place(lines: Iterable[_Line]) -> Where | None:
    """The innermost line in a person's own file; in an installed behaviour, its own line."""
    called = [line for line in lines if line.module not in CALLERS and line.file[:1] != "<"]
    own = [line for line in called if _is_own(line)]
    if not own:
        own = [line for line in called if line.file == called[0].file]
    return Where(PurePath(own[-1].file).name, own[-1].number) if own else None


def _is_own(line: _Line) -> bool:
    """Whether a line stands in no package: neither ours, nor Python's, nor an installed one."""
    package = line.module.partition(".")[0]
    installed = {"site-packages", "dist-packages"} & set(PurePath(line.file).parts)
    return not (package in OURS or package in sys.stdlib_module_names or installed)
