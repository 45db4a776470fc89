"""Checks of a compiled mission: every outcome is handled, every state can be left, no two
behaviours control the same thing.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Collection, Iterator, Mapping
from functools import partial

from fsm.chart.entry_sets import default_entry
from fsm.chart.graph import After, Edge, Graph, Node
from fsm.checks.messages import unheard
from fsm.checks.structure import (
    dead_alternatives,
    dead_timers,
    endless_always,
    endless_states,
    late_timers,
    never_taken,
    reachable,
    repeated_conditions,
    unreachable,
)
from fsm.host import PERIOD, Vocabulary, matches
from vencejo.errors import Fault


def check(graph: Graph, flawed: Collection[Node] = ()) -> list[Fault]:
    """All faults of a mission's structure, errors and warnings.

    ``flawed`` are states whose transitions have faults already; faults that may be mere
    consequences of those are left out.
    """
    late = late_timers(graph)
    missed = (*_unhandled_outcomes(graph), *endless_states(graph, _can_finish))
    doubtful = {node.where for node in graph.nodes if _in_doubt(node, flawed)}
    return [
        *(fault for fault in missed if fault.where not in doubtful),
        *(() if flawed else _whole(graph, late)),
        *_companions(graph),
        *_two_owners(graph),
        *_region_restarts(graph),
        *dead_alternatives(
            [node for node in graph.nodes if node not in flawed],
            partial(_covers, graph.vocabulary),
        ),
        *_durations(graph),
        *_holds(graph),
        *repeated_conditions(graph),
        *_final_regions(graph),
        *_restarting_histories(graph),
        *_always_on_the_world(graph),
        *_hidden_handlers(graph),
        *_left_landings(graph),
    ]


def _whole(graph: Graph, late: Mapping[After, After]) -> Iterator[Fault]:
    """Faults that only a graph shows all of whose transitions are known."""
    yield from unreachable(graph, reachable(graph, never_taken(graph, late)))
    yield from _never_done(graph)
    yield from unheard(graph)
    yield from endless_always(graph)
    yield from dead_timers(late)


def _in_doubt(node: Node, flawed: Collection[Node]) -> bool:
    """Whether a flawed state may be the one that handles this one's outcomes, or leaves it."""
    if not flawed:
        return False
    around = (node, *node.ancestors)
    return any(place in flawed or place.type == "parallel" for place in around)


def _handles(node: Node, word: str, graph: Graph) -> tuple[Edge, ...]:
    return node.edges_for(word, graph.vocabulary)


def _unhandled_outcomes(graph: Graph) -> Iterator[Fault]:
    for node in graph.nodes:
        words = set(node.invocation.behavior.outcomes) if node.invocation else set()
        if node.children:
            words.discard("done")  # not allowed there: see `_companions`
        if node.type == "compound" and node.parent is not None:
            words |= _ends(node)
        finishes = node.type == "parallel" and _can_finish(node)
        if finishes and node.parent is not None and node.owner is node:
            words.add("done")
        for word in sorted(words - {"failed"}):
            chain = (node,) if word == "done" else tuple(node.outwards())
            edges = [edge for around in chain for edge in _handles(around, word, graph)]
            region = node.parent is not None and node.parent.type == "parallel"
            if not edges and not (word == "done" and region):
                what = (
                    f"'{node.invocation.behavior.name}' ends"
                    if node.invocation
                    else "this state ends"
                )
                yield Fault(
                    "unhandled-outcome",
                    f"{what} with '{word}', and nothing in '{node.path}' says what comes then",
                    node.where,
                    f"on: {{{word}: …}}"
                    + ("" if word == "done" else ", here or in a state around it"),
                )
            elif edges and all(edge.guard is not None for edge in edges):
                yield Fault(
                    "guarded-outcome",
                    f"every way out of '{word}' has a guard: none may pass",
                    edges[-1].where,
                    "end the list with an alternative without guard",
                )


