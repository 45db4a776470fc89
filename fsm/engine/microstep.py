"""The configuration of a running graph, and the microsteps that change it.

Everything that lies between one stable configuration and the next: leaving states and entering
them with their actions, data, conditions, timers and history, and evaluating expressions over the
instance's slots. When which step is taken is decided in :mod:`fsm.engine.instance`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from transitions.core import EventData

from fsm.chart.configuration import Step, active
from fsm.chart.entry_sets import default_entry, entry_set
from fsm.chart.executable import Action
from fsm.chart.graph import After, Edge, Graph, Node, Record
from fsm.chart.model import model_class
from fsm.engine.events import Event
from fsm.engine.history import Memory, Progress, remember
from fsm.engine.waiting import Armed, Timer
from fsm.expressions.compiled import Compiled
from fsm.expressions.scope import CONFIGURATION_SLOT, TIME_SLOT
from fsm.host import Activity
from fsm.values.functions import FAILURES, plain
from vencejo.errors import Where


@dataclass(slots=True)
class Running:
    """The behaviour of an active state; no activity when it could not be started."""

    activity: Activity | None
    ended: bool = False


class Configuration:
    """Which states of a graph are active, and everything that hangs on that."""

    def __new__(cls, graph: Graph, *_: Any, **__: Any) -> Self:
        instance: Self = super().__new__(model_class(cls, graph))
        return instance

    def __init__(self, graph: Graph, parameters: Mapping[str, Any] | None = None) -> None:
        self.graph = graph
        self.slots: list[Any] = [None] * graph.slots
        for name, slot in graph.parameter_slots.items():
            given = (parameters or {}).get(name, graph.parameters[name].default)
            self.slots[slot] = given
        self.slots[TIME_SLOT] = 0.0
        self.slots[CONFIGURATION_SLOT] = 0
        self._here = active(graph, 0)
        self._hooks: EventData | None = None
        self.outcome: str | None = None
        self.output: dict[str, Any] = {}
        self.records: list[Record] = []
        """What happened since somebody last took the list away."""
        self._internal: deque[Event] = deque()
        self._running: dict[int, Running] = {}
        self._conditions: dict[int, list[Armed]] = {}
        self._timers: dict[int, list[Timer]] = {}
        self._finished: set[int] = set()
        self._entries: dict[int, int] = {}
        """The number of each state's latest entry."""
        self._entry_count = 0
        self._entered_before = 0
        """The last entry before the present period."""
        self._memories: dict[int, Memory] = {}
        self._restoring: list[Memory] = []
        """The memories that the microstep at work gives back."""
        self._defaults: dict[int, list[Node]] = {}
        """Per state that the microstep enters, whose default actions follow its own."""
        self._resumed: dict[int, Progress] = {}
        self._broken: set[tuple[Where, str]] = set()
        """Expressions and actions that failed and have not worked since: place, and text or kind.
        """
        self._has_history = any(node.type == "history" for node in graph.nodes)

    @property
    def now(self) -> float:
        time: float = self.slots[TIME_SLOT]
        return time

    @property
    def active(self) -> Sequence[Node]:
        """All active states in document order."""
        return self._here.states

    @property
    def ended(self) -> bool:
        return self.outcome is not None

    def paths(self) -> list[str]:
        """The active leaf states, in document order."""
        return [leaf.path for leaf in self._here.leaves]

    def is_active(self, path: str) -> bool:
        """Whether a state is active. Raises KeyError for a path that does not exist."""
        return self._is_active(self.graph.by_path[path])

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """The ``is_…`` methods that each graph's class has."""

    def record(self, what: str, **fields: Any) -> None:
        self.records.append((what, fields))

    def set_parameter(self, name: str, value: Any) -> None:
        """Change a parameter of the mission in flight; it counts from the next evaluation.

        Raises UserError for an unknown one, and for a value that it may not have.
        """
        value = self.graph.parameter_value(name, value)
        self.slots[self.graph.parameter_slots[name]] = value
        self.record("parameter", name=name, value=value)

    def raise_event(self, name: str, fields: Mapping[str, Any]) -> None:
        """Queue an event for this macrostep."""
        self._internal.append(Event(name, dict(fields)))

    def _first_passing(self, edges: Iterable[Edge], event: Event) -> Edge | None:
        for edge in edges:
            if self._passes(edge, event):
                return edge
        return None

    def _passes(self, edge: Edge, event: Event) -> bool:
        if edge.prepare:
            self.graph.callbacks(edge.prepare, self._event_data(edge, event))
        if not edge.conditions:
            return True
        guard = edge.guard
        if guard is not None and self.evaluate(guard, event.fields, False) is not True:
            return False
        return len(edge.conditions) == (guard is not None) or self._others_pass(edge, event)

    def _others_pass(self, edge: Edge, event: Event) -> bool:
        """Whether the conditions pass that somebody added to the edge."""
        data = self._event_data(edge, event)
        return all(condition.check(data) for condition in edge.conditions)

    # -- microsteps -------------------------------------------------------------------------

    def _microstep(self, edges: tuple[Edge, ...], event: Event) -> None:
        here = self._here
        step = here.step(edges)
        self._hooks = None
        memories: dict[int, Memory] = {}
        if self._has_history:
            memories = remember(reversed(step.leaving), here.states, self._progress)
            self._memories.update(memories)
        entering, after = step.entering, step.after
        if after is None:
            entering = self._entering(step)
            after = here.changed(step.leaving, entering)
        for edge in edges:
            if edge.before:
                self.graph.callbacks(edge.before, self._event_data(edge, event))
        for node in step.leaving:
            self._exit(node, event)
        for edge, record in step.taken:
            self.records.append(record)
            if edge.actions:
                self._run(edge.actions, event)
        # Last, since exit actions and the transition's own may still have changed them.
        for memory in memories.values():
            memory.keep_data(self.slots)
        self._here, self.slots[CONFIGURATION_SLOT] = after, after.mask
        for node in entering:
            self._enter(node, event)
        if self._restoring:
            self._restoring.clear()
        if self._defaults:
            self._defaults.clear()
        for edge in edges:
            if edge.after:
                self.graph.callbacks(edge.after, self._event_data(edge, event))

    def _entering(self, step: Step) -> tuple[Node, ...]:
        """The states that a step with open transitions enters, outer ones first."""
        found = set(step.entering)
        for edge in step.open:
            if edge.domain is not None:
                found.update(self._entered(edge.domain, edge.targets))
        return tuple(sorted(found, key=lambda node: node.index))

    def _entered(self, domain: Node, targets: Iterable[Node]) -> list[Node]:
        return entry_set(domain, targets, self._recorded, self._defaulted)

    def _defaulted(self, node: Node) -> None:
        """A state is entered by its `initial`, or a history state for the first time."""
        if node.default_actions:
            owner = node.parent if node.type == "history" else node
            assert owner is not None
            self._defaults.setdefault(owner.index, []).append(node)

    def _settle(self, mask: int) -> None:
        self._here = active(self.graph, mask)
        self.slots[CONFIGURATION_SLOT] = mask

    def _enter(self, node: Node, event: Event) -> None:
        index, slots = node.index, self.slots
        slots[node.entered_slot] = slots[TIME_SLOT]
        self._entries[index] = self._entry_count = self._entry_count + 1
        if node.fills:
            self._fill(node, event)
        self.records.append(node.entering)
        if node.on_enter:
            self._call(node.on_enter, event)
        if node.entry:
            self._run(node.entry, event)
        if self._defaults:
            for default in self._defaults.get(index, ()):
                self._run(default.default_actions, event)
        if node.waits:
            self._arm(node, event)
        if node.final:
            self._reached(node, event)

    def _fill(self, node: Node, event: Event) -> None:
        """Fill what an entry gives values to: parameters, data, what a behaviour publishes."""
        slots = self.slots
        memory = self._memory_of(node) if self._restoring else None
        if node.given:
            self._give(node)
        for data in node.data:
            slots[data.slot] = (
                memory.data[data.slot]
                if memory
                else self.evaluate(data.initial, event.fields, None)
            )
        if memory and node.index in memory.progress:
            self._resumed[node.index] = memory.progress[node.index]
        if node.invocation and node.invocation.slot >= 0:
            slots[node.invocation.slot] = node.invocation.behavior.blank

    def _arm(self, node: Node, event: Event) -> None:
        if node.whens:
            self._conditions[node.index] = [Armed(when) for when in node.whens]
        if node.afters:
            self._timers[node.index] = [self._timer(after, event) for after in node.afters]

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
                    self._internal.append(self._outcome(root.owner, "failed", {"reason": reason}))
            self.slots[given.slot] = given.default if value is None else value

    def _refresh(self, root: Node) -> None:
        """Give an included graph the present values of what stands under ``live``."""
        for given in root.given:
            if given.live is not None:
                value = self.evaluate(given.live, {}, None)
                self.slots[given.slot] = self.slots[given.slot] if value is None else value

    def _timer(self, after: After, event: Event) -> Timer:
        duration = self.evaluate(after.duration, event.fields, None)
        due = self.now + duration if isinstance(duration, (int, float)) else None
        return Timer(after, due)

    def _reached(self, final: Node, event: Event) -> None:
        """A final state was entered: its parent has an outcome."""
        output = {
            name: self.evaluate(value, event.fields, None) for name, value in final.output.items()
        }
        assert final.parent is not None
        parent = final.parent.owner
        if parent.parent is None:
            self.outcome, self.output = final.outcome, output
            return
        self._internal.append(self._outcome(parent, final.outcome, output))
        self._region_finished(parent, self._internal)

    def _outcome(self, owner: Node, word: str, fields: Mapping[str, Any]) -> Event:
        if self.graph.scxml:
            return Event(f"done.state.{owner.path}", dict(fields))
        return Event(word, dict(fields), owner, self._entries[owner.index])

    def _region_finished(self, region: Node, queue: deque[Event]) -> None:
        parallel = region.parent
        if parallel is not None and parallel.type == "parallel" and self._is_finished(parallel):
            queue.append(self._outcome(parallel.owner, "done", {}))
            self._region_finished(parallel.owner, queue)

    def _is_finished(self, node: Node) -> bool:
        if node.type == "parallel":
            return all(self._is_finished(region) for region in default_entry(node))
        if node.children and node.children[0].border:
            return self._is_finished(node.children[0])
        if node.children:
            return any(c.type == "final" and self._is_active(c) for c in node.children)
        return node.index in self._finished

    def _exit(self, node: Node, event: Event) -> None:
        index = node.index
        if node.exit_actions:
            self._run(node.exit_actions, event)
        if node.on_exit:
            self._call(node.on_exit, event)
        if node.invocation is not None:
            running = self._running.pop(index, None)
            if running is not None and running.activity is not None:
                if not running.ended:
                    self.records.append(("stop", {"state": node.path}))
                running.activity.stop()
            self._resumed.pop(index, None)
            self._finished.discard(index)
        if node.waits:
            self._conditions.pop(index, None)
            self._timers.pop(index, None)
        self.records.append(node.leaving)

    # -- history ----------------------------------------------------------------------------

    def _progress(self, node: Node) -> Progress | None:
        running = self._running.get(node.index)
        if running is None:
            # Not even started: what it was to go on from still holds.
            return self._resumed.get(node.index)
        return running.activity.progress() if running.activity and not running.ended else None

    def _memory_of(self, node: Node) -> Memory | None:
        return next((memory for memory in self._restoring if node in memory.kept), None)

    def _recorded(self, history: Node) -> tuple[Node, ...]:
        memory = self._memories.get(history.index)
        if memory is None:
            self._defaulted(history)
            return history.initial
        self._restoring.append(memory)
        return memory.states

    # -- evaluation -------------------------------------------------------------------------

    def evaluate(self, compiled: Compiled, event: dict[str, Any], otherwise: Any) -> Any:
        """The value of an expression; when it has none, ``otherwise`` and ``error.execution``."""
        try:
            value = compiled.function(self.slots, event)
        except FAILURES as error:
            self._failed(compiled.where, compiled.source, f"{compiled.source}: {plain(error)}")
            return otherwise
        if self._broken:
            self._broken.discard((compiled.where, compiled.source))
        return value

    def _run(self, actions: Sequence[Action], event: Event) -> None:
        """Run a block; when one of its actions fails, the rest is skipped."""
        for action in actions:
            try:
                action.run(self, event.fields)
            except FAILURES as error:
                self._failed(
                    action.where, action.kind, f"{action.kind}: {plain(error)}", action=True
                )
                return
            if self._broken:
                self._broken.discard((action.where, action.kind))

    def _failed(self, where: Where, what: str, message: str, action: bool = False) -> None:
        """Raised once, until what failed works again; in SCXML by each failing action."""
        if (where, what) in self._broken and not (action and self.graph.scxml):
            return
        self._broken.add((where, what))
        fields = {"message": message, "where": str(where)}
        self.record("error", **fields)
        self._internal.append(Event("error.execution", fields))

    def _is_active(self, node: Node) -> bool:
        configuration: int = self.slots[CONFIGURATION_SLOT]
        return bool(configuration >> node.index & 1)

    def _call(self, callbacks: Iterable[Any], event: Event) -> None:
        """Run entry or exit callbacks; all of a microstep are given one value."""
        data = self._hooks
        if data is None:
            data = self._hooks = self._event_data(None, event)
        for callback in callbacks:
            if isinstance(callback, str):
                callback = self.graph.resolve_callable(callback, data)
            callback(data)

    def _event_data(self, edge: Edge | None, event: Event) -> EventData:
        # `transitions` asks for its own machine and event here; ours offer what callbacks use.
        machine: Any = self.graph
        name: Any = event.name
        state = self._here.leaves[0] if self._here.leaves else None
        data = EventData(state, name, machine, self, [], event.fields)
        data.transition = edge
        return data
