"""The nesting of states: relations that drafts and compiled states have alike."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Self, TypeVar

from fsm.language.spec import StateType


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
    type: StateType

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


AnyNested = TypeVar("AnyNested", bound=Nested)


def domain_of(source: AnyNested, targets: Iterable[AnyNested], reenter: bool) -> AnyNested | None:
    """The state whose inside a transition leaves; None without targets: then nothing is left.

    SCXML's getTransitionDomain and findLCCA (W3C recommendation of 2015, appendix D). A target
    inside a compound source leaves the source only where ``reenter`` is set.
    """
    indices = [target.index for target in targets]
    if not indices:
        return None
    first, last = min(indices), max(indices)
    within = source.index < first and last <= source.last
    if within and (source.border or (source.type == "compound" and not reenter)):
        return source
    place = source
    while place.parent is not None:
        place = place.parent
        if place.type == "compound" and place.index < first and last <= place.last:
            return place
    return place