def _ends(node: Node) -> set[str]:
    """The outcomes with which a compound state ends by its final children."""
    if node.owner is not node:
        return set()
    while node.children and node.children[0].border:
        (node,) = node.children
    if node.type == "parallel":
        return {"done"} if _can_finish(node) else set()
    return {child.outcome for child in node.children if child.type == "final"}


def _can_finish(node: Node) -> bool:
    if node.children and node.children[0].border:
        return _can_finish(node.children[0])
    if node.type == "parallel":
        return all(map(_can_finish, default_entry(node)))
    if node.children:
        return any(child.type == "final" for child in node.children)
    if node.invocation is None:
        return False
    return node.invocation.behavior.on_trust or "done" in node.invocation.behavior.outcomes


def _companions(graph: Graph) -> Iterator[Fault]:
    for node in graph.nodes:
        if node.children and node.invocation and "done" in node.invocation.behavior.outcomes:
            yield Fault(
                "ending-companion",
                f"'{node.invocation.behavior.name}' ends by itself and cannot accompany states",
                node.where,
                "`done` of a state with `states` means its children; move it into one of them",
            )


def _controls(node: Node) -> set[str]:
    return set(node.invocation.behavior.controls) if node.invocation else set()


def _two_owners(graph: Graph) -> Iterator[Fault]:
    for node in graph.nodes:
        for ancestor in node.ancestors:
            for shared in sorted(_controls(node) & _controls(ancestor)):
                yield _owners(node, ancestor, shared)
        if node.type != "parallel":
            continue
        seen: dict[str, Node] = {}
        for region in default_entry(node):
            own: dict[str, Node] = {}
            for inner in graph.nodes[region.index : region.last + 1]:
                own.update(dict.fromkeys(_controls(inner), inner))
            for shared in sorted(set(own) & set(seen)):
                yield _owners(own[shared], seen[shared], shared)
            seen.update(own)


def _owners(a: Node, b: Node, what: str) -> Fault:
    return Fault(
        "two-owners",
        f"'{a.path}' and '{b.path}' can be active together and both control the {what}",
        a.where,
        "only one behaviour at a time may",
    )


def _region_restarts(graph: Graph) -> Iterator[Fault]:
    """Targets that exit and enter the sibling regions too, by the W3C's rules."""
    for node in graph.nodes:
        for edge in node.edges():
            if edge.reenter or edge.domain is None:
                continue
            for parallel in (node, *node.ancestors):
                if (
                    parallel.type == "parallel"
                    and any(parallel.contains(target) for target in edge.targets)
                    and edge.domain is not None
                    and not parallel.contains(edge.domain)
                ):
                    yield Fault(
                        "region-restart",
                        f"this target restarts all regions of '{parallel.path}'",
                        edge.where,
                        "say so with `reenter: true`, or choose a target inside the region",
                    )
                    break


def _durations(graph: Graph) -> Iterator[Fault]:
    for node in graph.nodes:
        seen: dict[float, str] = {}
        for after in node.afters:
            if not after.duration.constant:
                continue
            seconds = float(after.duration.value())
            if seconds < PERIOD:
                yield Fault(
                    "short-duration",
                    f"'{after.duration.source}' is shorter than a mission period (25 ms)",
                    after.duration.where,
                    "it is taken in the first period after the state was entered",
                    severity="warning",
                )
            if seconds in seen:
                yield Fault(
                    "equal-durations",
                    f"'{after.duration.source}' is the same as '{seen[seconds]}'",
                    after.duration.where,
                    "write one duration with a list of alternatives",
                )
            seen[seconds] = after.duration.source


def _holds(graph: Graph) -> Iterator[Fault]:
    for node in graph.nodes:
        for when in node.whens:
            for edge in when.edges:
                hold = edge.hold
                if hold is not None and hold.constant and float(hold.value()) < PERIOD:
                    yield Fault(
                        "short-duration",
                        f"'{hold.source}' is shorter than a mission period (25 ms)",
                        hold.where,
                        "leave `for` out: the condition is tested once a period",
                        severity="warning",
                    )


