"""History: active states that are remembered with their data and their behaviours' progress."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fsm.chart.graph import Node

Progress = Mapping[str, Any]
"""The progress of a behaviour, as values that JSON can hold."""


@dataclass(slots=True)
class Memory:
    """The content of one history state, from the last time its parent was left."""

    states: tuple[Node, ...]
    """The states it stands for as a target."""
    kept: tuple[Node, ...]
    """The states whose data and progress it gives back: its parent, and those it restores."""
    progress: dict[int, Progress] = field(default_factory=dict)
    """State index → progress of its behaviour."""
    data: dict[int, Any] = field(default_factory=dict)
    """Slot → value."""

    def keep_data(self, values: Sequence[Any]) -> None:
        """Remember the data of the kept states; ``values`` are those of all slots."""
        self.data = {data.slot: values[data.slot] for node in self.kept for data in node.data}


def remember(
    leaving: Iterable[Node], active: Sequence[Node], progress: Callable[[Node], Progress | None]
) -> dict[int, Memory]:
    """New memories, by the index of their history state, of the states that are being left.

    ``progress`` gives that of a state's behaviour. Data are kept later: see Memory.keep_data.
    """
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
