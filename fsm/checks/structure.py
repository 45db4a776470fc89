"""Checks of a graph's structure that hold for YAML and SCXML alike: states that cannot be reached
or left, transitions that can never be taken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice, pairwise

from fsm.chart.entry_sets import default_entry
from fsm.chart.graph import Edge, Graph, Node
from vencejo.errors import Fault


def endless_states(graph: Graph, can_finish: Callable[[Node], bool]) -> Iterator[Fault]:
    """States that no transition leaves, neither their own nor one of a state around them.

    ``can_finish`` says of a region whether it can finish, and so end its parallel state.
    """
    moves = [any(edge.domain is not None for edge in node.edges()) for node in graph.nodes]
    leading_out = _regions_leading_out(graph)
    for node in graph.nodes:
        if node.children or node.type in ("final", "history"):
            continue
        if node.parent is graph.root and graph.root.type == "parallel" and can_finish(node):
            continue
        around = (node, *node.ancestors)
        # A transition leaves all that is inside its state, and one that leads out of a region all
        # that is inside the other regions.
        if not any(moves[place.index] for place in around) and not any(
            region is not leading
            for region, parent in pairwise(around)
            for leading in leading_out.get(parent.index, ())
        ):
            yield Fault(
                "no-way-out",
                f"nothing ever leaves '{node.path or graph.name}'",
                node.where,
                "give it a transition with a target, or make it final",
            )


def _regions_leading_out(graph: Graph) -> dict[int, list[Node]]:
    """For each parallel state, two of its regions from which a transition leads out of them; all
    where there are fewer.
    """
    outermost = [node.index for node in graph.nodes]
    for node in reversed(graph.nodes):
        domains = (edge.domain.index for edge in node.edges() if edge.domain is not None)
        children = (outermost[child.index] for child in node.children)
        outermost[node.index] = min((node.index, *domains, *children))
    return {
        node.index: list(
            islice((r for r in default_entry(node) if outermost[r.index] < r.index), 2)
        )
        for node in graph.nodes
        if node.type == "parallel"
    }


def leaves(edge: Edge, node: Node) -> bool:
    """Whether a transition leaves a state."""
    return edge.domain is not None and (edge.domain.contains(node) or edge.domain is node)


def _groups(node: Node) -> Iterator[tuple[Edge, ...]]:
    yield from (edges for _, edges in node.on)
    yield from (when.edges for when in node.whens)
    yield from (after.edges for after in node.afters)
    yield node.always


def dead_alternatives(graph: Graph, covers: Callable[[str, str], bool]) -> Iterator[Fault]:
    """Transitions that are never taken because one before them takes all their events.

    ``covers`` says whether its first pattern takes all events of its second.
    """
    for node in graph.nodes:
        for edges in _groups(node):
            for earlier, later in pairwise(edges):
                if earlier.guard is None and earlier.hold is None:
                    yield Fault(
                        "dead-alternative",
                        "this alternative is never reached: the one before it takes all",
                        later.where,
                        "give the one before it a guard, or put this one first",
                    )
        wide: list[str] = []
        for pattern, edges in node.on:
            above = next((each for each in wide if covers(each, pattern)), None)
            if above is not None and edges:
                yield Fault(
                    "dead-alternative",
                    f"'{pattern}' is never reached: '{above}' above it takes all",
                    edges[0].where,
                    f"put '{pattern}' before '{above}'",
                )
            if covers(pattern, f"{pattern}.more") and any(edge.guard is None for edge in edges):
                wide.append(pattern)


def endless_always(graph: Graph) -> Iterator[Fault]:
    """Loops of unguarded ``always`` transitions, which would never end."""
    seen: set[int] = set()
    for start in graph.nodes:
        walk: dict[int, Edge] = {}
        node: Node | None = start
        while node is not None and node.index not in seen:
            seen.add(node.index)
            edge = next((edge for edge in node.always if edge.guard is None), None)
            if edge is None:
                break
            if not edge.targets:
                yield Fault(
                    "endless-always",
                    "this `always` leads nowhere and never ends",
                    edge.where,
                    "give it a target or a guard; what is to be done once belongs to `entry`",
                )
            walk[node.index] = edge
            node = _entered(edge)
        if node is None or node.index not in walk:
            continue
        for edge in list(walk.values())[list(walk).index(node.index) :]:
            yield Fault(
                "endless-always",
                "these `always` transitions never end",
                edge.where,
                "give one of them a guard",
            )


def _entered(edge: Edge) -> Node | None:
    """The state in which a transition with one target ends, or the first on the way that has an
    ``always`` of its own.
    """
    if len(edge.targets) != 1:
        return None
    (node,) = edge.targets
    while node.initial and len(node.initial) == 1 and not node.always:
        node = node.initial[0]
    return node


def unreachable(graph: Graph) -> Iterator[Fault]:
    """States that no transition leads to; guards are taken to pass."""
    reached: set[int] = set()
    pending: list[Node] = [graph.root]

    def reach(nodes: Iterable[Node]) -> None:
        pending.extend(node for node in nodes if node.index not in reached)

    while pending:
        node = pending.pop()
        if node.index in reached:
            continue
        reached.add(node.index)
        reach(node.ancestors)
        reach(default_entry(node))
        for edge in node.edges():
            for target in edge.targets:
                reach((target, *(target.initial if target.type == "history" else ())))
    for node in graph.nodes:
        inside_unreached = node.parent is not None and node.parent.index not in reached
        if node.index not in reached and not inside_unreached:
            yield Fault(
                "unreachable",
                f"nothing leads to the state '{node.path}'",
                node.where,
                "remove it, or name it as a target",
                severity="warning",
            )
