"""Events: what a running graph reacts to, now or later."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from fsm.chart.executable import CONTENT, EXTERNAL, Origin
from fsm.chart.graph import Node
from fsm.engine.waiting import EPSILON


@dataclass(slots=True)
class Event:
    """An event, or the outcome of a state, which is its owner.

    Nobody changes one; it is not frozen because frozen ones take twice as long to make.
    """

    name: str
    fields: dict[str, Any]
    owner: Node | None = None
    entry: int = 0
    """Which entry of its owner it belongs to: it is dropped once that one was left."""
    origin: Origin = EXTERNAL

    def as_variable(self) -> dict[str, Any]:
        """The value of SCXML's ``_event``; what is blank is None (W3C recommendation, 5.10.1)."""
        origin = self.origin
        # A copy: what a document does with its variable must not change the event.
        data = deepcopy(self.fields)
        return {
            "name": self.name,
            "type": origin.type,
            "sendid": origin.sendid,
            "origin": origin.address,
            "origintype": origin.processor,
            "invokeid": None,
            "data": data.get(CONTENT, data or None),
        }


NOTHING = Event("", {})
"""The event of a microstep that no event has caused."""


@dataclass(slots=True)
class Delayed:
    """A sent event that waits for its time."""

    due: float
    """Seconds of the vehicle's clock."""
    id: str
    event: Event
    to: str = ""
    """The vehicle it is for; empty for one's own."""


class DelayedEvents(list[Delayed]):
    """Sent events that wait for their time, the earliest first."""

    def put(self, sent: Delayed) -> None:
        """Add one; of those due at one time the earlier sent comes first."""
        self.append(sent)
        self.sort(key=lambda each: each.due)

    def take_due(self, now: float) -> Iterator[Delayed]:
        """Take out those whose time has come."""
        while self and self[0].due <= now + EPSILON:
            yield self.pop(0)

    def cancel(self, id_: str) -> None:
        """Take back what was sent with this id."""
        self[:] = [sent for sent in self if sent.id != id_]
