"""Which states a transition enters: SCXML's entry sets, and default entries.

Functions of the graph and of what history remembers (W3C recommendation of 2015, appendix D).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable

from fsm.chart.graph import Edge, Node


def default_entry(node: Node) -> tuple[Node, ...]:
    """Where an entry of a compound state goes on to, or the regions of a parallel one."""
    if node.type == "parallel":
        return tuple(child for child in node.children if child.type != "history")
    return node.initial


def entry_set(
    domain: Node,
    targets: Iterable[Node],
    recorded: Callable[[Node], tuple[Node, ...]],
    defaulted: Callable[[Node], None] = lambda node: None,
) -> list[Node]:
    """The states that a transition enters below ``domain``, in document order.

    SCXML's computeEntrySet (W3C recommendation, appendix D); ``recorded`` gives the states a
    history state stands for, ``defaulted`` is told of each state entered by its ``initial``.
    """
    entering: dict[int, Node] = {}

    def enter(targets: Iterable[Node], stop: Node | None) -> None:
        # All of them first: what is around one must not fill another's region with its default.
        targets = tuple(targets)
        for target in targets:
            descend(target)
        for target in targets:
            climb(target, stop)

    def descend(node: Node) -> None:
        if node.type == "history":
            enter(recorded(node), node.parent)
            return
        entering[node.index] = node
        if node.type == "compound":
            defaulted(node)
            enter(node.initial, node)
        elif node.type == "parallel":
            fill(node)

    def climb(node: Node, stop: Node | None) -> None:
        for ancestor in node.ancestors:
            if ancestor is stop:
                return
            new = ancestor.index not in entering
            entering[ancestor.index] = ancestor
            if new and ancestor.type == "parallel":
                fill(ancestor)

    def fill(parallel: Node) -> None:
        filled = sorted(entering)
        for region in default_entry(parallel):
            first = bisect_left(filled, region.index)
            if first == len(filled) or filled[first] > region.last:
                descend(region)

    enter(targets, domain)
    return [entering[index] for index in sorted(entering)]


def fixed_entry_set(edge: Edge) -> tuple[Node, ...] | None:
    """The states that a transition enters whatever happened before, outer ones first.

    None when that is found in flight, because history decides it or default entries have actions
    of their own.
    """
    if edge.domain is None:
        return ()
    found = entry_set(edge.domain, edge.targets, lambda history: ())
    touched = {*edge.targets, *(initial for node in found for initial in node.initial)}
    in_flight = any(node.type == "history" for node in touched)
    return None if in_flight or any(node.default_actions for node in found) else tuple(found)
