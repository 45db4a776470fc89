"""Finds regions of parallel states that have no effect on the rest of their graph."""

from __future__ import annotations

from fsm.chart.entry_sets import default_entry
from fsm.chart.graph import Graph, Node


def independent_states(graph: Graph) -> frozenset[int]:
    """The indices of all states in independent regions; the safety proof leaves them out.

    An independent region handles no event that must land, has no behaviour that lands, no
    transition and no outcome that leads out of it, and nothing waits for it to finish.
    """
    independent: set[int] = set()
    for parallel in graph.nodes:
        if parallel.type != "parallel" or parallel.index in independent:
            continue
        waited_for = any(
            place.type == "parallel"
            and (place.owner.parent is None or place.owner.edges_for("done", graph.vocabulary))
            for place in (parallel, *parallel.ancestors)
        )
        if waited_for:
            continue
        regions = default_entry(parallel)
        alone = [region for region in regions if _is_independent(graph, parallel, region)]
        if len(alone) == len(regions):
            alone = alone[1:]
        for region in alone:
            independent.update(range(region.index, region.last + 1))
    return frozenset(independent)


def _is_independent(graph: Graph, parallel: Node, region: Node) -> bool:
    vocabulary = graph.vocabulary
    around = (parallel, *parallel.ancestors)
    for node in graph.nodes[region.index : region.last + 1]:
        words = {node.outcome} if node.type == "final" else set()
        if node.invocation:
            words |= {*node.invocation.behavior.outcomes, "failed"}
            if node.invocation.behavior.ends_landed:
                return False
        if any(node.edges_for(event, vocabulary) for event in vocabulary.must_land):
            return False
        if any(place.edges_for(word, vocabulary) for place in around for word in words - {"done"}):
            return False
        for edge in node.edges():
            domain = edge.domain
            if domain is not None and domain is not region and not region.contains(domain):
                return False
    return True
