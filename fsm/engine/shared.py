"""Results that all instances of one graph share: derived once, kept as long as one of them lives.

A compiled graph never changes, so nothing is cached on it. The tables here stand beside it: its
configurations, the classes of its instances, and its digest.
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
    """The tables of one graph."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.configurations = Configurations(graph)
        self.has_history = any(node.type == "history" for node in graph.nodes)
        self.narrows = any(edge.by_history for node in graph.nodes for edge in node.edges())
        """Whether history may narrow the domain of some transition."""
        self._models: dict[type, type] = {}
        self._digest: str | None = None

    @property
    def digest(self) -> str:
        """The graph's digest, computed at the first call."""
        if self._digest is None:
            self._digest = self.graph.digest
        return self._digest

    def model_of(self, base: type) -> Any:
        """The subclass of ``base`` for instances of this graph (see :mod:`fsm.chart.model`)."""
        found = self._models.get(base)
        if found is None:
            if len(self._models) >= MAX_MODELS:
                self._models.clear()
            found = self._models[base] = model_class(base, self.graph.nodes)
        return found


_shared: WeakValueDictionary[int, Shared] = WeakValueDictionary()
"""``id`` of a graph → what its instances share. The graph as a key would never be freed."""


def shared_by(graph: Graph) -> Shared:
    """The tables of a graph. They are dropped with the last instance that holds them."""
    found = _shared.get(id(graph))
    if found is None:
        found = _shared[id(graph)] = Shared(graph)
    return found
