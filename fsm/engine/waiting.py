"""Conditions (``when``) and timers (``after``) of active states.

Times are seconds of the vehicle's clock.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from fsm.chart.graph import After, Edge, When

EPSILON = 1e-9
"""Seconds within which two times count as equal."""


@dataclass(slots=True)
class Armed:
    """A condition of an active state, and which of its alternatives wait to be taken."""

    when: When
    since: float | None = None
    """When it became true; none while it is false."""
    due: set[int] = field(default_factory=set)
    """Alternatives to be tested. One that another transition forestalls stays due, even when the
    condition is false again: nothing is lost."""
    spent: set[int] = field(default_factory=set)
    """Alternatives that had their turn; armed again when the condition is next seen false."""

    def observe(self, true: bool, now: float, hold: Callable[[Edge], float | None]) -> None:
        """Note whether the condition is true now.

        ``hold`` gives the seconds that it must have been true for an alternative to become due, or
        None when they cannot be told.
        """
        if not true:
            self.since = None
            self.spent.clear()
            return
        if self.since is None:
            self.since = now
        for index, edge in enumerate(self.when.edges):
            if index not in self.spent and index not in self.due:
                needed = hold(edge)
                if needed is not None and now - self.since >= needed - EPSILON:
                    self.due.add(index)

    def refused(self, index: int) -> None:
        """Note that the guard of an alternative did not pass."""
        self.due.discard(index)
        if self.since is not None:
            self.spent.add(index)

    def taken(self) -> None:
        """Note that an alternative was taken, which spends all of them."""
        self.due.clear()
        if self.since is not None:
            self.spent.update(range(len(self.when.edges)))


@dataclass(slots=True)
class Timer:
    """A duration of an active state."""

    after: After
    due: float | None
    """None once it was taken or its guards have been tested."""

    def is_due(self, now: float) -> bool:
        return self.due is not None and self.due <= now + EPSILON

    def taken(self) -> None:
        self.due = None
