"""A mission compiled: states and transitions as `transitions` knows them, with everything resolved.

A :class:`Graph` never changes once compiled and is shared by all its instances. ``Node`` is a
``transitions.State`` and ``Edge`` a ``transitions.Transition``, so that callbacks added to them
(``on_enter``, ``on_exit``, ``prepare``, ``before``, ``after``) and further conditions are honoured
by :class:`fsm.engine.instance.Instance`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple, cast

from transitions.core import Condition, EventData, State, Transition

from fsm.chart.digest import Element, digest_of
from fsm.chart.draft import Draft, StateDraft, TransitionDraft
from fsm.chart.executable import Action, Data, Given, Invocation, Message, Record, Runtime
from fsm.chart.nesting import Nested, domain_of
from fsm.expressions.compiled import Compiled
from fsm.host import Parameter, Vocabulary
from fsm.language.spec import MissionSpec, StateType, TriggerKind
from fsm.values.conversion import convert
from fsm.values.functions import FAILURES
from fsm.values.types import Type
from vencejo.errors import Fault, UserError, Where, nearest

Matching = Callable[[str, str, Vocabulary], bool]
"""Decides whether a pattern under ``on`` matches an event or outcome of a host's vocabulary."""


class Guard(Condition):
    """A guard in `transitions`' form; its function is a compiled expression."""

    def __init__(self, compiled: Compiled) -> None:
        super().__init__(compiled)
        self.compiled = compiled

    def check(self, event_data: EventData) -> bool:
        """Whether the guard passes for this event; one that fails to evaluate does not."""
        running = cast(Runtime, event_data.model)
        return running.evaluate(self.compiled, event_data.kwargs, False) is True


class Frozen:
    """An object whose attributes cannot be set, since all instances of a graph share it.

    Callbacks may still be added to the lists in which `transitions` keeps them.
    """

    __slots__ = ()

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a compiled graph does not change: '{name}' cannot be set")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a compiled graph does not change: '{name}' cannot be deleted")


class Edge(Frozen, Transition):
    """One alternative of a transition, in `transitions`' form."""

    node: Node
    """The state it stands in."""
    kind: TriggerKind
    trigger: str
    """The event, condition or duration that triggers it, as written."""
    where: Where
    label: str
    """Its name; empty when it has none."""
    targets: tuple[Node, ...]
    domain: Node | None
    """The state whose descendants are left; None for a transition without targets."""
    by_history: bool
    """True when history may narrow the domain to a state inside it (see
    :func:`fsm.chart.entry_sets.transition_domain`): a target is a history state around which its
    own state lies, so that what is remembered can lie closer to that."""
    guard: Compiled | None
    hold: Compiled | None
    """Duration for which its condition must hold, seconds; None for none."""
    actions: tuple[Action, ...]
    reenter: bool
    """True when its state is left even when all targets lie inside it."""

    def __init__(self, draft: TransitionDraft, source: StateDraft, nodes: Sequence[Node]) -> None:
        domain = domain_of(source, draft.targets, draft.reenter)
        vars(self).update(
            node=nodes[source.index],
            kind=draft.kind,
            trigger=draft.trigger,
            where=draft.where,
            label=draft.name,
            targets=tuple([nodes[target.index] for target in draft.targets]),
            domain=None if domain is None else nodes[domain.index],
            by_history=any(
                target.type == "history" and target.parent and target.parent.contains(source)
                for target in draft.targets
            ),
            guard=draft.guard,
            hold=draft.hold,
            actions=draft.actions,
            reenter=draft.reenter,
            # The attributes that `transitions` itself gives it.
            source=source.path,
            dest=", ".join([target.path for target in draft.targets]),
            prepare=[],
            before=[],
            after=[],
            conditions=[] if draft.guard is None else [Guard(draft.guard)],
        )

    @property
    def taking(self) -> Record:
        """The record of its being taken."""
        by = self.kind if self.kind == "always" else f"{self.kind} {self.trigger}"
        step = {"by": by, "from": self.node.path, "to": [target.path for target in self.targets]}
        return "transition", {**step, "name": self.label} if self.label else step


@dataclass(frozen=True, slots=True, eq=False)
class When:
    """A condition with its alternatives."""

    condition: Compiled
    edges: tuple[Edge, ...]


@dataclass(frozen=True, slots=True, eq=False)
class After:
    """A duration with its alternatives."""

    duration: Compiled
    edges: tuple[Edge, ...]


