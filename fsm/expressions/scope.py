"""Names: what an expression can see, and the slot of an instance that each one reads.

All values of a running instance lie in one list of *slots*, fixed when the graph is compiled; an
expression compiles to a function of those slots and of the event at hand.
"""

from __future__ import annotations

import keyword
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from fsm.values.functions import FUNCTIONS
from fsm.values.types import ANY, MapOf, Number, Type
from vencejo.errors import Fault, UserError, Where
from vencejo.nodes import Scalar
from vencejo.units import TIME

RESERVED = frozenset([*keyword.kwlist, "true", "false", "null", "none", "event", "time_in_state"])
"""Words with a meaning of their own in expressions."""
TIME_SLOT = 0
CONFIGURATION_SLOT = 1
PERIOD_SLOT = 2
FIRST_HOST_SLOT = 3
MAX_PARTS = 80_000
"""The most parts of all expressions of a mission."""
EXPRESSION = 5
"""An expression counts as so many parts more than it has."""

BindingKind = Literal["host", "parameter", "data", "published", "define", "entered", "event"]


def start(scalar: Scalar) -> Where:
    """The place of a scalar's first letter, after its quote."""
    return scalar.where.right(0 if scalar.plain else 1)


@dataclass(frozen=True)
class Binding:
    """A name with its type and the slot that holds its value."""

    name: str
    kind: BindingKind
    type: Type
    slot: int = -1
    where: Where | None = None


@dataclass(eq=False)
class Define:
    """A named expression, perhaps with arguments, and the scope it is written in."""

    name: str
    arguments: tuple[str, ...]
    body: Scalar
    scope: Scope
    busy: bool = False


HINTS = 200
"""Number of unknown names in a mission for which a hint is looked for."""


@dataclass(eq=False)
class Size:
    """How large the expressions of a mission are, those of defines counted at each use."""

    parts: int = 0
    unknown: int = 0
    """Number of unknown names found."""

    def add_unknown(self) -> bool:
        """Count an unknown name; True for the first ones, for which a hint is worth the search."""
        self.unknown += 1
        return self.unknown <= HINTS

    def add_expression(self, file: str) -> None:
        """Count one. Raises UserError, always the same, once there are too many."""
        self.parts += EXPRESSION
        if self.parts > MAX_PARTS:
            raise UserError(
                "mission-too-large",
                f"the expressions of this mission have more than {MAX_PARTS:,} parts, those of "
                "defines counted at each use",
                Where(file),
                "keep what is used often in a variable under `data`",
            )


@dataclass(eq=False)
class Scope:
    """The names of one state, and by its parent those of the states around it."""

    parent: Scope | None = None
    names: dict[str, Binding] = field(default_factory=dict)
    defines: dict[str, Define] = field(default_factory=dict)
    states: Mapping[str, int] = field(default_factory=dict)
    """Paths of all states of the graph, for ``active('a.b')``."""
    entered_slot: int = -1
    """The slot of the time at which this scope's state was entered."""
    warnings: list[Fault] = field(default_factory=list)
    """What is doubtful in the expressions compiled here; scopes inside share the list."""
    size: Size = field(default_factory=Size)
    """The size of what was compiled here; scopes inside share it."""
    host_fields: dict[str, Where] = field(default_factory=dict)
    """What is read of the host's values, such as ``vehicle.wind``, with the first place of each;
    scopes inside share it."""

    def find(self, name: str) -> Binding | Define | None:
        """The declaration of a name here or further out; None when it is unknown."""
        scope: Scope | None = self
        while scope is not None:
            found = scope.names.get(name) or scope.defines.get(name)
            if found is not None:
                return found
            scope = scope.parent
        return None

    def all_states(self) -> Mapping[str, int]:
        """The indices of all states of the graph, by their paths in it."""
        scope: Scope = self
        while scope.parent is not None and not scope.states:
            scope = scope.parent
        return scope.states

    def visible(self) -> Iterator[str]:
        """All names that are visible here, inner ones first."""
        scope: Scope | None = self
        while scope is not None:
            yield from scope.names
            yield from scope.defines
            scope = scope.parent

    def with_field(self, field: str) -> Iterator[str]:
        """The visible names of maps that have a field, inner ones first."""
        scope: Scope | None = self
        while scope is not None:
            for name, binding in scope.names.items():
                if isinstance(binding.type, MapOf) and field in (binding.type.fields or {}):
                    yield name
            scope = scope.parent

    def declare(self, thing: Binding | Define, where: Where | None) -> None:
        """Declare a name. Raises UserError when it is visible already, or reserved."""
        known = self.find(thing.name)
        reserved = thing.name in RESERVED or (
            isinstance(thing, Define) and (thing.name in FUNCTIONS or thing.name == "active")
        )
        if known is not None or reserved:
            # From here on it may be either: no second fault for the same mistake.
            self.names[thing.name] = Binding(thing.name, "data", ANY)
        if reserved:
            raise UserError(
                "name-taken",
                f"'{thing.name}' is a word of the language",
                where,
                "choose another name",
            )
        if known is not None:
            first = known.where if isinstance(known, Binding) else known.body.where
            at = f", first at {first}" if first else ""
            raise UserError(
                "name-taken",
                f"the name '{thing.name}' is visible here already{at}",
                where,
                "names may not hide each other: rename one of the two",
            )
        if isinstance(thing, Define):
            self.defines[thing.name] = thing
        else:
            self.names[thing.name] = thing

    def warn(self, code: str, message: str, where: Where, hint: str) -> None:
        """Add a warning."""
        self.warnings.append(Fault(code, message, where, hint, "warning"))

    def with_event(self, type_: Type) -> Scope:
        """This scope with ``event``, as an ``on`` transition sees it."""
        inner = self._inner(self.entered_slot)
        inner.names["event"] = Binding("event", "event", type_)
        return inner

    def inside(self, entered_slot: int) -> Scope:
        """A scope for a state within this one."""
        inner = self._inner(entered_slot)
        if self.find("time_in_state") is None:
            inner.names["time_in_state"] = Binding("time_in_state", "entered", Number(TIME))
        return inner

    def _inner(self, entered_slot: int) -> Scope:
        return Scope(
            self,
            entered_slot=entered_slot,
            warnings=self.warnings,
            size=self.size,
            host_fields=self.host_fields,
        )
