"""A running graph: one :class:`Instance` per vehicle, advanced one mission period at a time.

Theory of operation. Selection, conflicts, exit and entry follow the algorithm of SCXML (W3C
recommendation of 2015, appendix D): an event selects at most one transition for each active leaf,
inner states first, in document order; of two whose exit sets meet, the one in the inner state
wins, else the earlier. Taking them is a *microstep*; then come ``always`` transitions and raised
events until nothing moves, which makes a *macrostep*.

Around that core stands the mission period, in a fixed order: events (urgent ones first), then one
round of conditions and timers, then ``throughout`` actions, then the behaviours. No clock is read
and no thread started here: time and host values come in as arguments.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from transitions.core import EventData

from fsm.expressions import Compiled
from fsm.functions import EvaluationError
from fsm.graph import After, Edge, Graph, Node, When, default_entry, entry_set
from fsm.scope import CONFIGURATION_SLOT, FIRST_HOST_SLOT, TIME_SLOT
from fsm.vocabulary import Activity, Host

MAX_MICROSTEPS = 1000
EPSILON = 1e-9
"""Seconds within which two times count as equal."""
FAILURES = (EvaluationError, ArithmeticError, TypeError, ValueError, LookupError, AttributeError)
"""What evaluating a checked expression can still raise, all of it ``error.execution``."""

Record = tuple[str, dict[str, Any]]


class Event(NamedTuple):
    """An event, or an outcome when it has an owner."""

    name: str
    fields: dict[str, Any]
    owner: Node | None = None
    activity: Activity | None = None
    """The behaviour it came from: dropped when that one's state was left meanwhile."""


@dataclass(slots=True)
class Running:
    """The behaviour of an active state."""

    activity: Activity
    ended: bool = False


@dataclass(slots=True)
class Armed:
    """A condition of an active state."""

    when: When
    armed: bool = True
    since: float | None = None
    """When it was last seen to become true."""
    spent: set[int] = field(default_factory=set)
    """Alternatives whose guards have been tested and did not pass."""

    def taken(self) -> None:
        self.armed = False
        self.since = None
        self.spent.clear()


@dataclass(slots=True)
class Timer:
    """A duration of an active state."""

    after: After
    due: float | None


@dataclass(slots=True)
class Delayed:
    """A sent event that waits for its time."""

    due: float
    id: str
    event: Event


