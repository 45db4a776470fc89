"""Events that were sent with a delay and wait for their time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fsm.engine.events import Event
from fsm.engine.waiting import EPSILON


@dataclass(slots=True)
class Delayed:
    """A sent event that waits for its time."""

    due: float
    id: str
    event: Event
    to: str = ""
    """The vehicle it is for; empty for one's own."""


class Outbox(list[Delayed]):
    """What waits, the earliest first."""

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
