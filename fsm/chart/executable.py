"""The compiled contents of states and transitions: actions, data, invocations and parameters.

Both languages compile to these values, which the interpreter in :mod:`fsm.engine` runs. The
protocol :class:`Runtime` is all that an action may use of the interpreter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from fsm.expressions.compiled import Compiled
from fsm.host import BehaviorInfo, Host
from fsm.values.functions import EvaluationError
from fsm.values.types import Type
from vencejo.errors import Where
from vencejo.nodes import YamlNode

EventFields = dict[str, Any]
"""The fields of the event at hand; there are none where no event is."""
Record = tuple[str, dict[str, Any]]
"""Something that happened: its kind and its fields. Instances share some, so none is changed."""
CONTENT = "<content>"
"""The key of an event's data that are one value without fields; no field can have this name."""


@dataclass(frozen=True, slots=True)
class Origin:
    """How an event came about, as SCXML documents see it (W3C recommendation, section 5.10.1)."""

    type: Literal["external", "internal", "platform"]
    sendid: str | None = None
    """The id of the `send` that it comes from, where that was given one or has failed."""
    address: str | None = None
    """The target that an answer is sent to."""
    processor: str | None = None
    """The type of the event processor that an answer is sent by."""


EXTERNAL = Origin("external")
INTERNAL = Origin("internal")
PLATFORM = Origin("platform")


class NotSentError(EvaluationError):
    """An event could not be sent; ``event`` is what the graph hears of it."""

    def __init__(self, message: str, event: str, sendid: str) -> None:
        super().__init__(message)
        self.event = event
        self.sendid = sendid


class Runtime(Protocol):
    """The part of a running instance that its actions and guards may use."""

    @property
    def slots(self) -> list[Any]:
        """The values of the instance, which compiled expressions read and assignments change."""

    @property
    def records(self) -> list[Record]:
        """The records made since the caller last replaced this list by an empty one."""

    @property
    def host(self) -> Host:
        """The host, which runs registered functions."""

    def record(self, what: str, **fields: Any) -> None:
        """Add to the records."""

    def raise_event(self, name: str, fields: Mapping[str, Any], origin: Origin = INTERNAL) -> None:
        """Queue an event for this macrostep."""

    def send(
        self,
        name: str,
        fields: Mapping[str, Any],
        delay: float,
        id_: str,
        to: str = "",
        origin: Origin = EXTERNAL,
    ) -> None:
        """Queue an event for a later period, ``delay`` seconds from now, or for another vehicle."""

    def cancel(self, id_: str) -> None:
        """Take back what was sent with this id and is not due."""

    def evaluate(self, compiled: Compiled, fields: EventFields, otherwise: Any) -> Any:
        """The value of an expression. One that fails raises ``error.execution`` in the graph and
        has the value ``otherwise``.
        """

    def run_actions(self, actions: Sequence[Action], fields: EventFields) -> None:
        """ActionFunction a block of actions; when one fails, the rest of this block is skipped."""


ActionFunction = Callable[[Runtime, EventFields], None]
"""An action at work. Raises one of :data:`fsm.values.functions.FAILURES` when it fails."""


@dataclass(frozen=True, slots=True, eq=False)
class Message:
    """An event that an action raises, sends or takes back, as far as known before the flight."""

    event: str
    """The event's name; empty for a `cancel`, which names an id only."""
    where: Where
    """The place of the name."""
    to: str = ""
    """The vehicle that it is sent to; empty for its own."""
    id_: str | None = None
    """What `cancel` calls it; None where that is only known in flight."""
    fields: Mapping[str, Compiled] = field(default_factory=dict)
    """The fields that are given to another vehicle, each as an untyped value."""


@dataclass(frozen=True, slots=True, eq=False)
class Action:
    """One step of an action block, ready to run."""

    kind: str
    where: Where
    run: ActionFunction
    node: YamlNode | None = None
    """The value behind its word in the file, to show it."""
    message: Message | None = None
    """The event that it raises, sends or cancels; None for other actions."""

    @property
    def event(self) -> str:
        """The event that it raises or sends to its own mission; empty for none."""
        return self.message.event if self.message and not self.message.to else ""


@dataclass(frozen=True, slots=True, eq=False)
class Data:
    """A variable of a state."""

    name: str
    slot: int
    type: Type
    initial: Compiled


@dataclass(frozen=True, slots=True, eq=False)
class Invocation:
    """The ``do`` of a state."""

    behavior: BehaviorInfo
    with_: Mapping[str, Compiled]
    live: Mapping[str, Compiled]
    slot: int
    """The slot of its published values; -1 when it publishes nothing."""

    def required(self) -> set[str]:
        """The capabilities that the behaviour needs, with the values that it is given."""
        given = (*self.with_.values(), *self.live.values())
        # What is only known in flight is None here.
        known = {name: c.value() if c.constant else None for name, c in self.with_.items()}
        asked = {need for value in given for need in value.needs}
        return {*self.behavior.requires, *asked, *self.behavior.named(known)}


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """A parameter of an included graph, filled whenever that is entered."""

    name: str
    slot: int
    default: Any
    with_: Compiled | None = None
    live: Compiled | None = None
