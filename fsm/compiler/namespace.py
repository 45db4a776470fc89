"""The namespace of a graph: the places, parameters and events that all its states see.

A mission has one namespace, and one more for each graph it includes, each time it does: an included
graph sees its own names and the host's, nothing of what is around it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from fsm.expressions.literals import Context
from fsm.expressions.scope import Scope
from fsm.host import Parameter, Vocabulary
from fsm.values.types import TEXT, Type

Fields = Mapping[str, Type]
FAILED_FIELDS: Fields = MappingProxyType({"reason": TEXT})
ERROR_FIELDS: Fields = MappingProxyType({"message": TEXT, "where": TEXT})
OWN_EVENTS: Mapping[str, Fields] = MappingProxyType(
    {"error.execution": ERROR_FIELDS, "error.livelock": ERROR_FIELDS}
)


@dataclass(eq=False)
class Namespace:
    """The names that a graph declares for all its states."""

    vocabulary: Vocabulary
    places: dict[str, Any] = field(default_factory=dict)
    parameters: dict[str, Parameter] = field(default_factory=dict)
    parameter_slots: dict[str, int] = field(default_factory=dict)
    events: dict[str, Fields] = field(default_factory=dict)
    """Declared events with their fields."""
    raised: dict[str, Fields] = field(default_factory=dict)
    """Events that the graph only raises, with the fields it gives them."""

    @property
    def known_events(self) -> Mapping[str, Fields]:
        """All events of the graph with their fields, declared or raised."""
        return {**self.raised, **self.events}

    def context(self, scope: Scope) -> Context:
        """The context in which values in a scope of this graph are read."""
        return Context(scope, self.places, self.vocabulary.places, self.vocabulary.peers)

    def climb_to(self, outer: Namespace) -> None:
        """Make the events of this included graph known to the graph around it, which hears them."""
        for name, fields in self.events.items():
            outer.events.setdefault(name, fields)
        for name, fields in self.raised.items():
            outer.raised.setdefault(name, fields)
