"""The safety proof: whatever happens, after an event that must end on the ground the mission lands.

Reachability ignores guards and lets every event and outcome happen. In every configuration that
can be reached, each event of ``Vocabulary.must_land`` is offered: a transition is taken, or the
host reacts. From there only outcomes and ``after`` are followed; every path must reach a state
whose behaviour ends landed, or the mission's end, where the host lands. A path that stays in a
loop counts, unless a behaviour or a timer is left out for ever there that was due all along
(weak fairness). Loops are found as strongly connected components (Tarjan 1972).
"""

from __future__ import annotations

from collections.abc import Iterator

from fsm.chart.graph import Edge, Graph, Node
from fsm.checks import exploration
from fsm.checks.exploration import Config, Explorer, TooManyError
from fsm.checks.possibilities import inside
from vencejo.errors import Fault


def prove(graph: Graph) -> list[Fault]:
    """Warnings (``never-lands``, ``not-proven``) where the proof fails; none when it holds."""
    if not graph.vocabulary.must_land:
        return []
    if any(node.invocation and node.invocation.behavior.on_trust for node in graph.nodes):
        return [_not_proven(graph, "its own behaviours were not looked at")]
    if any(_hard_history(node) for node in graph.nodes):
        return [_not_proven(graph, "a deep history of parallel states is too hard to follow")]
    try:
        return list(_violations(Explorer(graph)))
    except TooManyError:
        reason = (
            f"there are more than {exploration.MAX_CONFIGURATIONS:,} combinations of active states"
        )
        return [_not_proven(graph, reason)]


def _not_proven(graph: Graph, reason: str) -> Fault:
    return Fault(
        "not-proven",
        f"it is not proven that this mission always lands: {reason}",
        graph.root.where,
        f"test it with {', '.join(graph.vocabulary.must_land)} in flight",
        "warning",
    )


def _hard_history(node: Node) -> bool:
    return node.deep and any(_parallels(child) for child in (node.parent, *inside(node.parent)))


def _parallels(node: Node | None) -> bool:
    return node is not None and node.type == "parallel"


def _violations(explorer: Explorer) -> Iterator[Fault]:
    came_from = explorer.reach()
    stuck_after = explorer.endless(explorer.answers(came_from))
    if not stuck_after:
        return
    told: set[tuple[str, int]] = set()
    for config in came_from:
        for event in explorer.takers:
            for edges, answer in explorer.answer(config, event):
                if answer in stuck_after and (event, id(edges[0])) not in told:
                    told.add((event, id(edges[0])))
                    yield _violation(explorer, event, edges[0], config, came_from, stuck_after)


def _violation(
    explorer: Explorer,
    event: str,
    edge: Edge,
    config: Config,
    came_from: dict[Config, Config | None],
    stuck_after: dict[Config, Config | None],
) -> Fault:
    before = [config]
    while (earlier := came_from[before[0]]) is not None:
        before.insert(0, earlier)
    after = [next(a for e, a in explorer.answer(config, event) if a in stuck_after and edge in e)]
    while (later := stuck_after[after[-1]]) is not None and later not in after:
        after.append(later)
    end = "where it stays" if later is None else f"{explorer.name(later)}, and so on"
    path, then = (" → ".join(map(explorer.name, configs)) for configs in (before, after))
    return Fault(
        "never-lands",
        f"'{event}' may leave the vehicle in the air for ever: {path}, then '{event}' → {then}"
        + (" → " if later is not None else ", ")
        + end,
        edge.where,
        "lead it to a state that lands, give the last state `after`, or leave the event to the "
        "host, which lands",
        "warning",
    )
