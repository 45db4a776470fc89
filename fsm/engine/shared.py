"""What all instances of one graph share: worked out once, kept as long as one of them lives.

A compiled graph stays as it is. What instances work out of it is kept here, beside it, so that a
second instance, or a second visit, finds it ready.
"""

from __future__ import annotations

from typing import Any
from weakref import WeakValueDictionary

from fsm.chart.configuration import Configurations
from fsm.chart.graph import Graph
from fsm.chart.model import model_class

MAX_MODELS = 20
"""Classes of instances that are kept for a graph; a program has one, or one for each subclass."""


class Shared:
    """Everything that is worked out of one graph."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.configurations = Configurations(graph)
        self.has_history = any(node.type == "history" for node in graph.nodes)
        self._models: dict[type, type] = {}
        self._digest: str | None = None

    @property
    def digest(self) -> str:
        """The graph's digest."""
        if self._digest is None:
            self._digest = self.graph.digest
        return self._digest

    def model_of(self, base: type) -> Any:
        """The class of this graph's instances that ``base`` is the class of."""
        found = self._models.get(base)
        if found is None:
            if len(self._models) >= MAX_MODELS:
                self._models.clear()
            found = self._models[base] = model_class(base, self.graph.nodes)
        return found


_shared: WeakValueDictionary[int, Shared] = WeakValueDictionary()
"""By the identity of the graph, which lives as long as this: a graph as key would live for ever."""


def shared_by(graph: Graph) -> Shared:
    """What the instances of this graph share. It is gone when the last one that holds it is."""
    found = _shared.get(id(graph))
    if found is None:
        found = _shared[id(graph)] = Shared(graph)
    return found
