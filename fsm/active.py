"""One configuration of a graph, and what follows from it alone.

A running graph visits few of its possible configurations, again and again. What can be told from
one without looking at data (its leaves, which states wait or fly, whom an event asks, who is left
when a domain is) is worked out at the first visit and shared by all instances.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fsm.selection import chain

if TYPE_CHECKING:
    from fsm.graph import Edge, Graph, Node

MOST = 10_000
"""Configurations that are kept; beyond that all are forgotten and worked out anew."""


class Active:
    """The active states of one moment, in document order."""

    __slots__ = (
        "_asked",
        "_graph",
        "_leaving",
        "always",
        "behaving",
        "leaves",
        "mask",
        "states",
        "throughout",
        "waiting",
    )

    def __init__(self, graph: Graph, mask: int) -> None:
        self._graph = graph
        self.mask = mask
        """Bit n stands for the state of index n."""
        self.states = tuple(_states(graph.nodes, mask))
        self.leaves = tuple(node for node in self.states if not node.children)
        self.waiting = tuple(node for node in self.states if node.whens or node.afters)
        self.throughout = tuple(node for node in self.states if node.throughout)
        self.behaving = tuple(node for node in self.states if node.invocation or node.given)
        self.always = any(node.always for node in self.states)
        self._asked: dict[str, tuple[Edge, ...]] = {}
        self._leaving: dict[int, tuple[Node, ...]] = {}

    def asked(self, event: str) -> tuple[Edge, ...]:
        """Where one leaf is active: the transitions an event may take, in the order of asking."""
        found = self._asked.get(event)
        if found is None:
            graph = self._graph
            found = self._asked[event] = tuple(
                edge
                for node in chain(self.leaves[0], graph.outer_first)
                for edge in node.edges_for(event, graph.vocabulary)
            )
        return found

    def leaving(self, domain: Node) -> tuple[Node, ...]:
        """The states left when the inside of ``domain`` is, inner ones first."""
        found = self._leaving.get(domain.index)
        if found is None:
            inside = [node for node in self.states if domain.contains(node)]
            found = self._leaving[domain.index] = tuple(reversed(inside))
        return found


def _states(nodes: Sequence[Node], mask: int) -> Sequence[Node]:
    found = []
    while mask:
        lowest = mask & -mask
        found.append(nodes[lowest.bit_length() - 1])
        mask ^= lowest
    return found


def active(graph: Graph, mask: int) -> Active:
    """The configuration of that mask."""
    known = graph.visited
    found = known.get(mask)
    if found is None:
        if len(known) >= MOST:
            known.clear()
        found = known[mask] = Active(graph, mask)
    return found
