"""Which states a transition leaves and enters: SCXML's domains and entry sets, default entries.

Functions of the graph and of what history remembers (W3C recommendation of 2015, appendix D).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from fsm.chart.graph import Edge, Node
from fsm.chart.nesting import domain_of

Recorded = Callable[[Node], tuple[Node, ...] | None]
"""The states that a history state stands for; None when its parent has never been left."""


def default_entry(node: Node) -> tuple[Node, ...]:
    """The children that entering a state enters: its ``initial``, or all regions of a parallel."""
    if node.type == "parallel":
        return tuple(child for child in node.children if child.type != "history")
    return node.initial


def transition_domain(edge: Edge, recorded: Recorded) -> Node | None:
    """The state whose descendants a transition leaves; None for one without targets.

    That of the effective targets: of what a history state stands for now, and not of itself
    (SCXML's getTransitionDomain and getEffectiveTargetStates).
    """
    if not edge.by_history:
        return edge.domain
    effective: list[Node] = []
    for target in edge.targets:
        effective += (recorded(target) or target.initial) if target.type == "history" else (target,)
    return domain_of(edge.node, effective, edge.reenter)


@dataclass(slots=True)
class EntrySet:
    """The states that one transition enters, and how it comes to them."""

    entering: dict[int, Node] = field(default_factory=dict)
    """State index → entered state, unordered."""
    histories: list[Node] = field(default_factory=list)
    """The history states that had something recorded."""
    defaults: dict[int, list[Node]] = field(default_factory=dict)
    """State index → states with default actions (itself, or a history state inside it)."""

    @property
    def states(self) -> list[Node]:
        """The entered states in document order."""
        return [self.entering[index] for index in sorted(self.entering)]


def entry_set(domain: Node, targets: Iterable[Node], recorded: Recorded) -> EntrySet:
    """The states that a transition enters below ``domain``.

    SCXML's computeEntrySet (W3C recommendation of 2015, appendix D). Where it would climb from what
    history remembers past the domain, states would be entered that have not been left; section 3.13
    forbids that, and nothing outside the domain is entered here.
    """
    found = EntrySet()
    _Entering(found, recorded, domain).enter(targets, domain)
    return found


@dataclass(slots=True)
class _Entering:
    """Collects an entry set."""

    found: EntrySet
    recorded: Recorded
    domain: Node

    def enter(self, targets: Iterable[Node], stop: Node) -> None:
        """Add targets with what is inside them, and the states between them and ``stop``."""
        # All of them first: what is around one must not fill another's region with its default.
        targets = tuple(targets)
        for target in targets:
            self.descend(target)
        for target in targets:
            self.climb(target, stop)

    def descend(self, node: Node) -> None:
        if node.type == "history":
            assert node.parent is not None, "a history state has a parent"
            self.enter(self.remembered(node, node.parent), node.parent)
            return
        self.found.entering[node.index] = node
        if node.type == "compound":
            self.defaulted(node, node)
            self.enter(node.initial, node)
        elif node.type == "parallel":
            self.fill(node)

    def remembered(self, history: Node, parent: Node) -> tuple[Node, ...]:
        states = self.recorded(history)
        if states is not None:
            self.found.histories.append(history)
            return states
        self.defaulted(history, parent)
        return history.initial

    def defaulted(self, node: Node, entered: Node) -> None:
        """Note a default entry whose actions follow the entry actions of ``entered``."""
        if node.default_actions:
            self.found.defaults.setdefault(entered.index, []).append(node)

    def climb(self, node: Node, stop: Node) -> None:
        entering = self.found.entering
        for ancestor in node.ancestors:
            if ancestor is stop or not self.domain.contains(ancestor):
                return
            new = ancestor.index not in entering
            entering[ancestor.index] = ancestor
            if new and ancestor.type == "parallel":
                self.fill(ancestor)

    def fill(self, parallel: Node) -> None:
        """Enter the regions in which nothing is entered yet."""
        filled = sorted(self.found.entering)
        for region in default_entry(parallel):
            first = bisect_left(filled, region.index)
            if first == len(filled) or filled[first] > region.last:
                self.descend(region)


def fixed_entry_set(edge: Edge) -> tuple[Node, ...] | None:
    """The states that a transition enters whatever happened before, outer ones first.

    None when that is only known in flight, because history decides it or default entries have
    actions of their own.
    """
    if edge.domain is None:
        return ()
    found = entry_set(edge.domain, edge.targets, lambda history: ()).states
    touched = {*edge.targets, *(initial for node in found for initial in node.initial)}
    in_flight = any(node.type == "history" for node in touched)
    return None if in_flight or any(node.default_actions for node in found) else tuple(found)
