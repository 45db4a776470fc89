"""The nesting of states: relations that drafts and compiled states have alike."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Self


class Nested:
    """A state in a tree. Document order numbers the states, so that each subtree is a range."""

    __slots__ = ()

    index: int
    """Its place in document order; the root's is 0."""
    last: int
    """Index of the last state inside; ``index … last`` are this state and all inside it."""
    border: bool
    """True at the root of a graph: the root itself, or the only child of a state that includes one.
    Names, targets and outcomes other than ``failed`` do not cross it."""
    parent: Self | None

    @property
    def owner(self) -> Self:
        """The state that gets the outcomes of this one: itself, or its graph's includer."""
        return self.parent.owner if self.border and self.parent else self

    def outwards(self) -> Iterator[Self]:
        """This state and its ancestors in the same graph."""
        place: Self | None = self
        while place is not None:
            yield place
            place = None if place.border else place.parent

    def contains(self, other: Self) -> bool:
        """Whether ``other`` lies inside, this state itself apart."""
        return self.index < other.index <= self.last
