"""Finds regions of parallel states that have no effect on the rest of their graph."""

from __future__ import annotations

from collections.abc import Iterator

from fsm.chart.entry_sets import default_entry
from fsm.chart.executable import Action
from fsm.chart.graph import Graph, Node


def independent_states(graph: Graph) -> frozenset[int]:
    """The indices of all states in independent regions; the safety proof leaves them out.

    An independent region handles no event that must land and none that the mission raises, raises
    none, has no behaviour that lands or takes off, no transition and no outcome that leads out of
    it, and nothing waits for it to finish.
    """
    independent: set[int] = set()
    if any(edge.by_history for node in graph.nodes for edge in node.edges()):
        # What such a transition leaves depends on all that was active.
        return frozenset()
    if not any(node.type == "parallel" for node in graph.nodes):
        return frozenset()
    alone = _Alone(graph)
    for parallel in graph.nodes:
        if parallel.type != "parallel" or parallel.index in independent:
            continue
        around = (parallel, *parallel.ancestors)
        if any(alone.is_waited_for(place) for place in around):
            continue
        regions = default_entry(parallel)
        heard = _outcomes_taken(around)
        apart = [region for region in regions if alone.is_independent(region, heard)]
        if len(apart) == len(regions):
            apart = apart[1:]
        for region in apart:
            independent.update(range(region.index, region.last + 1))
    return frozenset(independent)


class _Alone:
    """Questions about the regions of one graph."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        raised = {action.event for node in graph.nodes for action in actions_of(node)} - {""}
        self._events = raised | set(graph.vocabulary.must_land)

    def is_waited_for(self, place: Node) -> bool:
        """Whether something happens when a parallel state has finished."""
        if place.type != "parallel":
            return False
        ends_mission = place.owner.parent is None
        return ends_mission or bool(place.owner.edges_for("done", self.graph.vocabulary))

    def is_independent(self, region: Node, heard: frozenset[str]) -> bool:
        """Whether a region is, when the states around it take the outcomes ``heard``."""
        nodes = self.graph.nodes[region.index : region.last + 1]
        return not any(self._matters(node, region, heard) for node in nodes)

    def _matters(self, node: Node, region: Node, heard: frozenset[str]) -> bool:
        words = {node.outcome} if node.type == "final" else set()
        if node.invocation:
            behavior = node.invocation.behavior
            words |= {*behavior.outcomes, "failed"}
            if behavior.ends_landed or behavior.may_take_off:
                return True
        if words and ("*" in heard or words & heard):
            return True
        if any(action.event for action in actions_of(node)) or self._takes_some(node):
            return True
        domains = (edge.domain for edge in node.edges())
        return any(not (d is None or d is region or region.contains(d)) for d in domains)

    def _takes_some(self, node: Node) -> bool:
        """Whether a state takes an event that must land, or that the mission raises."""
        vocabulary = self.graph.vocabulary
        return any(
            pattern in self._events
            or ("*" in pattern and any(node.matches(pattern, e, vocabulary) for e in self._events))
            for pattern, edges in node.on
            if edges
        )


def _outcomes_taken(around: tuple[Node, ...]) -> frozenset[str]:
    """The outcomes that these states take, and that may come from inside them."""
    words = {pattern for place in around for pattern, edges in place.on if edges}
    return frozenset(word for word in words if "." not in word) - {"done"}


def actions_of(node: Node) -> Iterator[Action]:
    """All actions that stand in a state."""
    yield from (*node.entry, *node.default_actions, *node.exit_actions, *node.throughout)
    for edge in node.edges():
        yield from edge.actions
