"""Coverage: the states and transitions of missions that runs visit, by `transitions` callbacks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from fsm.chart.graph import Edge, Graph, Node


@dataclass
class Visits:
    """The states and transitions of one mission, each with its place, and those visited."""

    title: str
    states: list[str] = field(default_factory=list)
    transitions: list[str] = field(default_factory=list)
    visited: set[str] = field(default_factory=set)

    def lines(self) -> Iterator[str]:
        """A line of counts, then a line for each state and transition that was not visited."""
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
        """Record from now on the visits of all instances of this graph."""
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
        """The lines of all missions, sorted by their titles."""
        for visits in sorted(self.missions.values(), key=lambda visits: visits.title):
            yield from visits.lines()

    def to_json(self) -> dict[str, Any]:
        """All visits by the digest of their mission, for :meth:`add` in another process."""
        return {
            digest: [v.title, v.states, v.transitions, sorted(v.visited)]
            for digest, v in self.missions.items()
        }

    def add(self, other: Mapping[str, Any]) -> None:
        """Add the visits that another process collected, as :meth:`to_json` gives them."""
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
