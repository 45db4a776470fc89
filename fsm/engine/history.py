"""What a history state gives back: which states were active, their data and their progress."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fsm.chart.graph import Node

Progress = Mapping[str, Any]


@dataclass(slots=True)
class Memory:
    """What one history state remembers of the last time its state was left."""

    states: tuple[Node, ...]
    """What it stands for as a target."""
    kept: tuple[Node, ...]
    """Whose data and progress come back: the state it stands in, and those it restores."""
    progress: dict[int, Progress] = field(default_factory=dict)
    """By state."""
    data: dict[int, Any] = field(default_factory=dict)
    """By slot."""

    def keep_data(self, slots: Sequence[Any]) -> None:
        self.data = {data.slot: slots[data.slot] for node in self.kept for data in node.data}


def remember(
    leaving: Iterable[Node], active: Sequence[Node], progress: Callable[[Node], Progress | None]
) -> dict[int, Memory]:
    """The memories, by history state, that leaving these states makes."""
    memories = {}
    for node in leaving:
        for history in node.children:
            if history.type != "history":
                continue
            inside = [other for other in active if node.contains(other)]
            restored = inside if history.deep else [o for o in inside if o.parent is node]
            states = [other for other in restored if not history.deep or not other.children]
            memory = Memory(tuple(states), (node, *restored))
            for kept in memory.kept:
                done = progress(kept)
                if done is not None:
                    memory.progress[kept.index] = done
            memories[history.index] = memory
    return memories