def _final_regions(graph: Graph) -> Iterator[Fault]:
    for node in graph.nodes:
        if node.type == "final" and node.parent is not None and node.parent.type == "parallel":
            yield Fault(
                "final-region",
                f"'{node.path}' is a region, and a region cannot be final",
                node.where,
                "put it inside a region, or the parallel state inside another one",
            )


def _never_done(graph: Graph) -> Iterator[Fault]:
    for node in graph.nodes:
        if node.type == "parallel" and not _can_finish(node):
            for pattern, edges in node.on:
                endless = next(r for r in default_entry(node) if not _can_finish(r))
                if pattern == "done" and edges:
                    yield Fault(
                        "never-done",
                        f"'{node.path}' is never done: its region '{endless.path}' has no end",
                        edges[0].where,
                        "give that region a final state, or leave on something else",
                    )


def _restarting_histories(graph: Graph) -> Iterator[Fault]:
    """A history state entered only from inside its parent, which is never left and remembered."""
    entering: dict[Node, list[Edge]] = {}
    for edge in (edge for node in graph.nodes for edge in node.edges()):
        for target in edge.targets:
            if target.type == "history":
                entering.setdefault(target, []).append(edge)
    for history, edges in entering.items():
        parent = history.parent
        if parent is None or not history.initial:
            continue
        if all(edge.domain is parent or edge.domain is None for edge in edges):
            yield Fault(
                "empty-history",
                f"'{parent.path or graph.name}' is not left on the way to '{history.path}', "
                "so its history remembers nothing",
                edges[0].where,
                "put the states that are to be remembered inside a state of their own, and the "
                "history with them",
                severity="warning",
            )


def _always_on_the_world(graph: Graph) -> Iterator[Fault]:
    for node in graph.nodes:
        for edge in node.always:
            if edge.guard and edge.guard.reads & {"host", "published", "entered"}:
                yield Fault(
                    "always-on-the-world",
                    f"'{edge.guard.source}' is not tested again because the world changes",
                    edge.guard.where,
                    "`always` is for choices; to wait for a condition write it under `when`",
                    severity="warning",
                )


def _hidden_handlers(graph: Graph) -> Iterator[Fault]:
    """Inner states that handle an urgent event which a state around them handles too."""
    if graph.outer_first:
        return
    for node in graph.nodes:
        for event, edges in node.on:
            if not edges or not graph.vocabulary.is_urgent(event):
                continue
            for outer in node.ancestors:
                if outer.edges_for(event, graph.vocabulary):
                    yield Fault(
                        "hidden-handler",
                        f"'{event}' is taken here before '{outer.path or graph.name}' hears of it",
                        edges[0].where,
                        "remove one of the two handlers",
                        severity="warning",
                    )
                    break


def _left_landings(graph: Graph) -> Iterator[Fault]:
    """Transitions of states around landings that can break them off."""
    landings = [n for n in graph.nodes if n.invocation and n.invocation.behavior.ends_landed]
    indices = [node.index for node in landings]
    for outer in graph.nodes:
        inside = landings[bisect(indices, outer.index) : bisect(indices, outer.last)]
        if not inside:
            continue
        more = f" and {len(inside) - 1} more" if len(inside) > 1 else ""
        for edge in outer.edges():
            outcome = edge.kind == "on" and "." not in edge.trigger
            # Whatever leaves a state leaves all that is inside.
            if not outcome and edge.domain is not None:
                yield Fault(
                    "left-landing",
                    f"`{edge.kind} {edge.trigger}` can break off the landing in "
                    f"'{inside[0].path}'{more}",
                    edge.where,
                    "move the landing out of this state",
                    severity="warning",
                )


def _covers(vocabulary: Vocabulary, pattern: str, event: str) -> bool:
    """Whether every event that matches ``event`` matches ``pattern`` as well."""
    if pattern == "*":
        name = event.removesuffix(".*") + (".x" if event.endswith(".*") else "")
        return not name.startswith("error.") and not vocabulary.is_urgent(name)
    return matches(pattern, event)
