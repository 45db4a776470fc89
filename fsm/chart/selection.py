"""Which transitions are taken together: SCXML's selection and its conflicts.

Functions of a configuration and of what history remembers (W3C recommendation of 2015, appendix D).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from fsm.chart.entry_sets import Recorded, transition_domain
from fsm.chart.graph import Edge, Node


def select(
    leaves: Iterable[Node],
    choose: Callable[[Node], Edge | None],
    recorded: Recorded,
    outer_first: bool,
) -> list[Edge]:
    """The transitions to take: for each active leaf its first, as far as they do not conflict.

    ``choose`` gives the transition that a state offers, or None; it is called once per state.
    """

    def in_conflict(a: Edge, b: Edge) -> bool:
        return exit_sets_meet(a, b, recorded)

    picked: list[Edge] = []
    chosen: dict[int, Edge | None] = {}
    for leaf in leaves:
        for node in chain(leaf, outer_first):
            if node.index not in chosen:
                chosen[node.index] = choose(node)
            edge = chosen[node.index]
            if edge is not None:
                if edge not in picked:
                    picked.append(edge)
                break
    return without_conflicts(picked, in_conflict, outer_first) if len(picked) > 1 else picked


def chain(node: Node, outer_first: bool) -> Sequence[Node]:
    """A state and its ancestors, in the order in which their transitions are tried."""
    around = (node, *node.ancestors)
    return around[::-1] if outer_first else around


def without_conflicts(
    edges: Iterable[Edge], in_conflict: Callable[[Edge, Edge], bool], outer_first: bool
) -> list[Edge]:
    """The transitions without those that are in conflict with a preferred one.

    A transition of an inner state is preferred to one of a state around it (with ``outer_first``
    it is not), otherwise the earlier one.
    """
    kept: list[Edge] = []
    for edge in edges:
        beaten: list[Edge] = []
        for other in kept:
            if not in_conflict(edge, other):
                continue
            if outer_first or not other.node.contains(edge.node):
                break
            beaten.append(other)
        else:
            kept = [other for other in kept if other not in beaten] + [edge]
    return kept


def exit_sets_meet(a: Edge, b: Edge, recorded: Recorded) -> bool:
    """Whether two transitions may leave the same states."""
    left, right = transition_domain(a, recorded), transition_domain(b, recorded)
    if left is None or right is None:
        return False
    return left is right or left.contains(right) or right.contains(left)
