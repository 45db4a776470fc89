"""A running graph: one :class:`Instance` per vehicle, advanced one mission period at a time.

Theory of operation. Selection, conflicts, exit and entry follow the algorithm of SCXML (W3C
recommendation of 2015, appendix D): an event selects at most one transition for each active leaf,
inner states first, in document order; of two whose exit sets meet, the one in the inner state
wins, else the earlier. Taking them is a *microstep*; then come ``always`` transitions and raised
events until nothing moves, which makes a *macrostep*.

Around that core stands the mission period, in a fixed order: events (urgent ones first), then one
round of conditions and timers, then ``throughout`` actions, then the behaviours. No clock is read
and no thread started here: time and host values come in as arguments.

A *suspended* instance goes on later as if no time had passed for it: behaviours are stopped with
their progress and start with it again, as after a history state; timers, delayed sends, lasting
conditions and ``time_in_state`` stand still meanwhile.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

from fsm.chart.entry_sets import default_entry
from fsm.chart.executable import Invocation
from fsm.chart.graph import Edge, Graph, Node, Record
from fsm.chart.selection import chain, select
from fsm.engine.events import NOTHING, Event
from fsm.engine.microstep import Configuration, Running
from fsm.engine.outbox import Delayed, Outbox
from fsm.engine.waiting import Armed, Timer
from fsm.expressions.scope import FIRST_HOST_SLOT, TIME_SLOT
from fsm.host import Host, Outcome, Reaction
from fsm.values.functions import FAILURES, plain

__all__ = ["FAILURES", "Event", "Instance", "Record"]

MAX_MICROSTEPS = 1000
WAKING: tuple[Reaction, ...] = ("resume", "land")
"""Urgent events with these reactions end a suspension: the operator gives the vehicle back, or
something happened that cannot wait for that."""
NO_LIVE: Mapping[str, Any] = {}


class Instance(Configuration):
    """A graph at work. Also the *model* of `transitions`: ``trigger``, ``is_active``, …"""

    def __init__(
        self, graph: Graph, host: Host, parameters: Mapping[str, Any] | None = None
    ) -> None:
        super().__init__(graph, parameters)
        self.host = host
        self.reactions: list[tuple[str, dict[str, Any]]] = []
        """Events that nobody handled and whose host must react, with their fields."""
        self._urgent: deque[Event] = deque()
        self._external: deque[Event] = deque()
        self._delayed = Outbox()
        self.suspended_at: float | None = None
        """When it was suspended; none while it runs."""

    def is_controlled(self, resource: str) -> bool:
        """Whether a behaviour that is at work controls ``motion`` (or another resource)."""
        for node in self.active:
            running = self._running.get(node.index)
            at_work = running is not None and not running.ended and node.invocation is not None
            if at_work and node.invocation and resource in node.invocation.behavior.controls:
                return True
        return False

    def trigger(self, event: str, **fields: Any) -> bool:
        """Process an event at once, as a macrostep of its own; whether a transition was taken."""
        if not self._here.states:
            self._start()
        return self.outcome is None and self._macrostep(Event(event, fields))

    def may_trigger(self, event: str, **fields: Any) -> bool:
        """Whether an event would take a transition now. Changes nothing."""
        before = len(self.records), len(self._internal), set(self._broken)
        shown = self.slots[self.graph.event_slot]
        if self.graph.event_slot >= 0:
            self._show(Event(event, fields))
        possible = not self.ended and bool(self._select(Event(event, fields)))
        del self.records[before[0] :]
        while len(self._internal) > before[1]:
            self._internal.pop()
        self._broken = before[2]
        self.slots[self.graph.event_slot] = shown
        return possible

    def post(self, name: str, fields: Mapping[str, Any] | None = None) -> None:
        """Queue an event for the next period."""
        event = Event(name, dict(fields or {}))
        urgent = self.graph.vocabulary.is_urgent(name)
        (self._urgent if urgent else self._external).append(event)

    def next_due(self) -> float | None:
        """The earliest time at which a period would hear an event; None while none waits."""
        if self.ended:
            return None
        if self._urgent or self._external:
            return self.now
        return self._delayed[0].due if self._delayed else None

    # -- the mission period -----------------------------------------------------------------

    def period(self, now: float, host_values: Sequence[Any] = ()) -> None:
        """Advance by one mission period: events, clock and world, throughout, behaviours.

        ``host_values`` are frozen values of the vocabulary's names, in its order.
        """
        self.slots[TIME_SLOT] = now
        self.slots[FIRST_HOST_SLOT : FIRST_HOST_SLOT + len(host_values)] = host_values
        if self.suspended_at is not None:
            reaction = self.graph.vocabulary.reaction
            if not any(reaction(event.name) in WAKING for event in self._urgent):
                return
            self.resume()
        self._entered_before = self._entry_count
        # Before the start: what is sent with no delay is heard in a later period.
        for sent in self._delayed.take_due(now) if self._delayed else ():
            if sent.to:
                self._deliver(sent.event.name, sent.event.fields, sent.to)
            else:
                self.post(sent.event.name, sent.event.fields)
        if not self.active:
            self._start()
        # What is posted meanwhile belongs to the next period.
        for queue in (self._urgent, self._external):
            for _ in range(len(queue)):
                if self.ended:
                    return
                self._macrostep(queue.popleft())
        if not self.ended and (self._here.waiting or self._internal):
            self._world_round()
        if not self.ended:
            if self._here.throughout:
                self._throughout()
            self._behaviors()

    def stop(self, outcome: str = "stopped") -> None:
        """End the run: leave all states, inner ones first, with their exit actions."""
        self.outcome = self.outcome or outcome
        self._hooks = None
        for node in reversed(self.active):
            self._exit(node, NOTHING)
        self._settle(0)

    def suspend(self) -> None:
        """Let nothing go on after this period, until :meth:`resume` or an event that wakes it."""
        if self.suspended_at is None and not self.ended:
            self.suspended_at = self.now
            self._stop_behaviors()
            self.record("suspend")

    def resume(self) -> None:
        """Go on as if no time had passed; behaviours start again from their progress."""
        if self.suspended_at is not None:
            self._shift_clocks(self.now - self.suspended_at)
            self.suspended_at = None
            self.record("resume")

    def _stop_behaviors(self) -> None:
        """Stop what is at work; it goes on from its progress when it is started again."""
        for node in reversed(self.active):
            running = self._running.get(node.index)
            if running is None or running.ended or running.activity is None:
                continue
            progress = running.activity.progress()
            if progress is not None:
                self._resumed[node.index] = progress
            self.record("stop", state=node.path)
            running.activity.stop()
            del self._running[node.index]

    def _shift_clocks(self, seconds: float) -> None:
        """Move everything that waits, or was counted from, a time."""
        for node in self.active:
            self.slots[node.entered_slot] += seconds
            for timer in self._timers.get(node.index, ()):
                if timer.due is not None:
                    timer.due += seconds
            for condition in self._conditions.get(node.index, ()):
                if condition.since is not None:
                    condition.since += seconds
        for sent in self._delayed:
            sent.due += seconds

    def _start(self) -> None:
        if self.active or self.ended:
            return
        root = self.graph.root
        entered = [root, *self._entered(root, default_entry(root))]
        self._settle(sum(node.mask for node in entered))
        for node in entered:
            self._enter(node, NOTHING)
        self._defaults.clear()
        self._stabilise()

    # -- events -----------------------------------------------------------------------------

    def send(
        self, name: str, fields: Mapping[str, Any], delay: float, id_: str, to: str = ""
    ) -> None:
        """Queue an event for a later period, or give it to the host for another vehicle."""
        if to and delay <= 0:
            # At once: this may be the last thing that the mission does.
            self._deliver(name, fields, to)
            return
        self._delayed.put(Delayed(self.now + delay, id_, Event(name, dict(fields)), to))

    def _deliver(self, name: str, fields: Mapping[str, Any], to: str) -> None:
        self.record("send", event=name, to=to, fields=dict(fields))
        self.host.send(name, fields, to)

    def cancel(self, id_: str) -> None:
        """Take back what was sent with this id and is not due."""
        self._delayed.cancel(id_)

    def _macrostep(self, event: Event) -> bool:
        taken = self._offer(event)
        if self._internal or self._here.always:
            self._stabilise()
        return taken

    def _offer(self, event: Event) -> bool:
        """Let one event take its transitions; whether there were any."""
        owner = event.owner
        if owner is not None and not (
            self._is_active(owner) and self._entries[owner.index] == event.entry
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
            self._microstep(edges, event)
        elif owner is self.graph.root:
            # Every region of a parallel mission has finished.
            self.outcome = event.name
        elif self._must_react(event):
            self.reactions.append((event.name, event.fields))
        return bool(edges)

    def _show(self, event: Event) -> None:
        """SCXML keeps the event at hand in a variable, until the next one comes."""
        self.slots[self.graph.event_slot] = {"name": event.name, "data": event.fields}

    def _must_react(self, event: Event) -> bool:
        name = event.name
        if name == "failed" or name.startswith("error.") or self.graph.vocabulary.is_urgent(name):
            return self.graph.vocabulary.reaction(name) in ("land", "suspend")
        return False

    def _stabilise(self) -> None:
        """Come to rest; when there is none, `error.livelock` may lead out."""
        if self._comes_to_rest():
            return
        self._internal.clear()
        message = f"more than {MAX_MICROSTEPS} steps without coming to rest"
        event = Event("error.livelock", {"message": message, "where": ", ".join(self.paths())})
        self.record("error", **event.fields)
        if self._offer(event) and not self._comes_to_rest():
            self._internal.clear()

    def _comes_to_rest(self) -> bool:
        """``always`` before raised events, until nothing moves."""
        for _ in range(MAX_MICROSTEPS):
            if self.ended:
                return True
            edges = self._pick_always()
            if edges:
                self._microstep(edges, NOTHING)
            elif self._internal:
                self._offer(self._internal.popleft())
            else:
                return True
        return False

    def _defer(self) -> None:
        """What is raised outside a macrostep is heard in the next period."""
        while self._internal:
            event = self._internal.popleft()
            if event.owner is None:
                self.post(event.name, event.fields)
            else:
                self._external.append(event)

    # -- selection --------------------------------------------------------------------------

    def _select(self, event: Event) -> tuple[Edge, ...]:
        here = self._here
        if event.owner is None and len(here.leaves) == 1:
            for edge in here.asked(event.name):
                if self._passes(edge, event):
                    return (edge,)
            return ()
        return self._select_widely(event)

    def _select_widely(self, event: Event) -> tuple[Edge, ...]:
        """The transitions of an event in parallel regions, or of an outcome."""
        name, owner, outer_first = event.name, event.owner, self.graph.outer_first
        vocabulary = self.graph.vocabulary

        def choose(node: Node) -> Edge | None:
            return self._first_passing(node.edges_for(name, vocabulary), event)

        if owner is None:
            return tuple(select(self._here.leaves, choose, outer_first))
        # An outcome goes from its state outwards, never to another region; `done` stays.
        asked = (owner,) if name == "done" else chain(owner, outer_first)
        if name not in ("done", "failed"):
            # Nor, but for `failed`, out of an included graph.
            within = tuple(owner.outwards())
            asked = [node for node in asked if node in within]
        edge = next((edge for node in asked if (edge := choose(node)) is not None), None)
        return () if edge is None else (edge,)

    def _pick_always(self) -> tuple[Edge, ...]:
        if not self._here.always:
            return ()
        edges = select(
            self._here.leaves,
            lambda node: self._first_passing(node.always, NOTHING) if node.always else None,
            self.graph.outer_first,
        )
        return tuple(edges)

    # -- clock and world --------------------------------------------------------------------

    def _world_round(self) -> None:
        """One round over the states active since before this period."""
        offers: dict[int, tuple[Edge, Armed | Timer]] = {}
        for node in self._here.waiting:
            if self._entries[node.index] <= self._entered_before:
                offer = self._world_offer(node)
                if offer is not None:
                    offers[node.index] = offer
        if offers:
            edges = select(
                self._here.leaves,
                lambda node: offers[node.index][0] if node.index in offers else None,
                self.graph.outer_first,
            )
            for edge in edges:
                offers[edge.node.index][1].taken()
            self._microstep(tuple(edges), NOTHING)
        if offers or self._internal:
            self._stabilise()

    def _world_offer(self, node: Node) -> tuple[Edge, Armed | Timer] | None:
        """The first due transition of a state; every condition is observed, for its edges."""
        offer: tuple[Edge, Armed | Timer] | None = None
        for condition in self._conditions.get(node.index, ()):
            true = self.evaluate(condition.when.condition, NOTHING.fields, False) is True
            if not true and condition.since is None and not condition.due:
                continue  # as it has been: most conditions of most periods
            condition.observe(true, self.now, self._hold)
            for index in sorted(condition.due) if offer is None else ():
                edge = condition.when.edges[index]
                if self._passes(edge, NOTHING):
                    offer = edge, condition
                    break
                condition.refused(index)
        for timer in self._timers.get(node.index, ()):
            if offer is None and timer.is_due(self.now):
                found = self._first_passing(timer.after.edges, NOTHING)
                if found is None:
                    timer.due = None
                else:
                    offer = found, timer
        return offer

    def _hold(self, edge: Edge) -> float | None:
        """How long a condition must last for this alternative; None when that cannot be told."""
        return 0.0 if edge.hold is None else self.evaluate(edge.hold, {}, None)

    # -- throughout and behaviours ----------------------------------------------------------

    def _throughout(self) -> None:
        for node in self._here.throughout:
            self._run(node.throughout, NOTHING)
        self._defer()

    def _behaviors(self) -> None:
        for node in self._here.behaving:
            if node.given:
                self._refresh(node)
            invocation = node.invocation
            if invocation is None:
                continue
            running = self._running.get(node.index) or self._begin(node)
            if running.ended or running.activity is None:
                continue
            outcome = running.activity.step(self._live(invocation) if invocation.live else NO_LIVE)
            if invocation.slot >= 0:
                self.slots[invocation.slot] = running.activity.published
            if outcome is not None:
                self._end(node, running, outcome)
        self._defer()

    def _live(self, invocation: Invocation) -> dict[str, Any]:
        return {
            name: value
            for name, compiled in invocation.live.items()
            if (value := self.evaluate(compiled, {}, None)) is not None
        }

    def _begin(self, node: Node) -> Running:
        invocation = node.invocation
        assert invocation is not None
        running = self._running[node.index] = Running(None)
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
        progress = self._resumed.pop(node.index, None)
        running.activity = self.host.begin(invocation.behavior, node.path, values, progress)
        return running

    def _end(self, node: Node, running: Running, outcome: Outcome) -> None:
        """A behaviour ended: its state and those around it hear of it in the next period."""
        running.ended = True
        self._external.append(self._outcome(node, outcome.word, outcome.fields))
        if outcome.word == "done":
            self._finished.add(node.index)
            self._region_finished(node, self._external)
