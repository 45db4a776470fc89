"""Checks of a graph's structure that hold for YAML and SCXML alike: states that cannot be reached
or left, transitions that can never be taken.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import islice, pairwise

from fsm.chart.entry_sets import default_entry
from fsm.chart.graph import After, Edge, Graph, Node
from fsm.expressions.compiled import Compiled
from vencejo.errors import Fault

_FLIPPED = re.compile(r"\(([^\s()]+) >(=?) ([^\s()]+)\)")
"""Compiled code of `a > b`, which says the same as `b < a`."""


def endless_states(graph: Graph, can_finish: Callable[[Node], bool]) -> Iterator[Fault]:
    """States that no transition leaves, neither their own nor one of a state around them.

    ``can_finish`` says of a region whether it can finish, and so end its parallel state.
    """
    moves = [any(edge.domain is not None for edge in node.edges()) for node in graph.nodes]
    leading_out = _regions_leading_out(graph)
    for node in graph.nodes:
        if node.children or node.type in ("final", "history", "compound"):
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


def _groups(node: Node) -> Iterator[tuple[Edge, ...]]:
    yield from (edges for _, edges in node.on)
    yield from (when.edges for when in node.whens)
    yield from (after.edges for after in node.afters)
    yield node.always


def dead_alternatives(nodes: Iterable[Node], covers: Callable[[str, str], bool]) -> Iterator[Fault]:
    """Transitions of states that are never taken because one before them takes all their events,
    or has the same guard.

    ``covers`` says whether its first pattern takes all events of its second.
    """
    for node in nodes:
        for edges in _groups(node):
            if len(edges) < 2:
                continue
            guards = [edge.guard for edge in edges if edge.guard is not None and not edge.hold]
            yield from _repeated(guards, "guard")
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


def never_taken(graph: Graph, late: Iterable[After]) -> set[Edge]:
    """The transitions that are never taken: by constant conditions, or by ``late`` timers."""
    found: set[Edge] = set()
    for node in graph.nodes:
        for edge in node.edges():
            if edge.guard is not None and _is_false(edge.guard):
                found.add(edge)
        for when in node.whens:
            if _is_false(when.condition):
                found.update(when.edges)
    for after in late:
        found.update(after.edges)
    return found


def _is_false(condition: Compiled) -> bool:
    return condition.constant and condition.value() is False


def dead_timers(late: Mapping[After, After]) -> Iterator[Fault]:
    """Timers of a state that is sure to be left before they are due, each by another."""
    for after, earlier in late.items():
        yield Fault(
            "dead-timer",
            f"'{after.duration.source}' never comes: '{earlier.duration.source}' "
            f"({earlier.duration.where}) leaves the state before",
            after.duration.where,
            "make it shorter, or remove it",
            severity="warning",
        )


def late_timers(graph: Graph) -> dict[After, After]:
    """The timers that never come, each with one that is sure to leave its state before."""
    found: dict[After, After] = {}
    leaving = {node.index: _first_to_leave(node) for node in graph.nodes if node.afters}
    for node in graph.nodes:
        if not node.afters:
            continue
        around = [place.index for place in (node, *node.ancestors) if place.afters]
        for after in node.afters:
            seconds = _seconds(after)
            sure = (leaving[place] for place in around)
            before = (a for due, a in sure if a and seconds is not None and due < seconds)
            first = next(before, None)
            if first is not None:
                found[after] = first
    return found


def _first_to_leave(node: Node) -> tuple[float, After | None]:
    """The first timer of a state that is sure to leave it, and when it is due."""
    sure = [(_seconds(after), after) for after in node.afters if _leaves(after, node)]
    known = [(seconds, after) for seconds, after in sure if seconds is not None]
    return min(known, key=lambda each: each[0], default=(0.0, None))


def _seconds(after: After) -> float | None:
    return float(after.duration.value()) if after.duration.constant else None


def _leaves(after: After, node: Node) -> bool:
    """Whether a timer of a state is sure to leave it when it is due."""
    for edge in after.edges:
        if edge.domain is None or not edge.domain.contains(node):
            return False
        if edge.guard is None:
            return True
    return False


def repeated_conditions(graph: Graph) -> Iterator[Fault]:
    """Conditions of a state that say the same as one before them."""
    for node in graph.nodes:
        if len(node.whens) > 1:
            yield from _repeated([when.condition for when in node.whens], "condition")


def _repeated(conditions: Sequence[Compiled], what: str) -> Iterator[Fault]:
    first: dict[str, Compiled] = {}
    for condition in conditions:
        said = _FLIPPED.sub(r"(\3 <\2 \1)", condition.code)
        known = first.setdefault(said, condition) if said else condition
        if known is not condition:
            yield Fault(
                "same-condition",
                f"this {what} says the same as '{known.source}' above it ({known.where})",
                condition.where,
                "write one condition, with a list of alternatives"
                if what == "condition"
                else "this alternative is never reached: change its guard, or remove it",
                severity="warning",
            )


def reachable(graph: Graph, dead: Collection[Edge] = ()) -> set[int]:
    """The indices of the states that transitions lead to; guards are taken to pass, and ``dead``
    transitions are never taken.
    """
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
            for target in edge.targets if edge not in dead else ():
                reach((target, *(target.initial if target.type == "history" else ())))
    return reached


def unreachable(graph: Graph, reached: Collection[int]) -> Iterator[Fault]:
    """States that are not among those ``reached``."""
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
