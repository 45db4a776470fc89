"""A mission compiled: states and transitions as `transitions` knows them, with everything resolved.

A :class:`Graph` never changes once compiled and is shared by all its instances. ``Node`` is a
``transitions.State`` and ``Edge`` a ``transitions.Transition``, so that callbacks added to them
(``on_enter``, ``on_exit``, ``prepare``, ``before``, ``after``) and further conditions are honoured
by :class:`fsm.engine.instance.Instance`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from transitions.core import Condition, EventData, State, Transition

from fsm.chart.digest import Element, digest_of
from fsm.expressions.compiled import Compiled
from fsm.host import Behavior, Parameter, Vocabulary, matches
from fsm.language.spec import MissionSpec, StateType, TriggerKind
from fsm.values.conversion import convert
from fsm.values.functions import FAILURES
from fsm.values.types import Type
from vencejo import nodes
from vencejo.errors import Fault, UserError, Where, nearest

Record = tuple[str, dict[str, Any]]
"""Something that happened: its kind and what is known of it. Shared, so nobody changes one."""


class Guard(Condition):
    """A guard in `transitions`' form; its function is a compiled expression."""

    def __init__(self, compiled: Compiled) -> None:
        super().__init__(compiled)

    def check(self, event_data: EventData) -> bool:
        """Whether the guard passes for this event; one that fails to evaluate does not."""
        model: Any = event_data.model
        return model.evaluate(self.func, event_data.kwargs, False) is True


@dataclass(frozen=True, slots=True)
class Action:
    """One step of an action block, ready to run."""

    kind: str
    where: Where
    run: Callable[[Any, dict[str, Any]], None]
    """Of the instance and the fields of the event."""
    node: nodes.Node | None = None
    """What stands behind its word in the file, to show it."""


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

    behavior: Behavior
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


class Edge(Transition):
    """One alternative of a transition."""

    def __init__(
        self,
        source: Node,
        kind: TriggerKind,
        trigger: str,
        where: Where,
        name: str = "",
    ) -> None:
        super().__init__(source.path, "")
        self.node = source
        self.kind = kind
        self.trigger = trigger
        self.where = where
        self.label = name
        self.targets: tuple[Node, ...] = ()
        self.domain: Node | None = None
        """The state whose inside is left; None when nothing is."""
        self.guard: Compiled | None = None
        self.actions: tuple[Action, ...] = ()
        self.hold: Compiled | None = None
        self.reenter = False

    @property
    def taking(self) -> Record:
        """What is recorded when it is taken."""
        by = self.kind if self.kind == "always" else f"{self.kind} {self.trigger}"
        step = {"by": by, "from": self.node.path, "to": [target.path for target in self.targets]}
        return "transition", {**step, "name": self.label} if self.label else step


@dataclass(frozen=True, slots=True)
class When:
    """A condition with its alternatives."""

    condition: Compiled
    edges: tuple[Edge, ...]


@dataclass(frozen=True, slots=True)
class After:
    """A duration with its alternatives."""

    duration: Compiled
    edges: tuple[Edge, ...]


