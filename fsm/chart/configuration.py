"""One configuration of a graph, and what follows from it alone.

A running graph visits few of its possible configurations, again and again. What can be told from
one without looking at data (its leaves, which states wait or fly, whom an event asks, who is left
when a domain is) is worked out at the first visit and shared by all instances.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from fsm.chart.entry_sets import fixed_entry_set
from fsm.chart.graph import Edge, Graph, Node, Record
from fsm.chart.selection import chain

MOST = 10_000
"""Configurations that are kept; beyond that all are forgotten and worked out anew."""


@dataclass(frozen=True, slots=True)
class Step:
    """What taking some transitions together changes, as far as the configuration tells."""

    taken: tuple[tuple[Edge, Record], ...]
    """The transitions with what is recorded of each."""
    leaving: tuple[Node, ...]
    """The states left, inner ones first."""
    entering: tuple[Node, ...]
    """The states entered whatever happened before, outer ones first."""
    open: tuple[Edge, ...]
    """Transitions of which only history, or what happens on the way, tells what they enter."""
    after: Active | None
    """The configuration that results; None when some are open."""


class Active:
    """The active states of one moment, in document order."""

    __slots__ = (
        "_asked",
        "_graph",
        "_steps",
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
        self._steps: dict[tuple[Edge, ...], Step] = {}

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

    def step(self, edges: tuple[Edge, ...]) -> Step:
        """What taking these transitions changes."""
        return self._steps.get(edges) or self._new_step(edges)

    def _new_step(self, edges: tuple[Edge, ...]) -> Step:
        domains = [edge.domain for edge in edges if edge.domain is not None]
        left = [node for node in self.states if any(domain.contains(node) for domain in domains)]
        fixed = [fixed_entry_set(edge) for edge in edges]
        entered = {node for nodes in fixed for node in nodes or ()}
        entering = tuple(sorted(entered, key=lambda node: node.index))
        open_ = tuple(e for e, nodes in zip(edges, fixed, strict=True) if nodes is None)
        step = self._steps[edges] = Step(
            tuple((edge, edge.taking) for edge in edges),
            tuple(reversed(left)),
            entering,
            open_,
            None if open_ else self.changed(left, entering),
        )
        return step

    def changed(self, leaving: Iterable[Node], entering: Iterable[Node]) -> Active:
        """The configuration after these states were left and those entered."""
        mask = self.mask
        for node in leaving:
            mask ^= node.mask
        for node in entering:
            mask |= node.mask
        return active(self._graph, mask)


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
