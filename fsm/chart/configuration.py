"""Configurations of a graph: its sets of active states, and what follows from one alone.

A running graph visits few of its possible configurations, again and again. Everything that does
not depend on data (the leaves, the states with conditions or timers, the transitions that an event
may take, the changes that taking some of them makes) is derived when it is first needed and kept
in a :class:`Configurations`, which all instances of the graph share.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from fsm.chart.entry_sets import fixed_entry_set
from fsm.chart.executable import Record
from fsm.chart.graph import Edge, Graph, Node
from fsm.chart.selection import chain

MAX_CONFIGURATIONS = 10_000
"""Configurations kept for a graph; a full table is emptied and filled anew."""
MAX_KEPT = 100
"""Events, and steps, kept for a configuration."""

NO_DEFAULTS: Mapping[int, Sequence[Node]] = {}

K = TypeVar("K")
V = TypeVar("V")


@dataclass(slots=True)
class Entry:
    """The states that a microstep enters. Nobody changes one; frozen ones take longer to make."""

    states: Sequence[tuple[Node, int]]
    """Outer ones first, each with the mask of the configuration from its entry on."""
    mask: int
    """The mask of the configuration that results."""
    histories: Sequence[Node]
    """The history states through which states are restored with their data and progress."""
    defaults: Mapping[int, Sequence[Node]]
    """State index → the states whose default actions follow the entry actions of that state."""


@dataclass(frozen=True, slots=True)
class Step:
    """The changes that taking some transitions together makes, where they do not depend on data."""

    taken: tuple[tuple[Edge, Record], ...]
    """The transitions with what is recorded of each."""
    leaving: tuple[tuple[Node, int], ...]
    """The states left, inner ones first, each with the mask of the configuration without it."""
    mask: int
    """The mask of the configuration when all these have been left."""
    entering: tuple[Node, ...]
    """The states entered whatever happened before, outer ones first."""
    open: tuple[tuple[Edge, Node], ...]
    """Transitions whose entered states depend on history, or have default actions to be run, each
    with its domain."""
    entry: Entry | None
    """The states entered; None when some transitions are open."""


class Configuration:
    """A set of active states, in document order."""

    __slots__ = (
        "_by_state",
        "_graph",
        "_in_order",
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
        """States with conditions or timers."""
        self.throughout = tuple(node for node in self.states if node.throughout)
        self.behaving = tuple(node for node in self.states if node.invocation or node.given)
        """States with a behaviour, or with the parameters of an included graph."""
        self.always = any(node.always for node in self.states)
        self._in_order: dict[str, tuple[Edge, ...]] = {}
        self._by_state: dict[str, Mapping[int, tuple[Edge, ...]]] = {}
        self._steps: dict[tuple[Edge | Node | None, ...], Step] = {}

    def edges_in_order(self, event: str) -> tuple[Edge, ...]:
        """The transitions an event may take, in the order they are tried. For one active leaf."""
        found = self._in_order.get(event)
        if found is None:
            graph = self._graph
            edges = [
                edge
                for node in chain(self.leaves[0], graph.outer_first)
                for edge in node.edges_for(event, graph.vocabulary)
            ]
            found = _keep(self._in_order, event, tuple(edges))
        return found

    def edges_by_state(self, event: str) -> Mapping[int, tuple[Edge, ...]]:
        """The transitions that an event or outcome may take, by the index of their active state."""
        found = self._by_state.get(event)
        if found is None:
            vocabulary = self._graph.vocabulary
            edges = {node.index: node.edges_for(event, vocabulary) for node in self.states}
            found = _keep(self._by_state, event, {index: e for index, e in edges.items() if e})
        return found

    def step(self, edges: tuple[Edge, ...], narrowed: tuple[Node | None, ...] = ()) -> Step:
        """The changes that taking these transitions together makes.

        ``narrowed`` are the present domains of those where history decides on them, in their order.
        """
        key = edges + narrowed
        return self._steps.get(key) or _keep(self._steps, key, self._new_step(edges, narrowed))

    def _new_step(self, edges: tuple[Edge, ...], narrowed: Iterable[Node | None]) -> Step:
        narrow = iter(narrowed)
        domains = [next(narrow) if edge.by_history else edge.domain for edge in edges]
        left = [node for node in self.states if any(d and d.contains(node) for d in domains)]
        mask, leaving = self.mask, []
        for node in reversed(left):
            mask ^= node.mask
            leaving.append((node, mask))
        fixed = [fixed_entry_set(edge) for edge in edges]
        entered = {node for nodes in fixed for node in nodes or ()}
        entering = tuple(sorted(entered, key=lambda node: node.index))
        open_ = tuple(
            (edge, domain)
            for edge, domain, nodes in zip(edges, domains, fixed, strict=True)
            if domain is not None and nodes is None
        )
        return Step(
            tuple((edge, edge.taking) for edge in edges),
            tuple(leaving),
            mask,
            entering,
            open_,
            None if open_ else entry_after(mask, entering),
        )


class Configurations(dict[int, Configuration]):
    """The configurations of a graph by their masks: ``configurations[mask]`` always exists.

    At most MAX_CONFIGURATIONS are kept. Steps refer to the resulting configuration by its mask,
    so that one which was forgotten is not held by another.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def __missing__(self, mask: int) -> Configuration:
        return _keep(self, mask, Configuration(self._graph, mask), MAX_CONFIGURATIONS)


def entry_after(
    mask: int,
    nodes: Iterable[Node],
    histories: Sequence[Node] = (),
    defaults: Mapping[int, Sequence[Node]] = NO_DEFAULTS,
) -> Entry:
    """The entry of states, outer ones first, into the configuration of this mask."""
    states = []
    for node in nodes:
        mask |= node.mask
        states.append((node, mask))
    return Entry(states, mask, histories, defaults)


def mask_of(nodes: Iterable[Node]) -> int:
    """The mask of a set of states: bit n is set when the state of index n is among them."""
    mask = 0
    for node in nodes:
        mask |= node.mask
    return mask


def _states(nodes: Sequence[Node], mask: int) -> Sequence[Node]:
    found = []
    while mask:
        lowest = mask & -mask
        found.append(nodes[lowest.bit_length() - 1])
        mask ^= lowest
    return found


def _keep(known: dict[K, V], key: K, value: V, most: int = MAX_KEPT) -> V:
    """Add a value to a table that holds at most ``most``; a full table is emptied first."""
    if len(known) >= most:
        known.clear()
    known[key] = value
    return value
