"""The effects that each state of a graph can have when guards are ignored, as bit masks.

A mask has one bit for the index of each state. :mod:`fsm.checks.exploration` makes its moves of
them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from itertools import product
from typing import NamedTuple, TypeVar

from fsm.chart.entry_sets import Recorded, entry_set, transition_domain
from fsm.chart.graph import Edge, Graph, Node
from fsm.chart.selection import chain
from fsm.checks.regions import independent_states

Task = tuple[str, int, int] | None
"""The behaviour or timer that makes a move; None for a move that is made at once."""
T = TypeVar("T")


class Effect(NamedTuple):
    """The effect of a transition: which leaves and ends of behaviours it keeps, what it enters."""

    kept: int
    kept_ended: int
    entered: int


class Course(NamedTuple):
    """The effects that one outcome of a behaviour, or one timer, can have."""

    task: Task
    unless: int
    """The mask of ends after which it cannot happen any more."""
    mark: int
    """The mask of ends that it adds."""
    effects: tuple[Effect | None, ...]
    """None where no state is left."""


class Possibilities:
    """The moves that are possible in each state of a graph."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.nodes = graph.nodes
        self.independent = independent_states(graph)
        self.chains = [tuple(chain(node, graph.outer_first)) for node in graph.nodes]
        """Each state with its ancestors, in the order in which events are offered to them."""
        self._effects: dict[Edge, tuple[Effect, ...]] = {}
        self._choices: dict[tuple[int, str], list[Edge | None]] = {}

    @cached_property
    def landing(self) -> int:
        """The leaves in or around which a behaviour ends on the ground."""
        return self.mask(
            leaf
            for leaf in self.nodes
            if any(
                n.invocation and n.invocation.behavior.ends_landed for n in (leaf, *leaf.ancestors)
            )
        )

    @cached_property
    def with_always(self) -> int:
        """The leaves in or around which there is an ``always``."""
        return self.mask(
            leaf for leaf in self.nodes if any(n.always for n in (leaf, *leaf.ancestors))
        )

    @cached_property
    def finals(self) -> int:
        """The final states."""
        return self.mask(node for node in self.nodes if node.type == "final")

    @cached_property
    def ends(self) -> int:
        """The final states that end the mission."""
        return self.mask(
            n for n in self.nodes if n.type == "final" and owner_of(n) is self.graph.root
        )

    @cached_property
    def root_parallel(self) -> Node | None:
        """The parallel state, if any, whose end is the mission's."""
        owned = (n for n in self.nodes if n.type == "parallel" and n.owner is self.graph.root)
        return next(owned, None)

    @cached_property
    def triggered(self) -> list[tuple[Effect, ...]]:
        """For each leaf state, the effects of the transitions by events and conditions that it and
        its ancestors have.
        """
        here = [tuple(self._triggered(node)) for node in self.nodes]
        return [self._around(leaf, here) for leaf in self.nodes]

    @cached_property
    def courses(self) -> list[tuple[Course, ...]]:
        """For each leaf state, the courses of the behaviours and timers that it and its ancestors
        have.
        """
        here = [(*self._outcomes(node), *self._timers(node)) for node in self.nodes]
        return [self._around(leaf, here) for leaf in self.nodes]

    def _around(self, leaf: Node, here: Sequence[tuple[T, ...]]) -> tuple[T, ...]:
        if leaf.children:
            return ()
        found = (each for node in self.chains[leaf.index] for each in here[node.index])
        return tuple(dict.fromkeys(found))

    def _triggered(self, node: Node) -> Iterator[Effect]:
        events = (edges for trigger, edges in node.on if "." in trigger or trigger == "*")
        for edges in (*events, *(when.edges for when in node.whens)):
            for edge in edges:
                if edge.targets:
                    yield from self.effects(edge)

    def _outcomes(self, node: Node) -> Iterator[Course]:
        if node.invocation is None:
            return
        for word in {**node.invocation.behavior.outcomes, "failed": None}:
            mark = 1 << 2 * node.index + (word != "done")
            effects: list[Effect | None] = []
            for edge in self.choices(self.heard_by(node, word), word):
                if edge is not None and edge.targets:
                    effects += self.effects(edge)
                elif edge is not None or word != "failed":
                    effects.append(None)
                # A `failed` that nobody takes is the host's, and lands.
            yield Course(("do", node.index, 0), 3 << 2 * node.index, mark, tuple(effects))

    def _timers(self, node: Node) -> Iterator[Course]:
        for number, after in enumerate(node.afters):
            edges = [edge for edge in up_to_unguarded(after.edges) if edge and edge.targets]
            effects = tuple(effect for edge in edges for effect in self.effects(edge))
            yield Course(("after", node.index, number), 0, 0, effects)

    def effects(self, edge: Edge) -> tuple[Effect, ...]:
        """The effects of a transition; several where they depend on what history remembers."""
        found = self._effects.get(edge)
        if found is None:
            found = tuple(dict.fromkeys(self._new_effects(edge)))
            self._effects[edge] = found
        return found

    def _new_effects(self, edge: Edge) -> Iterator[Effect]:
        if edge.domain is None:
            yield Effect(-1, -1, 0)
            return
        for recorded in self._memories(edge.domain, edge.targets):
            domain = transition_domain(edge, recorded)
            assert domain is not None, "a transition with targets has a domain"
            first, size = domain.index + 1, domain.last - domain.index
            left, left_ended = (1 << size) - 1 << first, (1 << 2 * size) - 1 << 2 * first
            entered = entry_set(domain, edge.targets, recorded).states
            yield Effect(~left, ~left_ended, self.mask(entered))

    def mask(self, nodes: Iterable[Node]) -> int:
        """The mask of the leaves among these states, without those of independent regions."""
        found = 0
        for node in nodes:
            if not node.children and node.index not in self.independent:
                found |= node.mask
        return found

    def entries(self, domain: Node, targets: tuple[Node, ...]) -> list[list[Node]]:
        """The sets of states that may be entered; history may give any that it could remember."""
        return [
            entry_set(domain, targets, recorded).states
            for recorded in self._memories(domain, targets)
        ]

    def _memories(self, domain: Node, targets: tuple[Node, ...]) -> Iterator[Recorded]:
        """What the history states may remember that are asked for on the way to these targets."""
        asked: dict[Node, None] = {}

        def nothing(history: Node) -> None:
            asked[history] = None

        entry_set(domain, targets, nothing)
        for picked in product(*map(_remembered, asked)):
            yield dict(zip(asked, picked, strict=True)).get

    def choices(self, nodes: Sequence[Node], word: str) -> list[Edge | None]:
        """The transitions that may take an event; None at the end where all may refuse it."""
        found: list[Edge | None] = []
        for node in nodes:
            for edge in node.edges_for(word, self.graph.vocabulary):
                found.append(edge)
                if edge.guard is None:
                    return found
        return [*found, None]

    def heard_by(self, owner: Node, word: str) -> Sequence[Node]:
        """The states that an outcome is offered to; only `failed` climbs out of its graph."""
        around = self.chains[owner.index]
        if word == "done":
            return (owner,)
        if word == "failed":
            return around
        within = tuple(owner.outwards())
        return [node for node in around if node in within]

    def takers(self, event: str) -> int:
        """The mask of the leaves in or around which a transition may take an event."""
        return self.mask(leaf for leaf in self.nodes if self.offered(leaf.index, event) != [None])

    def offered(self, leaf: int, event: str) -> list[Edge | None]:
        """The transitions that may take an event which is offered to a leaf and then outwards."""
        found = self._choices.get((leaf, event))
        if found is None:
            found = self._choices[leaf, event] = self.choices(self.chains[leaf], event)
        return found


def owner_of(final: Node) -> Node:
    """The state that a final state ends."""
    assert final.parent is not None
    return final.parent.owner


def up_to_unguarded(edges: Sequence[Edge]) -> list[Edge | None]:
    """The alternatives up to the first without a guard; None at the end if all have one."""
    found: list[Edge | None] = []
    for edge in edges:
        found.append(edge)
        if edge.guard is None:
            return found
    return [*found, None]


def _remembered(history: Node) -> list[tuple[Node, ...] | None]:
    """The sets of states that a history state may remember; None as long as it remembers none."""
    assert history.parent is not None
    among = inside(history.parent) if history.deep else iter(history.parent.children)
    options = [n for n in among if n.type != "history" and not (history.deep and n.children)]
    if history.parent.type == "parallel":
        return [None, tuple(options)]
    return [None, *((node,) for node in options)]


def inside(node: Node | None) -> Iterator[Node]:
    """Every state inside a state, in document order."""
    for child in node.children if node else ():
        yield child
        yield from inside(child)
