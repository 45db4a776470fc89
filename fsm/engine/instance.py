"""A running graph: one :class:`Instance` per vehicle, advanced one mission period at a time.

Around the interpreter stands the mission period, in a fixed order: events (urgent ones first),
then one round of conditions and timers, then ``throughout`` actions, then the behaviours. No clock
is read and no thread started here: time and host values come in as arguments.

A *suspended* instance goes on later as if no time had passed for it: behaviours are stopped with
their progress and start with it again, as after a history state; timers, delayed sends, lasting
conditions and ``time_in_state`` stand still meanwhile.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fsm.chart.executable import Invocation, Record
from fsm.chart.graph import Edge, Node
from fsm.chart.selection import select
from fsm.engine.events import NOTHING, Event
from fsm.engine.interpreter import Interpreter
from fsm.engine.state import Running
from fsm.engine.waiting import Armed, Timer
from fsm.expressions.scope import FIRST_HOST_SLOT, PERIOD_SLOT, TIME_SLOT
from fsm.host import PERIOD, Outcome, Reaction
from fsm.values.functions import FAILURES, plain

__all__ = ["FAILURES", "Event", "Instance", "Record"]

WAKING: tuple[Reaction, ...] = ("resume", "land")
"""Urgent events with these reactions end a suspension: the operator gives the vehicle back, or
something happened that cannot wait for that."""
NO_LIVE: Mapping[str, Any] = {}


class Instance(Interpreter):
    """A running graph."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """The ``is_…`` methods that each graph's class has."""

    @property
    def suspended_at(self) -> float | None:
        """When it was suspended; None while it is not."""
        return self.state.suspended_at

    def is_controlled(self, resource: str) -> bool:
        """Whether a running behaviour controls a resource, such as ``motion``."""
        for node in self.active:
            running = self.state.running.get(node.index)
            if running is None or running.ended or node.invocation is None:
                continue
            if resource in node.invocation.behavior.controls:
                return True
        return False

    def set_parameter(self, name: str, value: Any) -> None:
        """Change a parameter of the mission in flight; it counts from the next evaluation.

        Raises UserError for an unknown one, and for a value that it may not have.
        """
        value = self.graph.parameter_value(name, value)
        self.slots[self.graph.parameter_slots[name]] = value
        self.record("parameter", name=name, value=value)

    # -- the mission period -----------------------------------------------------------------

    def period(self, now: float, host_values: Sequence[Any] = ()) -> None:
        """Advance by one mission period: events, clock and world, throughout, behaviours.

        ``now`` is in seconds of the vehicle's clock. ``host_values`` are the values of the
        vocabulary's names, in its order; they do not change during the period.
        """
        state, slots = self.state, self.slots
        slots[PERIOD_SLOT] = now - slots[TIME_SLOT] if state.configuration.states else PERIOD
        slots[TIME_SLOT] = now
        slots[FIRST_HOST_SLOT : FIRST_HOST_SLOT + len(host_values)] = host_values
        if state.suspended_at is not None:
            if not self._is_woken():
                return
            self.resume()
        entered_before = state.entry_count
        # Before the start: what is sent with no delay is heard in a later period.
        if state.delayed:
            self._hear_delayed()
        if not state.configuration.states:
            self.start()
        if state.urgent or state.external:
            self._process_events()
        if state.outcome is None and (state.configuration.waiting or state.internal):
            self._world_round(entered_before)
        if state.outcome is None:
            if state.configuration.throughout:
                self._throughout()
            self._behaviors()

    def _hear_delayed(self) -> None:
        """Queue what is due for this period, or give it to the host for another vehicle."""
        for sent in self.state.delayed.take_due(self.now):
            if sent.to:
                self.deliver(sent.event.name, sent.event.fields, sent.to)
            else:
                self._queue(sent.event)

    def _process_events(self) -> None:
        """Run a macrostep per queued event; events posted meanwhile wait for the next period."""
        state = self.state
        for queue in (state.urgent, state.external):
            for _ in range(len(queue)):
                if state.outcome is not None:
                    return
                self.macrostep(queue.popleft())

    # -- events -----------------------------------------------------------------------------

    def post(self, name: str, fields: Mapping[str, Any] | None = None) -> None:
        """Queue an event for the next period."""
        self._queue(Event(name, dict(fields or {})))

    def _queue(self, event: Event) -> None:
        urgent = self.graph.vocabulary.is_urgent(event.name)
        (self.state.urgent if urgent else self.state.external).append(event)

    def waiting(self, name: str) -> list[Event]:
        """The events of this name that are queued and that nobody has heard yet."""
        state = self.state
        queued = (*state.urgent, *state.external, *state.internal)
        return [event for event in queued if event.name == name]

    def next_due(self) -> float | None:
        """The earliest time at which a period would hear an event; None while none waits."""
        state = self.state
        if state.outcome is not None:
            return None
        if state.urgent or state.external:
            return self.now
        return state.delayed[0].due if state.delayed else None

    def _defer(self) -> None:
        """Queue for the next period what was raised outside a macrostep."""
        internal = self.state.internal
        while internal:
            event = internal.popleft()
            if event.owner is None:
                self._queue(event)
            else:
                self.state.external.append(event)

    # -- suspension -------------------------------------------------------------------------

    def suspend(self) -> None:
        """Stand still from the end of this period until :meth:`resume`, or an event that wakes it.

        Behaviours are stopped, and their progress is kept.
        """
        state = self.state
        if state.suspended_at is None and state.outcome is None:
            state.suspended_at = self.now
            self._stop_behaviors()
            self.record("suspend")

    def resume(self) -> None:
        """Go on as if no time had passed; behaviours start again from their progress."""
        state = self.state
        if state.suspended_at is not None:
            state.shift(self.now - state.suspended_at)
            state.suspended_at = None
            self.record("resume")

    def _is_woken(self) -> bool:
        """Whether a queued urgent event ends the suspension."""
        reaction = self.graph.vocabulary.reaction
        return any(reaction(event.name) in WAKING for event in self.state.urgent)

    def _stop_behaviors(self) -> None:
        """Stop the running behaviours; each goes on from its progress when it is started again."""
        state = self.state
        for node in reversed(self.active):
            running = state.running.get(node.index)
            if running is None or running.ended or running.activity is None:
                continue
            progress = running.activity.progress()
            if progress is not None:
                state.resumed[node.index] = progress
            self.record("stop", state=node.path)
            running.activity.stop()
            del state.running[node.index]

    # -- clock and world --------------------------------------------------------------------

    def _world_round(self, entered_before: int) -> None:
        """One round of conditions and timers of the states active since before this period.

        ``entered_before`` is the number of the last entry before it.
        """
        state = self.state
        offers: dict[int, tuple[Edge, Armed | Timer]] = {}
        for node in state.configuration.waiting:
            if state.entries[node.index] <= entered_before:
                offer = self._world_offer(node)
                if offer is not None:
                    offers[node.index] = offer
        if offers:
            edges = select(
                state.configuration.leaves,
                lambda node: offers[node.index][0] if node.index in offers else None,
                self.recorded,
                self.graph.outer_first,
            )
            for edge in edges:
                offers[edge.node.index][1].taken()
            self.microstep(tuple(edges), NOTHING)
        if offers or state.internal:
            self.stabilise()

    def _world_offer(self, node: Node) -> tuple[Edge, Armed | Timer] | None:
        """The first due transition of a state, with its condition or timer; None when none is due.

        Every condition is evaluated, to notice when it becomes true or false.
        """
        offer: tuple[Edge, Armed | Timer] | None = None
        for condition in self.state.conditions.get(node.index, ()):
            true = self.evaluate(condition.when.condition, NOTHING.fields, False) is True
            if not true and condition.since is None and not condition.due:
                continue  # Still false, as most conditions are in most periods.
            condition.observe(true, self.now, self._hold)
            for index in sorted(condition.due) if offer is None else ():
                edge = condition.when.edges[index]
                if self.passes(edge, NOTHING):
                    offer = edge, condition
                    break
                condition.refused(index)
        for timer in self.state.timers.get(node.index, ()):
            if offer is None and timer.is_due(self.now):
                found = self.first_passing(timer.after.edges, NOTHING)
                if found is None:
                    timer.due = None
                else:
                    offer = found, timer
        return offer

    def _hold(self, edge: Edge) -> float | None:
        """Seconds a condition must last for this alternative; None when that cannot be told."""
        return 0.0 if edge.hold is None else self.evaluate(edge.hold, {}, None)

    # -- throughout and behaviours ----------------------------------------------------------

    def _throughout(self) -> None:
        for node in self.state.configuration.throughout:
            self.run_actions(node.throughout, NOTHING.fields)
        self._defer()

    def _behaviors(self) -> None:
        """Start the behaviours that are new, and let each take its step, outer states first."""
        state = self.state
        for node in state.configuration.behaving:
            if node.given:
                self._refresh(node)
            invocation = node.invocation
            if invocation is None:
                continue
            running = state.running.get(node.index) or self._begin(node, invocation)
            if running.ended or running.activity is None:
                continue
            outcome = running.activity.step(self._live(invocation) if invocation.live else NO_LIVE)
            if invocation.slot >= 0:
                self.slots[invocation.slot] = running.activity.published
            if outcome is not None:
                self._end(node, running, outcome)
        self._defer()

    def _refresh(self, root: Node) -> None:
        """Give an included graph the present values of what stands under ``live``."""
        for given in root.given:
            if given.live is not None:
                value = self.evaluate(given.live, {}, None)
                self.slots[given.slot] = self.slots[given.slot] if value is None else value

    def _live(self, invocation: Invocation) -> dict[str, Any]:
        """The present values of what stands under ``live``, as far as they have one."""
        return {
            name: value
            for name, compiled in invocation.live.items()
            if (value := self.evaluate(compiled, {}, None)) is not None
        }

    def _begin(self, node: Node, invocation: Invocation) -> Running:
        """Start a behaviour; one whose parameters have no value has failed at once."""
        running = self.state.running[node.index] = Running(None)
        values: dict[str, Any] = {}
        for name, compiled in invocation.with_.items():
            try:
                values[name] = compiled.function(self.slots, {})
            except FAILURES as error:
                reason = f"the parameter '{name}' has no value: {plain(error)}"
                self._end(node, running, Outcome("failed", {"reason": reason}))
                return running
        for name, compiled in invocation.live.items():
            values[name] = self.evaluate(compiled, {}, None)
        self.record("start", state=node.path, do=invocation.behavior.name, **{"with": values})
        progress = self.state.resumed.pop(node.index, None)
        running.activity = self.host.begin(invocation.behavior, node.path, values, progress)
        return running

    def _end(self, node: Node, running: Running, outcome: Outcome) -> None:
        """Note that a behaviour has ended, and queue its outcome for the next period."""
        running.ended = True
        external = self.state.external
        external.append(self.outcome_of(node, outcome.word, outcome.fields))
        if outcome.word == "done":
            self.state.finished.add(node.index)
            self.finish_region(node, external)
