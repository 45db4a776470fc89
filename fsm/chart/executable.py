"""What stands in a state or a transition, ready to run: actions, data, behaviours, parameters.

Both languages compile to these values; the interpreter in :mod:`fsm.engine` runs them. What an
action may use of that interpreter is the protocol :class:`Runtime`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from fsm.expressions.compiled import Compiled
from fsm.host import BehaviorInfo
from fsm.values.types import Type
from vencejo.errors import Where
from vencejo.nodes import YamlNode


@dataclass(frozen=True, slots=True)
class Action:
    """One step of an action block, ready to run."""

    kind: str
    where: Where
    run: Callable[[Any, dict[str, Any]], None]
    """Of the instance and the fields of the event."""
    node: YamlNode | None = None
    """The value behind its word in the file, to show it."""


@dataclass(frozen=True, slots=True)
class Data:
    """A variable of a state."""

    name: str
    slot: int
    type: Type
    initial: Compiled


@dataclass(frozen=True, slots=True)
class Invocation:
    """The ``do`` of a state."""

    behavior: BehaviorInfo
    with_: Mapping[str, Compiled]
    live: Mapping[str, Compiled]
    slot: int
    """Where its published values stand; -1 when it publishes nothing."""


@dataclass(frozen=True, slots=True)
class Given:
    """A parameter of an included graph, filled whenever that is entered."""

    name: str
    slot: int
    default: Any
    with_: Compiled | None = None
    live: Compiled | None = None
