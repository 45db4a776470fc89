"""Which states and transitions of missions were visited: noted by `transitions` callbacks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from fsm.chart.graph import Edge, Graph, Node


@dataclass
class Visits:
    """One mission: what there is, each with its place, and which of it was visited."""

    title: str
    states: list[str] = field(default_factory=list)
    transitions: list[str] = field(default_factory=list)
    visited: set[str] = field(default_factory=set)

    def lines(self) -> Iterator[str]:
        """How much was covered, and each thing that was not, with its place."""
        counts = [
            f"{sum(thing in self.visited for thing in things)} of {len(things)} {word}"
            for word, things in (("states", self.states), ("transitions", self.transitions))
        ]
        yield f"{self.title}: {', '.join(counts)}"
        for thing in (*self.states, *self.transitions):
            if thing not in self.visited:
                yield f"  {thing}"


class Coverage:
    """Collects visits over many runs; graphs of the same text count as one mission."""

    def __init__(self) -> None:
        self.missions: dict[str, Visits] = {}

    def watch(self, graph: Graph) -> None:
        """Note from now on what the instances of this graph visit."""
        states = [n for n in graph.nodes if n.parent is not None and n.type != "history"]
        edges = [edge for node in graph.nodes for edge in node.edges()]
        title = f"{graph.root.where.file} ({graph.name})"
        visits = self.missions.setdefault(
            graph.digest, Visits(title, [*map(_state, states)], [*map(_transition, edges)])
        )
        for node in states:
            node.on_enter.append(partial(_note, visits.visited, _state(node)))
        for edge in edges:
            edge.before.append(partial(_note, visits.visited, _transition(edge)))

    def lines(self) -> Iterator[str]:
        for visits in sorted(self.missions.values(), key=lambda visits: visits.title):
            yield from visits.lines()

    def to_json(self) -> dict[str, Any]:
        return {
            digest: [v.title, v.states, v.transitions, sorted(v.visited)]
            for digest, v in self.missions.items()
        }

    def add(self, other: Mapping[str, Any]) -> None:
        """Add what another process has collected, as :meth:`to_json` gives it."""
        for digest, (title, states, transitions, visited) in other.items():
            visits = self.missions.setdefault(digest, Visits(title, states, transitions))
            visits.visited.update(visited)


def _note(visited: set[str], thing: str, event_data: Any) -> None:
    visited.add(thing)


def _state(node: Node) -> str:
    return f"{node.where}: state {node.path}"


def _transition(edge: Edge) -> str:
    to = ", ".join(target.path for target in edge.targets) or "(nowhere)"
    by = edge.kind if edge.kind == "always" else f"{edge.kind} {edge.trigger}"
    return f"{edge.where}: {edge.node.path or '(mission)'} → {to} by {by}"