class Instance:
    """A graph at work. Also the *model* of `transitions`: ``trigger``, ``is_active``, …"""

    def __init__(
        self, graph: Graph, host: Host, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self.graph = graph
        self.host = host
        self.slots: list[Any] = [None] * graph.slots
        for name, slot in graph.parameter_slots.items():
            given = (parameters or {}).get(name, graph.parameters[name].default)
            self.slots[slot] = given
        self.slots[TIME_SLOT] = 0.0
        self.slots[CONFIGURATION_SLOT] = 0
        self.active: list[Node] = []
        """All active states in document order."""
        self.outcome: str | None = None
        self.output: dict[str, Any] = {}
        self.records: list[Record] = []
        """What happened since somebody last took the list away."""
        self.reactions: list[tuple[str, dict[str, Any]]] = []
        """Events that nobody handled and whose host must react, with their fields."""
        self.period_number = 0
        self._leaves: list[Node] = []
        self._entered_in: dict[int, int] = {}
        self._urgent: deque[Event] = deque()
        self._external: deque[Event] = deque()
        self._internal: deque[Event] = deque()
        self._delayed: list[Delayed] = []
        self._running: dict[int, Running] = {}
        self._conditions: dict[int, list[Armed]] = {}
        self._timers: dict[int, list[Timer]] = {}
        self._finished: set[int] = set()
        self._history: dict[int, tuple[Node, ...]] = {}
        self._kept: dict[int, tuple[dict[int, Any], Mapping[str, Any] | None]] = {}
        self._resumed: dict[int, Mapping[str, Any]] = {}
        self._broken: set[int] = set()
        self._has_history = any(node.type == "history" for node in graph.nodes)

    # -- what others see --------------------------------------------------------------------

    @property
    def now(self) -> float:
        time: float = self.slots[TIME_SLOT]
        return time

    @property
    def ended(self) -> bool:
        return self.outcome is not None

    def paths(self) -> list[str]:
        """The active leaf states, in document order."""
        return [leaf.path for leaf in self._leaves]

    def is_active(self, path: str) -> bool:
        """Whether a state is active. Raises KeyError for a path that does not exist."""
        return self._is_active(self.graph.by_path[path])

    def is_controlled(self, resource: str) -> bool:
        """Whether a behaviour that is at work controls ``motion`` (or another resource)."""
        for node in self.active:
            running = self._running.get(node.index)
            at_work = running is not None and not running.ended and node.invocation is not None
            if at_work and node.invocation and resource in node.invocation.behavior.controls:
                return True
        return False

    def __getattr__(self, name: str) -> Any:
        if name.startswith("is_"):
            named = [node for node in self.graph.nodes if node.local_name == name[3:]]
            if len(named) == 1:
                return lambda: self._is_active(named[0])
        raise AttributeError(name)

    def trigger(self, event: str, **fields: Any) -> bool:
        """Process an event at once, as a macrostep of its own; whether a transition was taken."""
        self._start()
        return self._macrostep(Event(event, fields))

    def may_trigger(self, event: str, **fields: Any) -> bool:
        """Whether an event would take a transition now."""
        return bool(self._select(Event(event, fields)))

    def post(self, name: str, fields: Mapping[str, Any] | None = None) -> None:
        """Queue an event for the next period."""
        event = Event(name, dict(fields or {}))
        urgent = self.graph.vocabulary.is_urgent(name)
        (self._urgent if urgent else self._external).append(event)

    def record(self, what: str, **fields: Any) -> None:
        self.records.append((what, fields))

    # -- the mission period -----------------------------------------------------------------

    def period(self, now: float, host_values: Sequence[Any] = ()) -> None:
        """Advance by one mission period: events, clock and world, throughout, behaviours.

        ``host_values`` are frozen values of the vocabulary's names, in its order.
        """
        self.slots[TIME_SLOT] = now
        self.slots[FIRST_HOST_SLOT : FIRST_HOST_SLOT + len(host_values)] = host_values
        self.period_number += 1
        self._start()
        self._due_sends()
        # What is posted meanwhile belongs to the next period.
        for queue in (self._urgent, self._external):
            for _ in range(len(queue)):
                if self.ended:
                    return
                self._macrostep(queue.popleft())
        if not self.ended:
            self._world_round()
        if not self.ended:
            self._throughout()
        if not self.ended:
            self._behaviors()

    def stop(self, outcome: str | None = None) -> None:
        """End the run: leave all states, inner ones first, with their exit actions."""
        self.outcome = self.outcome or outcome
        for node in reversed(self.active):
            self._exit(node, Event("", {}))
        self._settle(())

    def _start(self) -> None:
        if self.active or self.ended:
            return
        root = self.graph.root
        # A root without states is an atomic state of its own.
        inside = entry_set(root, default_entry(root), lambda history: ()) if root.children else []
        entered = [root, *inside]
        self._settle(entered)
        for node in entered:
            self._enter(node, Event("", {}))
        self._stabilise()

    def _due_sends(self) -> None:
        due = [sent for sent in self._delayed if sent.due <= self.now + EPSILON]
        for sent in due:
            self._delayed.remove(sent)
            self.post(sent.event.name, sent.event.fields)

    # -- events -----------------------------------------------------------------------------

    def raise_event(self, name: str, fields: Mapping[str, Any]) -> None:
        """Queue an event for this macrostep."""
        self._internal.append(Event(name, dict(fields)))

    def send(self, name: str, fields: Mapping[str, Any], delay: float, id_: str) -> None:
        """Queue an event for a later period."""
        self._delayed.append(Delayed(self.now + delay, id_, Event(name, dict(fields))))
        self._delayed.sort(key=lambda sent: sent.due)

    def cancel(self, id_: str) -> None:
        """Take back what was sent with this id and is not due."""
        self._delayed = [sent for sent in self._delayed if sent.id != id_]

    def _macrostep(self, event: Event) -> bool:
        owner = event.owner
        if owner is not None and event.activity is not None:
            running = self._running.get(owner.index)
            if running is None or running.activity is not event.activity:
                return False
        taken = self._offer(event)
        self._stabilise()
        return taken

    def _offer(self, event: Event) -> bool:
        """Let one event take its transitions; whether there were any."""
        edges = self._select(event)
        fields: dict[str, Any] = {"name": event.name}
        if event.owner is not None:
            fields["state"] = event.owner.path
        if event.fields:
            fields["fields"] = event.fields
        self.record("event", **fields, taken=bool(edges))
        if edges:
            self._microstep(edges, event)
        elif self._must_react(event):
            self.reactions.append((event.name, event.fields))
        return bool(edges)

    def _must_react(self, event: Event) -> bool:
        name = event.name
        if name == "failed" or name.startswith("error.") or self.graph.vocabulary.is_urgent(name):
            return self.graph.vocabulary.reaction(name) != "none"
        return False

    def _stabilise(self) -> None:
        """``always`` before raised events, until nothing moves."""
        for _ in range(MAX_MICROSTEPS):
            if self.ended:
                return
            edges = self._pick(lambda node: node.always, Event("", {}))
            if edges:
                self._microstep(edges, Event("", {}))
            elif self._internal:
                self._offer(self._internal.popleft())
            else:
                return
        self._internal.clear()
        message = f"more than {MAX_MICROSTEPS} steps without coming to rest"
        event = Event("error.livelock", {"message": message, "where": ", ".join(self.paths())})
        self.record("error", **event.fields)
        self._offer(event)

    # -- selection --------------------------------------------------------------------------

    def _select(self, event: Event) -> list[Edge]:
        vocabulary, name, owner = self.graph.vocabulary, event.name, event.owner
        if owner is None:
            return self._pick(lambda node: node.edges_for(name, vocabulary), event)
        if not self._is_active(owner):
            return []
        # An outcome goes from its state outwards, never to another region; `done` stays.
        chain = (owner,) if name == "done" else (owner, *owner.ancestors)
        for node in reversed(chain) if self.graph.outer_first else chain:
            for edge in node.edges_for(name, vocabulary):
                if self._passes(edge, event):
                    return [edge]
        return []

    def _pick(self, edges_of: Callable[[Node], Iterable[Edge]], event: Event) -> list[Edge]:
        """For each leaf the first transition of its chain whose guard passes, without conflicts."""
        picked: list[Edge] = []
        tested: dict[int, Edge | None] = {}
        for leaf in self._leaves:
            chain = (leaf, *leaf.ancestors)
            for node in reversed(chain) if self.graph.outer_first else chain:
                if node.index not in tested:
                    tested[node.index] = next(
                        (edge for edge in edges_of(node) if self._passes(edge, event)), None
                    )
                edge = tested[node.index]
                if edge is not None:
                    if edge not in picked:
                        picked.append(edge)
                    break
        return self._without_conflicts(picked) if len(picked) > 1 else picked

    def _passes(self, edge: Edge, event: Event) -> bool:
        if edge.prepare:
            self.graph.callbacks(edge.prepare, self._event_data(edge, event))
        guard = edge.guard
        if guard is not None and self.evaluate(guard, event.fields, False) is not True:
            return False
        if len(edge.conditions) > (guard is not None):
            data = self._event_data(edge, event)
            return all(condition.check(data) for condition in edge.conditions)
        return True

    def _without_conflicts(self, edges: list[Edge]) -> list[Edge]:
        """SCXML's removeConflictingTransitions: exit sets decide."""
        kept: list[Edge] = []
        for edge in edges:
            beaten: list[Edge] = []
            for other in kept:
                if not _in_conflict(edge, other):
                    continue
                inner_wins = other.node.contains(edge.node) and not self.graph.outer_first
                if not inner_wins:
                    break
                beaten.append(other)
            else:
                kept = [other for other in kept if other not in beaten] + [edge]
        return kept

    # -- microsteps -------------------------------------------------------------------------

    def _microstep(self, edges: Sequence[Edge], event: Event) -> None:
        leaving = self._exit_set(edges)
        entering = self._entry_set(edges)
        if self._has_history:
            self._remember(leaving)
        for edge in edges:
            if edge.before:
                self.graph.callbacks(edge.before, self._event_data(edge, event))
        for node in reversed(leaving):
            self._exit(node, event)
        for edge in edges:
            step: dict[str, Any] = {"from": edge.node.path, "to": [t.path for t in edge.targets]}
            if edge.label:
                step["name"] = edge.label
            self.record(
                "transition", by=f"{edge.kind} {edge.trigger}".removesuffix(" always"), **step
            )
            self._run(edge.actions, event)
        left = {node.index for node in leaving}
        remaining = [node for node in self.active if node.index not in left]
        self._settle(sorted([*remaining, *entering], key=lambda node: node.index))
        for node in entering:
            self._enter(node, event)
        for edge in edges:
            if edge.after:
                self.graph.callbacks(edge.after, self._event_data(edge, event))

    def _exit_set(self, edges: Iterable[Edge]) -> list[Node]:
        domains = [edge.domain for edge in edges if edge.domain is not None]
        return [node for node in self.active if any(domain.contains(node) for domain in domains)]

    def _entry_set(self, edges: Sequence[Edge]) -> list[Node]:
        entering: dict[int, Node] = {}
        for edge in edges:
            if edge.domain is None:
                continue
            entered = edge.entered
            if entered is None:
                entered = tuple(entry_set(edge.domain, edge.targets, self._recorded))
            entering.update((node.index, node) for node in entered)
        return [entering[index] for index in sorted(entering)]

    def _settle(self, active: Sequence[Node]) -> None:
        self.active = list(active)
        self._leaves = [node for node in self.active if not node.children]
        mask = 0
        for node in self.active:
            mask |= 1 << node.index
        self.slots[CONFIGURATION_SLOT] = mask

    def _enter(self, node: Node, event: Event) -> None:
        index, slots = node.index, self.slots
        slots[node.entered_slot] = self.now
        self._entered_in[index] = self.period_number
        kept = self._kept.pop(index, None) if index in self._kept else None
        for data in node.data:
            slots[data.slot] = self.evaluate(data.initial, event.fields, None)
        if kept is not None:
            for slot, value in kept[0].items():
                slots[slot] = value
            if kept[1] is not None:
                self._resumed[index] = kept[1]
        if node.invocation and node.invocation.slot >= 0:
            slots[node.invocation.slot] = node.invocation.behavior.blank
        self.record("enter", state=node.path)
        if node.on_enter:
            self.graph.callbacks(node.on_enter, self._event_data(None, event))
        self._run(node.entry, event)
        if node.whens:
            self._conditions[index] = [Armed(when) for when in node.whens]
        if node.afters:
            self._timers[index] = [self._timer(after, event) for after in node.afters]
        if node.type == "final":
            self._reached(node, event)

    def _timer(self, after: After, event: Event) -> Timer:
        duration = self.evaluate(after.duration, event.fields, None)
        due = self.now + duration if isinstance(duration, (int, float)) else None
        return Timer(after, due)

    def _reached(self, final: Node, event: Event) -> None:
        """A final state was entered: its parent has an outcome."""
        output = {
            name: self.evaluate(value, event.fields, None) for name, value in final.output.items()
        }
        parent = final.parent
        assert parent is not None
        if parent.parent is None:
            self.outcome, self.output = final.outcome, output
            return
        self._internal.append(Event(final.outcome, output, parent))
        self._region_finished(parent)

    def _region_finished(self, region: Node) -> None:
        parallel = region.parent
        if parallel is not None and parallel.type == "parallel" and self._is_finished(parallel):
            self._internal.append(Event("done", {}, parallel))
            self._region_finished(parallel)

    def _is_finished(self, node: Node) -> bool:
        if node.type == "parallel":
            return all(self._is_finished(region) for region in default_entry(node))
        if node.children:
            return any(c.type == "final" and self._is_active(c) for c in node.children)
        return node.index in self._finished

    def _exit(self, node: Node, event: Event) -> None:
        index = node.index
        self._run(node.exit_actions, event)
        if node.on_exit:
            self.graph.callbacks(node.on_exit, self._event_data(None, event))
        running = self._running.pop(index, None)
        if running is not None:
            if not running.ended:
                self.record("stop", state=node.path)
            running.activity.stop()
        self._conditions.pop(index, None)
        self._timers.pop(index, None)
        self._resumed.pop(index, None)
        self._finished.discard(index)
        self.record("exit", state=node.path)

    # -- history ----------------------------------------------------------------------------

    def _remember(self, leaving: Sequence[Node]) -> None:
        """Keep what a history state gives back: configuration, data, progress."""
        for node in leaving:
            for child in node.children:
                if child.type != "history":
                    continue
                if child.deep:
                    kept = [leaf for leaf in self._leaves if node.contains(leaf)]
                else:
                    kept = [other for other in node.children if self._is_active(other)]
                self._history[child.index] = tuple(kept)
                for restored in self.active:
                    inside = node is restored or node.contains(restored)
                    if inside and (child.deep or restored is node or restored in kept):
                        self._keep(restored)

    def _keep(self, node: Node) -> None:
        running = self._running.get(node.index)
        progress = running.activity.progress() if running and not running.ended else None
        self._kept[node.index] = ({d.slot: self.slots[d.slot] for d in node.data}, progress)

    def _recorded(self, history: Node) -> tuple[Node, ...]:
        return self._history.get(history.index) or history.initial

    # -- clock and world --------------------------------------------------------------------

    def _world_round(self) -> None:
        """One round over the states active since before this period."""
        offers: dict[int, tuple[Edge, Armed | Timer]] = {}
        for node in self.active:
            if self._entered_in[node.index] < self.period_number and (node.whens or node.afters):
                offer = self._world_offer(node)
                if offer is not None:
                    offers[node.index] = offer
        if not offers:
            return
        event = Event("", {})
        edges = self._pick(
            lambda node: (offers[node.index][0],) if node.index in offers else (), event
        )
        for edge in edges:
            source = offers[edge.node.index][1]
            if isinstance(source, Armed):
                source.taken()
            else:
                source.due = None
        if edges:
            self._microstep(edges, event)
            self._stabilise()

    def _world_offer(self, node: Node) -> tuple[Edge, Armed | Timer] | None:
        """The first due transition of a state; every condition is tested, for its edges."""
        offer: tuple[Edge, Armed | Timer] | None = None
        for condition in self._conditions.get(node.index, ()):
            self._observe(condition)
            if offer is None and condition.armed and condition.since is not None:
                edge = self._due(condition)
                offer = (edge, condition) if edge is not None else None
        for timer in self._timers.get(node.index, ()):
            if offer is None and timer.due is not None and timer.due <= self.now + EPSILON:
                edge = self._first_passing(timer.after.edges)
                if edge is None:
                    timer.due = None
                else:
                    offer = (edge, timer)
        return offer

    def _observe(self, condition: Armed) -> None:
        if self.evaluate(condition.when.condition, {}, False) is True:
            if condition.since is None and condition.armed:
                condition.since = self.now
        elif not self._is_pending(condition):
            condition.armed = True
            condition.since = None
            condition.spent.clear()

    def _is_pending(self, condition: Armed) -> bool:
        """Due, but another transition went first: kept until its guards have been tested."""
        return (
            condition.armed
            and condition.since is not None
            and any(
                edge.hold is None and index not in condition.spent and condition.since < self.now
                for index, edge in enumerate(condition.when.edges)
            )
        )

    def _due(self, condition: Armed) -> Edge | None:
        edges, since = condition.when.edges, condition.since or 0.0
        for index, edge in enumerate(edges):
            if index in condition.spent:
                continue
            if edge.hold is not None:
                hold = self.evaluate(edge.hold, {}, None)
                if hold is None or self.now - since < hold - EPSILON:
                    continue
            if self._passes(edge, Event("", {})):
                return edge
            condition.spent.add(index)
        if len(condition.spent) == len(edges):
            condition.taken()
        return None

    def _first_passing(self, edges: Iterable[Edge]) -> Edge | None:
        event = Event("", {})
        return next((edge for edge in edges if self._passes(edge, event)), None)

    # -- throughout and behaviours ----------------------------------------------------------

    def _throughout(self) -> None:
        raised = len(self._internal)
        for node in self.active:
            self._run(node.throughout, Event("", {}))
        while len(self._internal) > raised:
            # What `throughout` raises is heard in the next period.
            event = self._internal.pop()
            self._external.appendleft(event)

    def _behaviors(self) -> None:
        for node in self.active:
            invocation = node.invocation
            if invocation is None:
                continue
            running = self._running.get(node.index)
            if running is None:
                running = self._running[node.index] = Running(self._begin(node))
            if running.ended:
                continue
            live = {
                name: value
                for name, compiled in invocation.live.items()
                if (value := self.evaluate(compiled, {}, None)) is not None
            }
            outcome = running.activity.step(live)
            if invocation.slot >= 0:
                self.slots[invocation.slot] = running.activity.published
            if outcome is not None:
                running.ended = True
                if outcome.word == "done":
                    self._finished.add(node.index)
                    self._region_finished(node)
                self._external.append(
                    Event(outcome.word, dict(outcome.fields), node, running.activity)
                )

    def _begin(self, node: Node) -> Activity:
        invocation = node.invocation
        assert invocation is not None
        values = {
            name: self.evaluate(compiled, {}, None)
            for name, compiled in (*invocation.with_.items(), *invocation.live.items())
        }
        self.record("start", state=node.path, do=invocation.behavior.name, **{"with": values})
        progress = self._resumed.pop(node.index, None)
        return self.host.begin(invocation.behavior, node.path, values, progress)

    # -- evaluation -------------------------------------------------------------------------

    def evaluate(self, compiled: Compiled, event: dict[str, Any], otherwise: Any) -> Any:
        """The value of an expression; when it has none, ``otherwise`` and ``error.execution``."""
        try:
            value = compiled.function(self.slots, event)
        except FAILURES as error:
            self._failed(compiled, error)
            return otherwise
        if self._broken:
            self._broken.discard(id(compiled))
        return value

    def _failed(self, compiled: Compiled, error: Exception) -> None:
        """Raised once, until the expression works again."""
        if id(compiled) in self._broken:
            return
        self._broken.add(id(compiled))
        fields = {"message": f"{compiled.source}: {error}", "where": str(compiled.where)}
        self.record("error", **fields)
        self._internal.append(Event("error.execution", fields))

    def _run(self, actions: Sequence[Any], event: Event) -> None:
        """Run a block; when one of its actions fails, the rest is skipped."""
        for action in actions:
            try:
                action.run(self, event.fields)
            except FAILURES as error:
                fields = {"message": f"{action.kind}: {error}", "where": ", ".join(self.paths())}
                self.record("error", **fields)
                self._internal.append(Event("error.execution", fields))
                return

    def _is_active(self, node: Node) -> bool:
        configuration: int = self.slots[CONFIGURATION_SLOT]
        return bool(configuration >> node.index & 1)

    def _event_data(self, edge: Edge | None, event: Event) -> EventData:
        # `transitions` asks for its own machine and event here; ours offer what callbacks use.
        machine: Any = self.graph
        name: Any = event.name
        state = self._leaves[0] if self._leaves else None
        data = EventData(state, name, machine, self, [], event.fields)
        data.transition = edge
        return data


def _in_conflict(a: Edge, b: Edge) -> bool:
    """Whether the exit sets of two transitions can meet."""
    if a.domain is None or b.domain is None:
        return False
    return a.domain is b.domain or a.domain.contains(b.domain) or b.domain.contains(a.domain)
