"""The running state: everything that the next period depends on, the graph and its host aside.

An instance *has* a state. It is copied to try something on (``may_trigger``), shifted in time after
a suspension, and packed field by field into a save (see :mod:`fsm.engine.saving`).

States are known by their index in the graph, times are seconds of the vehicle's clock.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Any

from fsm.chart.configuration import Configuration
from fsm.engine.events import DelayedEvents, Event
from fsm.engine.history import Memory, Progress
from fsm.engine.waiting import Armed, Timer
from fsm.expressions.scope import CONFIGURATION_SLOT
from fsm.host import Activity
from vencejo.errors import Where


@dataclass(slots=True)
class Running:
    """The behaviour of an active state."""

    activity: Activity | None
    """None when it could not be started."""
    ended: bool = False


@dataclass(slots=True)
class State:
    """The running state of one instance."""

    values: list[Any]
    """The value of each slot: time, configuration, host names, parameters, data, times of entry."""
    configuration: Configuration
    """The active states; while a microstep enters states, those that it leads to. Its mask stands
    among the values too, for ``active('a.b')``, and changes there state by state."""
    entries: dict[int, int] = field(default_factory=dict)
    """The number of each state's latest entry, so that an outcome of an earlier one is dropped."""
    entry_count: int = 0
    """The number of entries so far."""
    running: dict[int, Running] = field(default_factory=dict)
    """The behaviours of active states, from their first step until their state is left."""
    resumed: dict[int, Progress] = field(default_factory=dict)
    """The progress that a state's behaviour goes on from when it starts."""
    finished: set[int] = field(default_factory=set)
    """Active states whose behaviour has ended in ``done``."""
    conditions: dict[int, list[Armed]] = field(default_factory=dict)
    """The ``when`` conditions of active states."""
    timers: dict[int, list[Timer]] = field(default_factory=dict)
    """The ``after`` durations of active states."""
    memories: dict[int, Memory] = field(default_factory=dict)
    """The content of each history state."""
    urgent: deque[Event] = field(default_factory=deque)
    """Urgent events for the next period."""
    external: deque[Event] = field(default_factory=deque)
    """Other events and outcomes for the next period."""
    internal: deque[Event] = field(default_factory=deque)
    """Events and outcomes raised in the present macrostep."""
    delayed: DelayedEvents = field(default_factory=DelayedEvents)
    """Sent events that are not due yet."""
    broken: set[tuple[Where, str]] = field(default_factory=set)
    """Expressions (place, text) and actions (place, kind) that failed and have not worked since."""
    reactions: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    """Events with their fields that no state handled and that the host must react to."""
    suspended_at: float | None = None
    """When the instance was suspended; None while it is not."""
    outcome: str | None = None
    """The outcome of the mission; None while it has not ended."""
    output: dict[str, Any] = field(default_factory=dict)
    """The output of the final state that ended the mission."""

    def __post_init__(self) -> None:
        self.values[CONFIGURATION_SLOT] = self.configuration.mask

    def copy(self) -> State:
        """A copy that changes apart from this one. Activities belong to the host and are shared."""
        return replace(
            self,
            values=self.values.copy(),
            entries=self.entries.copy(),
            running={index: replace(each) for index, each in self.running.items()},
            resumed=self.resumed.copy(),
            finished=self.finished.copy(),
            conditions={
                index: [
                    replace(armed, due=armed.due.copy(), spent=armed.spent.copy()) for armed in each
                ]
                for index, each in self.conditions.items()
            },
            timers={
                index: [replace(timer) for timer in each] for index, each in self.timers.items()
            },
            memories=self.memories.copy(),
            urgent=self.urgent.copy(),
            external=self.external.copy(),
            internal=self.internal.copy(),
            delayed=DelayedEvents(replace(sent) for sent in self.delayed),
            broken=self.broken.copy(),
            reactions=self.reactions.copy(),
            output=self.output.copy(),
        )

    def shift(self, seconds: float) -> None:
        """Move everything that waits for a time, or is counted from one, into the future."""
        for node in self.configuration.states:
            self.values[node.entered_slot] += seconds
        for timers in self.timers.values():
            for timer in timers:
                if timer.due is not None:
                    timer.due += seconds
        for conditions in self.conditions.values():
            for condition in conditions:
                if condition.since is not None:
                    condition.since += seconds
        for sent in self.delayed:
            sent.due += seconds
