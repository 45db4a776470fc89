"""Which regions of parallel states have nothing to do with what is outside of them."""

from __future__ import annotations

from fsm.chart.entry_sets import default_entry
from fsm.chart.graph import Graph, Node


def regions_apart(graph: Graph) -> frozenset[int]:
    """The states of regions that change nothing outside themselves; they are not followed.

    Such a region takes no event that must land, lands nothing, has no transition and no outcome
    that leads out of it, and nobody waits for it to finish.
    """
    apart: set[int] = set()
    for parallel in graph.nodes:
        if parallel.type != "parallel" or parallel.index in apart:
            continue
        waited_for = any(
            place.type == "parallel"
            and (place.owner.parent is None or place.owner.edges_for("done", graph.vocabulary))
            for place in (parallel, *parallel.ancestors)
        )
        if waited_for:
            continue
        regions = default_entry(parallel)
        alone = [region for region in regions if _stands_apart(graph, parallel, region)]
        if len(alone) == len(regions):
            alone = alone[1:]
        for region in alone:
            apart.update(range(region.index, region.last + 1))
    return frozenset(apart)


def _stands_apart(graph: Graph, parallel: Node, region: Node) -> bool:
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