class Node(State):
    """One state. ``path`` is its full name: ``patrol.follow``; the root's is empty."""

    def __init__(self, name: str, path: str, type_: StateType, index: int, where: Where) -> None:
        super().__init__(path, final=type_ == "final")
        self.local_name = name
        self.path = path
        self.type = type_
        self.index = index
        self.mask = 1 << index
        self.where = where
        self.description = ""
        self.parent: Node | None = None
        self.children: tuple[Node, ...] = ()
        self.border = False
        """Whether a graph begins here: it is the root, or the only child of a state that includes
        one. Names, targets and outcomes other than `failed` do not cross it."""
        self.given: tuple[Given, ...] = ()
        """Parameters of the graph that begins here, when it is included."""
        self.ancestors: tuple[Node, ...] = ()
        """From the parent outwards to the root."""
        self.last = index
        """Index of the last state inside; document order makes ``index … last`` this subtree."""
        self.initial: tuple[Node, ...] = ()
        self.deep = False
        self.entered_slot = -1
        self.data: tuple[Data, ...] = ()
        self.entry: tuple[Action, ...] = ()
        self.default_actions: tuple[Action, ...] = ()
        """SCXML's actions of a default entry, run after those of the state; a history state's
        belong to its first time."""
        self.exit_actions: tuple[Action, ...] = ()
        self.throughout: tuple[Action, ...] = ()
        self.invocation: Invocation | None = None
        self.on: tuple[tuple[str, tuple[Edge, ...]], ...] = ()
        self.always: tuple[Edge, ...] = ()
        self.whens: tuple[When, ...] = ()
        self.afters: tuple[After, ...] = ()
        self.outcome = "done"
        self.output: Mapping[str, Compiled] = {}
        self.entering: Record = ("enter", {"state": path})
        self.leaving: Record = ("exit", {"state": path})
        """What is recorded when it is entered and left."""
        self.fills = self.waits = False
        """Whether an entry gives values to anything, and whether it arms conditions or timers."""

    @property
    def owner(self) -> Node:
        """Whose outcome it is when what is inside ends: of an included graph, its includer's."""
        return self.parent.owner if self.border and self.parent else self

    def outwards(self) -> Iterator[Node]:
        """This state and those around it in the same graph."""
        for node in (self, *self.ancestors):
            yield node
            if node.border:
                return

    def contains(self, other: Node) -> bool:
        """Whether ``other`` lies inside, this state itself apart."""
        return self.index < other.index <= self.last

    def edges(self) -> Iterable[Edge]:
        """Every transition that stands in this state."""
        for _, edges in self.on:
            yield from edges
        for when in self.whens:
            yield from when.edges
        for after in self.afters:
            yield from after.edges
        yield from self.always

    def edges_for(self, event: str, vocabulary: Vocabulary) -> tuple[Edge, ...]:
        """The transitions this event or outcome may take here, in order.

        ``vocabulary`` says which events are urgent: ``*`` does not catch those, nor ``error.…``.
        """
        found: list[Edge] = []
        for pattern, edges in self.on:
            if pattern == "*":
                caught = not (event.startswith("error.") or vocabulary.is_urgent(event))
            else:
                caught = matches(pattern, event)
            if caught:
                found += edges
        return tuple(found)


@dataclass(frozen=True, eq=False)
class Graph:
    """A compiled mission. Also what `transitions` calls the machine of an event.

    It never changes: what instances derive from it is kept beside it (:mod:`fsm.engine.shared`).
    """

    name: str
    description: str
    root: Node
    nodes: Sequence[Node]
    """All states in document order; the root is the first."""
    parameters: Mapping[str, Parameter]
    parameter_slots: Mapping[str, int]
    vocabulary: Vocabulary
    slots: int
    """The number of values that an instance has."""
    events: Mapping[str, Mapping[str, Type]]
    """Declared events with the types of their fields."""
    world: str | None
    """The world that the mission names."""
    outer_first: bool
    """Whether outer states come before inner ones in selection."""
    warnings: tuple[Fault, ...] = ()
    send_event: bool = True
    """`transitions`' word for callbacks that take the event's data as their only argument."""
    by_path: Mapping[str, Node] = field(default_factory=dict)
    source: MissionSpec | None = None
    """The mission it was compiled from."""
    document: Element | None = None
    """The root of the SCXML document it was compiled from, when that is no mission."""
    event_slot: int = -1
    """The slot of ``_event`` in an SCXML document; -1 in a mission."""

    def __post_init__(self) -> None:
        for node in self.nodes:
            node.fills = bool(node.given or node.data or node.invocation)
            node.waits = bool(node.whens or node.afters)

    @property
    def digest(self) -> str:
        """A hash of the mission's words, computed at each call (see :mod:`fsm.chart.digest`)."""
        return digest_of(self.source or self.document)

    @property
    def scxml(self) -> bool:
        """Whether this came from an SCXML document: finished states then raise `done.state.ID`."""
        return self.event_slot >= 0

    def callbacks(self, functions: Iterable[Any], event_data: EventData) -> None:
        """Run `transitions` callbacks with the event's data."""
        for function in functions:
            if isinstance(function, str):
                function = self.resolve_callable(function, event_data)
            function(event_data)

    def resolve_callable(self, function: Any, event_data: EventData) -> Any:
        """A callback itself, or the model's method of that name; nothing is ever imported."""
        return getattr(event_data.model, function) if isinstance(function, str) else function

    def parameter_value(self, name: str, value: Any) -> Any:
        """A value for a parameter that is changed in flight, in the form of its type.

        Raises UserError for an unknown parameter, and for a value that it may not have.
        """
        parameter = self.parameters.get(name)
        if parameter is None:
            message = f"{self.name} has no parameter '{name}'"
            raise UserError("unknown-parameter", message, None, nearest(name, self.parameters))
        try:
            return convert(value, parameter.type)
        except FAILURES as error:
            raise UserError("wrong-value", f"{name}: {error}") from None

    def required(self) -> dict[str, Node]:
        """Capabilities that the mission's behaviours need, each with a state that needs it."""
        return {
            capability: node
            for node in reversed(self.nodes)
            if node.invocation
            for capability in node.invocation.behavior.requires
        }
