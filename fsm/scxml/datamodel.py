"""What the data models of SCXML have in common, and what a document needs of each.

What a document gets wrong shows in three ways. What is well formed but not among the things that
are run here is refused: the data model raises UserError. What is ill-formed raises UserError as
well, with one of the codes of RUN_TIME: the W3C lets such a document run, and the expression raises
``error.execution`` whenever it is evaluated. An unknown name inside a well-formed expression is a
warning among ``Names.faults``, and fails when it is read.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from fsm.expressions.compiled import Evaluator
from fsm.faults import Faults
from fsm.values.functions import EvaluationError, bounded, shown
from vencejo.errors import UserError, Where, nearest

RUN_TIME = ("bad-expression", "bad-location", "system-variable")
"""The codes of what fails only when it is evaluated."""
SYSTEM_VARIABLES = ("_event", "_sessionid", "_name", "_ioprocessors")
PROCESSOR = "http://www.w3.org/TR/scxml/#SCXMLEventProcessor"
"""The type of the one event processor there is."""
PROCESSORS = (PROCESSOR, "scxml")
"""Its names."""


@dataclass(frozen=True, slots=True)
class Names:
    """The names that the expressions of a document can use."""

    variables: Mapping[str, int]
    """Name → slot; ``_event`` and the other system variables are among them."""
    states: Mapping[str, int]
    """Id → index in document order."""
    faults: Faults
    """Takes the warnings about names that fail at run time."""

    def slot(self, name: str, where: Where) -> int | None:
        """The slot of a variable; None, and a warning, when the document has none of that name."""
        slot = self.variables.get(name)
        if slot is None:
            self.warn("unknown-name", f"there is no variable '{name}'", where, self.near(name))
        return slot

    def near(self, name: str) -> str | None:
        """A hint for a name that no variable has."""
        own = [known for known in self.variables if not known.startswith("_")]
        return nearest(name, self.variables if name.startswith("_") else own)

    def state(self, id_: str, where: Where) -> int | None:
        """The index of a state; None, and a warning, when there is none."""
        index = self.states.get(id_)
        if index is None:
            message = f"there is no state '{id_}': In() is false"
            self.faults.warn(
                "unknown-state", message, where, nearest(id_, self.states) or "remove it"
            )
        return index

    def warn(self, code: str, message: str, where: Where, hint: str | None) -> None:
        """Warn of what raises ``error.execution`` at run time."""
        raised = "it raises error.execution at run time"
        self.faults.warn(code, message, where, f"{hint}; as it is, {raised}" if hint else raised)


def undeclared(name: str) -> Evaluator:
    """The value of a variable that does not exist: reading it fails."""

    def fail(slots: list[Any], event: Mapping[str, Any] | None) -> NoReturn:
        raise EvaluationError(f"there is no variable '{name}'")

    return fail


@dataclass(frozen=True, slots=True)
class Location:
    """A place for a value: a variable, or a field or element of what it holds."""

    name: str
    """The name of the variable."""
    slot: int
    keys: Sequence[Evaluator]
    """The keys that lead from its value to the place."""
    item: Callable[[Any, Any], Any]
    """The field or element of a value with a key."""
    store: Callable[[Any, Any, Any], None]
    """Sets the field or element of a value with a key."""

    def assign(self, slots: list[Any], event: Mapping[str, Any] | None, value: Any) -> None:
        """Put a value there. Raises EvaluationError when there is no such place."""
        if not self.keys:
            slots[self.slot] = value
            return
        holder = slots[self.slot]
        for key in self.keys[:-1]:
            holder = self.item(holder, key(slots, event))
        if not isinstance(holder, (list, dict)):
            raise EvaluationError(f"{shown(holder)} has no fields that can be set")
        before = holder.copy()
        self.store(holder, self.keys[-1](slots, event), value)
        try:
            # A value that has become too large, or holds itself, is taken back.
            bounded(slots[self.slot])
        except EvaluationError:
            holder.clear()
            _refill(holder, before)
            raise


def _refill(holder: Any, before: Any) -> None:
    holder.update(before) if isinstance(holder, dict) else holder.extend(before)


@dataclass(frozen=True, slots=True)
class Assignment:
    """One statement of a script."""

    location: Location
    value: Evaluator


Compile = Callable[[str, Where, Names], Evaluator]


@dataclass(frozen=True, slots=True)
class DataModel:
    """A language of values, expressions and scripts. Each function raises UserError."""

    compile_value: Compile
    """Compiles an expression."""
    compile_condition: Compile
    """Compiles an expression to a condition, which is true or false by the language's rules."""
    compile_location: Callable[[str, Where, Names], Location]
    """Compiles what stands on the left of an assignment."""
    compile_script: Callable[[str, Where, Names], list[Assignment]]
    """Compiles a script of assignments."""
    assigned_names: Callable[[str], list[str]]
    """The variables that a script assigns, and so declares."""
    text_of: Callable[[Any], str]
    """The text that the language converts a value to."""
    null: Any
    """Its value for the ``null`` of JSON."""
    processor: str = PROCESSOR
    """The name of the event processor in ``_event.origintype``."""

    def content(self, text: str) -> Evaluator:
        """The value of an element's text: JSON, or else the text with single blanks.

        W3C recommendation, sections B.2.1 and C.1; each evaluation makes a new value.
        """
        try:
            _json(text)
        except (ValueError, RecursionError):
            plain = " ".join(text.split())
            return lambda slots, event: plain
        return lambda slots, event: bounded(self._read(_json(text)))

    def _read(self, value: Any) -> Any:
        if value is None:
            return self.null
        if isinstance(value, list):
            return [self._read(element) for element in value]
        if isinstance(value, dict):
            return {key: self._read(element) for key, element in value.items()}
        return value


def _json(text: str) -> Any:
    """The value of a JSON text. Raises ValueError for what is none, or holds half a letter."""
    value = json.loads(text, parse_constant=_refuse)
    json.dumps(value, ensure_ascii=False).encode()
    return value


def _refuse(word: str) -> NoReturn:
    raise ValueError(f"{word} is no JSON")


def declared_variable(name: str, where: Where, names: Names) -> int:
    """The slot of a variable that may be assigned. Raises UserError."""
    if name in SYSTEM_VARIABLES:
        raise UserError("system-variable", f"'{name}' cannot be assigned", where)
    if name not in names.variables:
        message = f"there is no variable '{name}'"
        raise UserError("bad-location", message, where, names.near(name))
    return names.variables[name]
