"""What a running graph hears: events, and outcomes of its states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fsm.chart.graph import Node


@dataclass(slots=True)
class Event:
    """An event, or an outcome when it has an owner. Frozen ones take twice as long to make."""

    name: str
    fields: dict[str, Any]
    owner: Node | None = None
    entry: int = 0
    """Which entry of its owner it belongs to: it is dropped once that one was left."""


NOTHING = Event("", {})
"""What condition and timer transitions see as their event."""