class Node(Frozen, Nested, State):
    """One state, in `transitions`' form. Made by :func:`build_nodes`."""

    local_name: str
    path: str
    """Its full name: ``patrol.follow``; the root's is empty."""
    type: StateType
    mask: int
    """The bit that stands for it in a configuration."""
    where: Where
    description: str
    parent: Node | None
    children: tuple[Node, ...]
    ancestors: tuple[Node, ...]
    """From the parent outwards to the root."""
    given: tuple[Given, ...]
    """Parameters of the included graph whose root this is."""
    initial: tuple[Node, ...]
    """The targets of a default entry: of a compound state, or of a history without content."""
    deep: bool
    """True for a history state that remembers the leaves, and not only the children."""
    entered_slot: int
    """The slot of its time of entry."""
    data: tuple[Data, ...]
    entry: tuple[Action, ...]
    default_actions: tuple[Action, ...]
    """SCXML's actions of a default entry, run after those of the state; a history state's belong
    to its first time."""
    exit_actions: tuple[Action, ...]
    throughout: tuple[Action, ...]
    invocation: Invocation | None
    on: tuple[tuple[str, tuple[Edge, ...]], ...]
    """Transitions by the pattern that their events match."""
    matches: Matching
    whens: tuple[When, ...]
    afters: tuple[After, ...]
    always: tuple[Edge, ...]
    outcome: str
    """The outcome that a final state gives."""
    output: Mapping[str, Compiled]
    entering: Record
    """The record of its being entered."""
    leaving: Record
    """The record of its being left."""
    fills: bool
    """True when an entry sets parameters, data or published values."""
    waits: bool
    """True when an entry arms conditions or starts timers."""

    def __init__(self) -> None:
        """An empty state: all must exist before they can refer to each other."""

    def _fill(
        self, draft: StateDraft, nodes: Sequence[Node], first_slot: int, matches: Matching
    ) -> None:
        path, index = draft.path, draft.index
        parent = None if draft.parent is None else nodes[draft.parent.index]

        def edges(drafts: Iterable[TransitionDraft]) -> tuple[Edge, ...]:
            return tuple([Edge(each, draft, nodes) for each in drafts])

        vars(self).update(
            local_name=draft.name,
            path=path,
            type=draft.type,
            index=index,
            last=draft.last,
            mask=1 << index,
            where=draft.where,
            description=draft.description,
            parent=parent,
            children=tuple([nodes[child.index] for child in draft.children]),
            ancestors=() if parent is None else (parent, *parent.ancestors),
            border=draft.border,
            given=draft.given,
            initial=tuple([nodes[state.index] for state in draft.initial]),
            deep=draft.deep,
            entered_slot=first_slot + index,
            data=draft.data,
            entry=draft.entry,
            default_actions=draft.default_actions,
            exit_actions=draft.exit_actions,
            throughout=draft.throughout,
            invocation=draft.invocation,
            on=tuple([(pattern, edges(drafts)) for pattern, drafts in draft.on]),
            matches=matches,
            whens=tuple([When(condition, edges(drafts)) for condition, drafts in draft.whens]),
            afters=tuple([After(duration, edges(drafts)) for duration, drafts in draft.afters]),
            always=edges(draft.always),
            outcome=draft.outcome,
            output=MappingProxyType(dict(draft.output)),
            entering=("enter", {"state": path}),
            leaving=("exit", {"state": path}),
            fills=bool(draft.given or draft.data or draft.invocation),
            waits=bool(draft.whens or draft.afters),
            # The attributes that `transitions` itself gives it.
            _name=path,
            final=draft.type == "final",
            ignore_invalid_triggers=None,
            on_enter=[],
            on_exit=[],
        )

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

        ``vocabulary`` says which events are urgent: ``*`` does not catch those in a mission.
        """
        found: tuple[Edge, ...] = ()
        matches = self.matches
        for pattern, edges in self.on:
            if matches(pattern, event, vocabulary):
                found += edges
        return found


def build_nodes(draft: Draft, first_slot: int, matches: Matching) -> tuple[Node, ...]:
    """Make the states of a graph, in document order, with their transitions from its draft.

    Each state's time of entry has a slot of its own, from ``first_slot`` on; ``matches`` is the
    rule of the graph's language for events.
    """
    nodes = tuple([Node() for _ in draft])
    for node, state in zip(nodes, draft, strict=True):
        node._fill(state, nodes, first_slot, matches)
    return nodes


class Needed(NamedTuple):
    """What needs a capability of the vehicle."""

    by: str
    """A behaviour, or a value such as ``vehicle.wind``."""
    where: Where


@dataclass(frozen=True, eq=False)
class Graph:
    """A compiled mission. Also what `transitions` calls the machine of an event.

    It never changes: what instances derive from it is kept beside it (:mod:`fsm.engine.shared`).
    """

    name: str
    description: str
    nodes: tuple[Node, ...]
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
    places: Mapping[str, Any]
    """The mission's own places, in the mission frame."""
    outer_first: bool
    """True when outer states take precedence over inner ones in selection."""
    messages: tuple[Message, ...] = ()
    """The events that its actions raise, send and cancel."""
    host_fields: Mapping[str, Where] = field(default_factory=lambda: MappingProxyType({}))
    """What it reads of the host's values, such as ``vehicle.wind``, with the first place."""
    warnings: tuple[Fault, ...] = ()
    send_event: bool = True
    """`transitions`' word for callbacks that take the event's data as their only argument."""
    by_path: Mapping[str, Node] = field(init=False, repr=False)
    source: MissionSpec | None = None
    """The mission it was compiled from."""
    document: Element | None = None
    """The root of the SCXML document it was compiled from, when that is no mission."""
    event_slot: int = -1
    """The slot of ``_event`` in an SCXML document; -1 in a mission."""

    def __post_init__(self) -> None:
        by_path = MappingProxyType({node.path: node for node in self.nodes})
        object.__setattr__(self, "by_path", by_path)

    @property
    def root(self) -> Node:
        return self.nodes[0]

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

    def required(self) -> dict[str, Needed]:
        """Capabilities that the mission needs, each with what needs it first."""
        found: dict[str, Needed] = {}
        for node in self.nodes:
            if node.invocation:
                user = Needed(node.invocation.behavior.name, node.where)
                for capability in sorted(node.invocation.required()):
                    found.setdefault(capability, user)
        for name, where in self.host_fields.items():
            if name in self.vocabulary.needs:
                found.setdefault(self.vocabulary.needs[name], Needed(name, where))
        return found
