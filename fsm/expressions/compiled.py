"""Expressions: a safe subset of Python with units, parsed, typed and compiled on load.

The user's text is parsed to Python's syntax tree; each node is translated, if it is on the list
of :mod:`fsm.expressions.translator`, to a piece of code of *ours* together with its type. Only
that generated code is compiled, with nothing in reach but the functions of
:mod:`fsm.values.functions`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from fsm.expressions.constants import warn_of_angle
from fsm.expressions.scope import Scope
from fsm.expressions.syntax import too_deep
from fsm.expressions.translator import Translator
from fsm.values.conversion import convert
from fsm.values.functions import FAILURES, Budget, bounded, plain
from fsm.values.types import ANY, Bool, Number, Type, fits, in_bounds
from vencejo.errors import UserError, Where
from vencejo.units import example_of

_SLOT = re.compile(r"s\[(\d+)\]")
_NUMBER = re.compile(r"\d+\.\d+")
Evaluator = Callable[[list[Any], Mapping[str, Any] | None], Any]
"""A compiled value, as a function of an instance's slots and of the fields of its event."""


@dataclass(frozen=True, slots=True)
class Compiled:
    """An expression or literal ready to be evaluated."""

    type: Type
    function: Evaluator
    source: str
    where: Where
    constant: bool = False
    reads: frozenset[str] = frozenset()
    """The kinds of the names it depends on; empty for a literal."""
    code: str = ""
    """The code it was translated to: two expressions that say the same have the same."""
    needs: frozenset[str] = frozenset()
    """The capabilities of a vehicle that its value asks for."""

    def __call__(self, slots: list[Any], event: Mapping[str, Any] | None = None) -> Any:
        """Evaluate it. Raises one of :data:`fsm.values.functions.FAILURES`."""
        return self.function(slots, event)

    def value(self) -> Any:
        """The value of a constant."""
        return self.function([], None)


def constant(value: Any, type_: Type, where: Where, source: str = "") -> Compiled:
    return Compiled(type_, lambda slots, event: value, source, where, constant=True)


def compile_expression(
    text: str,
    where: Where,
    scope: Scope,
    wanted: Type = ANY,
    arguments: Mapping[str, Type] | None = None,
    condition: bool = False,
) -> Compiled:
    """Parse, type and compile an expression. Raises UserError at the very column that is wrong.

    A ``condition`` that is constant is a warning of its scope.
    """
    arguments = arguments or {}
    translator = Translator(text, where, scope, arguments)
    code, type_ = translator.translate(condition)
    if not fits(wanted, type_):
        numbers = isinstance(type_, Number) and isinstance(wanted, Number)
        raise UserError(
            "wrong-dimension" if numbers else "wrong-type",
            f"'{text}' is {type_}, but {wanted} is needed here",
            where,
            _cure(wanted),
        )
    if translator.loops:
        code = f"(lambda b: {code})({translator.use('Budget', Budget)}())"
    if not isinstance(type_, (Bool, Number)):
        code = f"{translator.use('bounded', bounded)}({code})"
    function = _simple(code) or _compiled(code, arguments, translator, where)
    is_constant = not translator.reads and not arguments
    if is_constant:
        _require_fit(function, type_, wanted, where)
        if isinstance(type_, Number) and type_.dimension is None:
            warn_of_angle(scope, function([], None), text, wanted, where)
    return Compiled(
        type_, function, text, where, is_constant, frozenset(translator.reads), code=code
    )


def require_value(compiled: Compiled) -> None:
    """Refuse a constant that is none, where there has to be a value."""
    if compiled.constant and compiled.value() is None:
        raise UserError("wrong-type", "a value is missing here", compiled.where)


def _cure(wanted: Type) -> str | None:
    """A hint that shows what is wanted; None where the message says it all."""
    if isinstance(wanted, Bool):
        return "compare it to something"
    if isinstance(wanted, Number) and wanted.dimension is not None:
        return example_of(wanted.dimension)
    return None


def _require_fit(function: Evaluator, type_: Type, wanted: Type, where: Where) -> None:
    """Refuse a constant without a value, or whose value cannot stand in its place."""
    try:
        value = function([], None)
    except FAILURES as error:
        message = f"this has no value: {plain(error)}"
        raise UserError("no-value", message, where, "correct the constant") from None
    try:
        in_bounds(wanted, value)
        if not isinstance(type_, Number):
            convert(value, wanted)
    except UserError as error:
        raise UserError(error.code, error.faults[0].message, where, _cure(wanted)) from None
    except FAILURES as error:
        raise UserError("wrong-type", plain(error), where) from None


def _simple(code: str) -> Evaluator | None:
    """A function for code that is a slot or a number by itself: Python's compiler is slow."""
    slot = _SLOT.fullmatch(code)
    if slot:
        index = int(slot[1])
        return lambda slots, event: slots[index]
    if _NUMBER.fullmatch(code):
        value = float(code)
        return lambda slots, event: value
    return None


def _compiled(
    code: str, arguments: Iterable[str], translator: Translator, where: Where
) -> Evaluator:
    names = "s, e" + "".join([f", a_{name}" for name in arguments])
    try:
        # `code` is made of our own pieces only: see the module's docstring.
        source = compile(f"lambda {names}: {code}", f"<{where}>", "eval")
    except (SyntaxError, RecursionError, MemoryError):
        raise too_deep(where) from None
    function: Evaluator = eval(source, translator.namespace)
    return function
