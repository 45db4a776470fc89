"""The interpreter: takes events, and brings the running state from one configuration to the next.

Theory of operation. Selection, conflicts, exit and entry follow the algorithm of SCXML (W3C
recommendation of 2015, appendix D): an event selects at most one transition for each active leaf,
inner states first, in document order; of two whose exit sets meet, the one in the inner state
wins, else the earlier. Taking them is a *microstep*: states are left with their exit actions,
the transitions' own actions run, states are entered with their data, entry actions, conditions
and timers. Then come ``always`` transitions and raised events until nothing moves, which makes a
*macrostep*.

The configuration changes state by state (W3C section 3.13): a state is active while its exit
actions run and no longer after them, and becomes active just before its entry actions. So
``active(…)`` in an action, and callbacks that ask, see what has happened so far in the step.

When events, conditions and timers have their turn is decided in :mod:`fsm.engine.instance`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import Any, Self

from transitions.core import EventData

from fsm.chart.configuration import Entry, Step, entry_after
from fsm.chart.entry_sets import default_entry, entry_set, transition_domain
from fsm.chart.executable import (
    EXTERNAL,
    INTERNAL,
    PLATFORM,
    Action,
    NotSentError,
    Origin,
    Record,
)
from fsm.chart.graph import After, Edge, Graph, Node
from fsm.chart.selection import chain, select
from fsm.engine.events import NOTHING, Delayed, Event
from fsm.engine.history import Memory, Progress, remember
from fsm.engine.shared import Shared, shared_by
from fsm.engine.state import State
from fsm.engine.waiting import Armed, Timer
from fsm.expressions.compiled import Compiled
from fsm.expressions.scope import CONFIGURATION_SLOT, TIME_SLOT
from fsm.host import Host
from fsm.values.functions import FAILURES, plain
from vencejo.errors import Where

MAX_MICROSTEPS = 1000
MISSING = object()
"""The value of an output that could not be evaluated."""


class Interpreter:
    """Runs a graph. Also the *model* of `transitions`: ``trigger``, ``is_active``, callbacks."""

    _shared: Shared
    """Held for as long as this lives; it also gives each graph's instances their class."""

    def __new__(cls, graph: Graph, *_: Any, **__: Any) -> Self:
        shared = shared_by(graph)
        instance: Self = super().__new__(shared.model_of(cls))
        instance._shared = shared
        return instance

    def __init__(
        self, graph: Graph, host: Host, parameters: Mapping[str, Any] | None = None
    ) -> None:
        self.graph = graph
        self.host = host
        self.records: list[Record] = []
        """The records made since the caller last replaced this list by an empty one."""
        self._configurations = self._shared.configurations
        self._has_history = self._shared.has_history
        self._narrows = self._shared.narrows
        self._callback_data: EventData | None = None
        """The argument of the entry and exit callbacks of the present microstep."""
        values: list[Any] = [None] * graph.slots
        for name, slot in graph.parameter_slots.items():
            values[slot] = (parameters or {}).get(name, graph.parameters[name].default)
        values[TIME_SLOT] = 0.0
        self.go_on_from(State(values, self._configurations[0]))

    def go_on_from(self, state: State) -> None:
        """Make this the running state."""
        self.state = state
        self.slots = state.values
        """The values of the state, as actions and compiled expressions know them."""

    # -- questions --------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """Seconds of the vehicle's clock."""
        time: float = self.slots[TIME_SLOT]
        return time

    @property
    def active(self) -> Sequence[Node]:
        """All active states in document order."""
        return self._configurations[self.slots[CONFIGURATION_SLOT]].states

    @property
    def ended(self) -> bool:
        """Whether the mission has an outcome."""
        return self.state.outcome is not None

    @property
    def outcome(self) -> str | None:
        """The outcome of the mission; None while it has not ended."""
        return self.state.outcome

    @property
    def output(self) -> dict[str, Any]:
        """The output of the final state that ended the mission."""
        return self.state.output

    @property
    def reactions(self) -> list[tuple[str, dict[str, Any]]]:
        """Events that no state handled and whose host must react, with their fields."""
        return self.state.reactions

    @reactions.setter
    def reactions(self, left: list[tuple[str, dict[str, Any]]]) -> None:
        self.state.reactions = left

    def paths(self) -> list[str]:
        """The active leaf states, in document order."""
        return [node.path for node in self.active if not node.children]

    def is_active(self, path: str) -> bool:
        """Whether a state is active. Raises KeyError for a path that does not exist."""
        return self._is_active(self.graph.by_path[path])

    def _is_active(self, node: Node) -> bool:
        return bool(self.slots[CONFIGURATION_SLOT] & node.mask)

    # -- events -----------------------------------------------------------------------------

    def trigger(self, event: str, **fields: Any) -> bool:
        """Process an event at once, as a macrostep of its own; whether a transition was taken."""
        if not self.state.configuration.states:
            self.start()
        return self.state.outcome is None and self.macrostep(Event(event, fields))

    def may_trigger(self, event: str, **fields: Any) -> bool:
        """Whether an event would take a transition now. Changes nothing."""
        trial = object.__new__(type(self))
        vars(trial).update(vars(self), records=[])
        trial.go_on_from(self.state.copy())
        heard = Event(event, fields)
        trial._show(heard)
        return not self.ended and bool(trial._select(heard))

    def raise_event(self, name: str, fields: Mapping[str, Any], origin: Origin = INTERNAL) -> None:
        """Queue an event for this macrostep."""
        self.state.internal.append(Event(name, dict(fields), origin=origin))

    def send(
        self,
        name: str,
        fields: Mapping[str, Any],
        delay: float,
        id_: str,
        to: str = "",
        origin: Origin = EXTERNAL,
    ) -> None:
        """Queue an event for a later period, or give it to the host for another vehicle.

        ``delay`` is in seconds; ``id_`` is what :meth:`cancel` knows it by.
        """
        if to and delay <= 0:
            # At once: this may be the last thing that the mission does.
            self.deliver(name, fields, to)
            return
        event = Event(name, dict(fields), origin=origin)
        self.state.delayed.put(Delayed(self.now + delay, id_, event, to))

    def deliver(self, name: str, fields: Mapping[str, Any], to: str) -> None:
        """Give an event to the host for another vehicle."""
        self.record("send", event=name, to=to, fields=dict(fields))
        self.host.send(name, fields, to)

    def cancel(self, id_: str) -> None:
        """Take back what was sent with this id and is not due."""
        self.state.delayed.cancel(id_)

    def record(self, what: str, **fields: Any) -> None:
        """Add to the records."""
        self.records.append((what, fields))

    # -- macrosteps -------------------------------------------------------------------------

    def start(self) -> None:
        """Enter the initial states, as a macrostep; nothing when that was done before."""
        state = self.state
        if state.configuration.states or state.outcome is not None:
            return
        root = self.graph.root
        found = entry_set(root, default_entry(root), self.recorded)
        entry = entry_after(0, (root, *found.states), found.histories, found.defaults)
        state.configuration = self._configurations[entry.mask]
        for node, mask in entry.states:
            self.slots[CONFIGURATION_SLOT] = mask
            self._enter(node, NOTHING, entry)
        self.stabilise()

    def stop(self, outcome: str = "stopped") -> None:
        """End the run: leave all states, inner ones first, with their exit actions."""
        state = self.state
        state.outcome = state.outcome or outcome
        self._callback_data = None
        for node in reversed(state.configuration.states):
            self._exit(node, NOTHING)
            self.slots[CONFIGURATION_SLOT] ^= node.mask
        state.configuration = self._configurations[0]

    def abandon(self, outcome: str) -> None:
        """End the run where it is, also in the midst of a step: nothing else happens any more."""
        self.state.outcome = outcome
        self.state.configuration = self._configurations[0]
        self.slots[CONFIGURATION_SLOT] = 0

    def macrostep(self, event: Event) -> bool:
        """Process one event until the graph is stable; whether it took a transition."""
        taken = self._offer(event)
        if self.state.internal or self.state.configuration.always:
            self.stabilise()
        return taken

    def _offer(self, event: Event) -> bool:
        """Let an event take its transitions; whether there were any.

        The outcome of a state that was left meanwhile is dropped. When no state takes an event
        that must be handled, it is added to the reactions that the host owes.
        """
        owner = event.owner
        if owner is not None and not (
            self._is_active(owner) and self.state.entries[owner.index] == event.entry
        ):
            return False
        if self.graph.event_slot >= 0:
            self._show(event)
        edges = self._select(event)
        shown: dict[str, Any] = {"name": event.name}
        if owner is not None:
            shown["state"] = owner.path
        if event.fields:
            shown["fields"] = event.fields
        shown["taken"] = bool(edges)
        self.records.append(("event", shown))
        if edges:
            self.microstep(edges, event)
        elif owner is self.graph.root:
            # Every region of a parallel mission has finished.
            self.state.outcome = event.name
        elif self._is_for_host(event.name):
            self.state.reactions.append((event.name, event.fields))
        return bool(edges)

    def _show(self, event: Event) -> None:
        """Keep an event in the variable ``_event``, where SCXML has it until the next one comes."""
        if self.graph.event_slot >= 0:
            self.slots[self.graph.event_slot] = event.as_variable()

    def _is_for_host(self, name: str) -> bool:
        """Whether the host must react when no active state handles this event."""
        vocabulary = self.graph.vocabulary
        if name == "failed" or name.startswith("error.") or vocabulary.is_urgent(name):
            return vocabulary.reaction(name) in ("land", "suspend")
        return False

    def stabilise(self) -> None:
        """Take ``always`` transitions and raised events until the graph is stable.

        After MAX_MICROSTEPS there is the event ``error.livelock``, which may lead out.
        """
        if self._becomes_stable():
            return
        self.state.internal.clear()
        message = f"more than {MAX_MICROSTEPS} steps without coming to rest"
        fields = {"message": message, "where": ", ".join(self.paths())}
        event = Event("error.livelock", fields, origin=PLATFORM)
        self.record("error", **event.fields)
        if self._offer(event) and not self._becomes_stable():
            self.state.internal.clear()

    def _becomes_stable(self) -> bool:
        """Take steps until the graph is stable; False when MAX_MICROSTEPS were not enough."""
        state = self.state
        for _ in range(MAX_MICROSTEPS):
            if state.outcome is not None:
                return True
            edges = self._select_always()
            if edges:
                self.microstep(edges, NOTHING)
            elif state.internal:
                self._offer(state.internal.popleft())
            else:
                return True
        return False

    # -- selection --------------------------------------------------------------------------

    def _select(self, event: Event) -> tuple[Edge, ...]:
        """The transitions that an event takes."""
        configuration = self.state.configuration
        if event.owner is None and len(configuration.leaves) == 1:
            for edge in configuration.edges_in_order(event.name):
                if self.passes(edge, event):
                    return (edge,)
            return ()
        return self._select_widely(event)

    def _select_widely(self, event: Event) -> tuple[Edge, ...]:
        """The transitions of an event in parallel regions, or of an outcome."""
        configuration = self.state.configuration
        name, owner, outer_first = event.name, event.owner, self.graph.outer_first
        edges = configuration.edges_by_state(name)

        def choose(node: Node) -> Edge | None:
            return self.first_passing(edges.get(node.index, ()), event)

        if owner is None:
            return tuple(select(configuration.leaves, choose, self.recorded, outer_first))
        # An outcome goes from its state outwards, never to another region; `done` stays.
        asked = (owner,) if name == "done" else chain(owner, outer_first)
        if name not in ("done", "failed"):
            # Nor, but for `failed`, out of an included graph.
            within = tuple(owner.outwards())
            asked = [node for node in asked if node in within]
        edge = next((edge for node in asked if (edge := choose(node)) is not None), None)
        return () if edge is None else (edge,)

    def _select_always(self) -> tuple[Edge, ...]:
        configuration = self.state.configuration
        if not configuration.always:
            return ()
        edges = select(
            configuration.leaves,
            lambda node: self.first_passing(node.always, NOTHING) if node.always else None,
            self.recorded,
            self.graph.outer_first,
        )
        return tuple(edges)

    def first_passing(self, edges: Iterable[Edge], event: Event) -> Edge | None:
        """The first of these transitions whose guard passes."""
        for edge in edges:
            if self.passes(edge, event):
                return edge
        return None

    def passes(self, edge: Edge, event: Event) -> bool:
        """Whether a transition's guard and further conditions pass for this event."""
        if edge.prepare:
            self.graph.callbacks(edge.prepare, self._event_data(edge, event))
        if not edge.conditions:
            return True
        guard = edge.guard
        if guard is not None and self.evaluate(guard, event.fields, False) is not True:
            return False
        return len(edge.conditions) == (guard is not None) or self._others_pass(edge, event)

    def _others_pass(self, edge: Edge, event: Event) -> bool:
        """Whether the conditions pass that were added to the compiled transition."""
        data = self._event_data(edge, event)
        return all(condition.check(data) for condition in edge.conditions)

    # -- microsteps -------------------------------------------------------------------------

    def microstep(self, edges: tuple[Edge, ...], event: Event) -> None:
        """Take transitions that do not conflict; ``event`` is what caused it."""
        state, slots = self.state, self.slots
        step = state.configuration.step(edges, self._narrowed(edges) if self._narrows else ())
        self._callback_data = None
        memories = self._remember(step) if self._has_history else ()
        entry = step.entry or self._open_entry(step)
        for edge in edges:
            if edge.before:
                self.graph.callbacks(edge.before, self._event_data(edge, event))
        for node, mask in step.leaving:
            self._exit(node, event)
            slots[CONFIGURATION_SLOT] = mask
        for edge, record in step.taken:
            self.records.append(record)
            if edge.actions:
                self.run_actions(edge.actions, event.fields)
        # Last, since exit actions and the transition's own may still have changed them.
        for memory in memories:
            memory.keep_data(slots)
        state.configuration = self._configurations[entry.mask]
        for node, mask in entry.states:
            slots[CONFIGURATION_SLOT] = mask
            self._enter(node, event, entry)
        for edge in edges:
            if edge.after:
                self.graph.callbacks(edge.after, self._event_data(edge, event))

    def _open_entry(self, step: Step) -> Entry:
        """The states that a step with open transitions enters, looked up in the present history."""
        entering = {node.index: node for node in step.entering}
        histories: list[Node] = []
        defaults: dict[int, list[Node]] = {}
        for edge, domain in step.open:
            found = entry_set(domain, edge.targets, self.recorded)
            entering.update(found.entering)
            histories += found.histories
            for index, nodes in found.defaults.items():
                defaults.setdefault(index, []).extend(nodes)
        states = [entering[index] for index in sorted(entering)]
        return entry_after(step.mask, states, histories, defaults)

    def _enter(self, node: Node, event: Event, entry: Entry) -> None:
        state, slots = self.state, self.slots
        index = node.index
        slots[node.entered_slot] = slots[TIME_SLOT]
        state.entries[index] = state.entry_count = state.entry_count + 1
        if node.fills:
            self._fill(node, event, entry)
        self.records.append(node.entering)
        if node.on_enter:
            self._call(node.on_enter, event)
        if node.entry:
            self.run_actions(node.entry, event.fields)
        if entry.defaults:
            for default in entry.defaults.get(index, ()):
                self.run_actions(default.default_actions, event.fields)
        if node.waits:
            self._arm(node, event)
        if node.final:
            self._reach(node, event)

    def _fill(self, node: Node, event: Event, entry: Entry) -> None:
        """Give values to what begins anew with an entry: parameters, data, published values."""
        slots = self.slots
        memory = self._memory_of(node, entry) if entry.histories else None
        if node.given:
            self._give(node)
        for data in node.data:
            slots[data.slot] = (
                memory.data[data.slot]
                if memory
                else self.evaluate(data.initial, event.fields, None)
            )
        if memory and node.index in memory.progress:
            self.state.resumed[node.index] = memory.progress[node.index]
        if node.invocation and node.invocation.slot >= 0:
            slots[node.invocation.slot] = node.invocation.behavior.blank

    def _give(self, root: Node) -> None:
        """Fill the parameters of an included graph; one without value makes it `failed`."""
        for given in root.given:
            value = None
            if given.live is not None:
                value = self.evaluate(given.live, {}, None)
            elif given.with_ is not None:
                try:
                    value = given.with_.function(self.slots, {})
                except FAILURES as error:
                    reason = f"the parameter '{given.name}' has no value: {plain(error)}"
                    failed = self.outcome_of(root.owner, "failed", {"reason": reason})
                    self.state.internal.append(failed)
            self.slots[given.slot] = given.default if value is None else value

    def _arm(self, node: Node, event: Event) -> None:
        """Begin to wait for the conditions and timers of an entered state."""
        if node.whens:
            self.state.conditions[node.index] = [Armed(when) for when in node.whens]
        if node.afters:
            self.state.timers[node.index] = [self._timer(after, event) for after in node.afters]

    def _timer(self, after: After, event: Event) -> Timer:
        duration = self.evaluate(after.duration, event.fields, None)
        due = self.now + duration if isinstance(duration, (int, float)) else None
        return Timer(after, due)

    def _reach(self, final: Node, event: Event) -> None:
        """Queue the outcome of an entered final state for its parent, or end the mission."""
        # In SCXML what has no value is left out, here it is none.
        otherwise = MISSING if self.graph.scxml else None
        found = {
            name: self.evaluate(value, event.fields, otherwise)
            for name, value in final.output.items()
        }
        output = {name: value for name, value in found.items() if value is not MISSING}
        assert final.parent is not None
        parent = final.parent.owner
        state = self.state
        if parent.parent is None:
            state.outcome, state.output = final.outcome, output
            return
        state.internal.append(self.outcome_of(parent, final.outcome, output))
        self.finish_region(parent, state.internal)

    def _exit(self, node: Node, event: Event) -> None:
        if node.exit_actions:
            self.run_actions(node.exit_actions, event.fields)
        if node.on_exit:
            self._call(node.on_exit, event)
        if node.invocation is not None:
            self._stop(node)
        if node.waits:
            self.state.conditions.pop(node.index, None)
            self.state.timers.pop(node.index, None)
        self.records.append(node.leaving)

    def _stop(self, node: Node) -> None:
        """Stop the behaviour of a state that is left, unless it has not begun."""
        state, index = self.state, node.index
        running = state.running.pop(index, None)
        if running is not None and running.activity is not None:
            if not running.ended:
                self.records.append(("stop", {"state": node.path}))
            running.activity.stop()
        state.resumed.pop(index, None)
        state.finished.discard(index)

    # -- outcomes ---------------------------------------------------------------------------

    def outcome_of(self, owner: Node, word: str, fields: Mapping[str, Any]) -> Event:
        """The outcome of an active state, as an event; in SCXML it is ``done.state.ID``."""
        if self.graph.scxml:
            return Event(f"done.state.{owner.path}", dict(fields), origin=PLATFORM)
        return Event(word, dict(fields), owner, self.state.entries[owner.index])

    def finish_region(self, region: Node, queue: deque[Event]) -> None:
        """Queue the ``done`` of the parallel states whose last region has finished with this."""
        parallel = region.parent
        if parallel is not None and parallel.type == "parallel" and self._is_finished(parallel):
            queue.append(self.outcome_of(parallel.owner, "done", {}))
            self.finish_region(parallel.owner, queue)

    def _is_finished(self, node: Node) -> bool:
        """Whether a final child of a region is active, or its behaviour has ended in ``done``."""
        if node.type == "parallel":
            return all(self._is_finished(region) for region in default_entry(node))
        if node.children and node.children[0].border:
            return self._is_finished(node.children[0])
        if node.children:
            return any(c.type == "final" and self._is_active(c) for c in node.children)
        return node.index in self.state.finished

    # -- history ----------------------------------------------------------------------------

    def _remember(self, step: Step) -> Iterable[Memory]:
        """The memories that a step makes; their data are kept when its actions have run."""
        state = self.state
        leaving = [node for node, _ in reversed(step.leaving)]
        memories = remember(leaving, state.configuration.states, self._progress)
        state.memories.update(memories)
        return memories.values()

    def _progress(self, node: Node) -> Progress | None:
        running = self.state.running.get(node.index)
        if running is None:
            # It has not been started yet: the progress it is to go on from still holds.
            return self.state.resumed.get(node.index)
        return running.activity.progress() if running.activity and not running.ended else None

    def _narrowed(self, edges: Iterable[Edge]) -> tuple[Node | None, ...]:
        """The present domains of those transitions where history decides on them."""
        return tuple([transition_domain(edge, self.recorded) for edge in edges if edge.by_history])

    def recorded(self, history: Node) -> tuple[Node, ...] | None:
        """The states that a history state stands for; None when its parent was never left."""
        memory = self.state.memories.get(history.index)
        return None if memory is None else memory.states

    def _memory_of(self, node: Node, entry: Entry) -> Memory | None:
        """The memory that gives back the data and progress of an entered state."""
        memories = (self.state.memories[history.index] for history in entry.histories)
        return next((memory for memory in memories if node in memory.kept), None)

    # -- evaluation -------------------------------------------------------------------------

    def evaluate(self, compiled: Compiled, fields: dict[str, Any], otherwise: Any) -> Any:
        """The value of an expression for an event with these fields.

        One that fails has the value ``otherwise``, and ``error.execution`` is raised.
        """
        try:
            value = compiled.function(self.slots, fields)
        except FAILURES as error:
            self._failed(compiled.where, compiled.source, error)
            return otherwise
        broken = self.state.broken
        if broken:
            broken.discard((compiled.where, compiled.source))
        return value

    def run_actions(self, actions: Sequence[Action], fields: dict[str, Any]) -> None:
        """Run a block for an event with these fields; when an action fails, the rest is skipped."""
        for action in actions:
            try:
                action.run(self, fields)
            except FAILURES as error:
                self._failed(action.where, action.kind, error)
                return
            if self.state.broken:
                self.state.broken.discard((action.where, action.kind))

    def _failed(self, where: Where, what: str, error: Exception) -> None:
        """Raise ``error.execution``, once until this works again; in SCXML whenever it fails."""
        if not self.graph.scxml:
            if (where, what) in self.state.broken:
                return
            self.state.broken.add((where, what))
        # Without its folder: the same mission logs the same wherever it lies.
        place = replace(where, file=PurePath(where.file).name)
        fields = {"message": f"{what}: {plain(error)}", "where": str(place)}
        self.record("error", **fields)
        name, origin = "error.execution", PLATFORM
        if isinstance(error, NotSentError):
            name, origin = error.event, replace(PLATFORM, sendid=error.sendid)
        self.state.internal.append(Event(name, fields, origin=origin))

    # -- callbacks --------------------------------------------------------------------------

    def _call(self, callbacks: Iterable[Any], event: Event) -> None:
        """Run entry or exit callbacks; all of a microstep are given the same data."""
        data = self._callback_data
        if data is None:
            data = self._callback_data = self._event_data(None, event)
        for callback in callbacks:
            if isinstance(callback, str):
                callback = self.graph.resolve_callable(callback, data)
            callback(data)

    def _event_data(self, edge: Edge | None, event: Event) -> EventData:
        # `transitions` asks for its own machine and event here; ours offer what callbacks use.
        machine: Any = self.graph
        name: Any = event.name
        leaves = self.state.configuration.leaves
        data = EventData(leaves[0] if leaves else None, name, machine, self, [], event.fields)
        data.transition = edge
        return data
