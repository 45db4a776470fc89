"""A mission as written: the structure of its file, with places, names and types not yet known.

Specs are compared by identity: two that say the same at different places are not one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from vencejo.errors import Where
from vencejo.nodes import Mapping, Scalar, YamlNode

TriggerKind = Literal["on", "when", "after", "always"]
ActionKind = Literal["set", "append", "raise", "send", "cancel", "log", "call"]
StateType = Literal["atomic", "compound", "parallel", "final", "history"]


@dataclass(frozen=True, slots=True, eq=False)
class ActionSpec:
    kind: ActionKind
    node: YamlNode
    where: Where


@dataclass(frozen=True, slots=True, eq=False)
class TransitionSpec:
    """One alternative of a trigger; without targets nothing is left."""

    where: Where
    targets: tuple[Scalar, ...] = ()
    guard: Scalar | None = None
    actions: tuple[ActionSpec, ...] = ()
    hold: Scalar | None = None
    """``for``: how long the condition must last."""
    reenter: bool = False
    name: str = ""
    description: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class TriggerSpec:
    """A trigger (event, outcome, condition or duration) with its alternative transitions."""

    kind: TriggerKind
    key: Scalar
    alternatives: tuple[TransitionSpec, ...]


@dataclass(frozen=True, slots=True, eq=False)
class DefineSpec:
    name: str
    arguments: tuple[str, ...]
    body: Scalar
    where: Where


@dataclass(frozen=True, slots=True, eq=False)
class Named:
    """A name and its value, which is read later."""

    name: Scalar
    node: YamlNode


@dataclass(frozen=True, slots=True, eq=False)
class StateSpec:
    name: str
    where: Where
    type: StateType
    initial: Scalar | None = None
    description: str = ""
    data: tuple[Named, ...] = ()
    define: tuple[DefineSpec, ...] = ()
    entry: tuple[ActionSpec, ...] = ()
    exit: tuple[ActionSpec, ...] = ()
    throughout: tuple[ActionSpec, ...] = ()
    do: Scalar | None = None
    with_: tuple[Named, ...] = ()
    live: tuple[Named, ...] = ()
    as_: Scalar | None = None
    include: Scalar | None = None
    triggers: tuple[TriggerSpec, ...] = ()
    states: tuple[StateSpec, ...] = ()
    outcome: str = "done"
    output: tuple[Named, ...] = ()
    deep: bool = False
    target: Scalar | None = None
    breakpoint: bool = False
    flawed: bool = False
    """Some of its transitions could not be read."""

    def walk(self) -> Iterator[StateSpec]:
        """This state and all inside it, in document order."""
        yield self
        for child in self.states:
            yield from child.walk()


@dataclass(frozen=True, slots=True, eq=False)
class MissionSpec:
    """A whole file, or a graph kept inside one."""

    name: str
    file: str
    root: StateSpec
    description: str = ""
    world: Scalar | None = None
    uses: tuple[Scalar, ...] = ()
    places: tuple[Named, ...] = ()
    parameters: tuple[Named, ...] = ()
    events: tuple[Named, ...] = ()
    outer_first: bool = False
    node: Mapping | None = None
    graphs: tuple[MissionSpec, ...] = ()
    """The graphs that are kept in this file."""
    included: dict[str, MissionSpec] = field(default_factory=dict)
    """The graph of each word after ``include``; filled by :mod:`fsm.language.includes`."""

    def closure(self) -> list[MissionSpec]:
        """This graph and all that it includes, each once, the outer ones first."""
        found: dict[int, MissionSpec] = {}
        pending = [self]
        while pending:
            spec = pending.pop()
            if id(spec) not in found:
                found[id(spec)] = spec
                pending.extend(reversed(spec.included.values()))
        return list(found.values())
