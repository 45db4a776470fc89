"""A moment of a mission that is followed before its flight: states, values, and where it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from behaviors import UNKNOWN
from fsm.chart.entry_sets import default_entry
from fsm.chart.executable import Action, Origin
from fsm.chart.graph import Node
from fsm.values.functions import FAILURES
from runner.planned_motion import Motion, Place
from vencejo.nodes import Mapping as MapNode


@dataclass(frozen=True, slots=True)
class Way:
    """The way to a moment."""

    before: Way | None
    names: tuple[str, ...]

    def shown(self, most: int = 8) -> str:
        names: list[str] = []
        step: Way | None = self
        while step is not None and len(names) <= most:
            names[:0] = step.names
            step = step.before
        short = names[-most:]
        return " → ".join(["…", *short] if step is not None or len(names) > most else short)


@dataclass(slots=True)
class Moment:
    """A moment of the mission: active states, values, and where the vehicle is."""

    active: tuple[Node, ...]
    """In document order."""
    values: list[Any]
    place: Place
    way: Way
    charge: float = 0.0
    motion: Motion | None = None
    ended: frozenset[Node] = frozenset()
    """The states whose behaviours have ended."""
    pending: tuple[tuple[Node | None, str], ...] = ()
    """Outcomes (with their state) and raised events that are heard next."""
    memories: Mapping[Node, tuple[Node, ...]] = field(default_factory=dict)
    """What each history state remembers."""
    resumed: frozenset[Node] = frozenset()
    """The states entered by way of a history state, whose behaviours go on with what they did."""
    over: bool = False
    """Whether the mission has ended."""

    @property
    def size(self) -> int:
        """How much work it is to look at, 1 for a usual one."""
        parts = len(self.active) + len(self.pending) + len(self.memories) + len(self.values) // 10
        return 1 + parts // 20


class Actions:
    """Runs actions on the values of a moment (see :class:`fsm.chart.executable.Runtime`)."""

    def __init__(self, values: list[Any]) -> None:
        self.slots = values
        self.records: list[Any] = []
        self.host = self
        self.raised: list[tuple[Node | None, str]] = []

    def run(self, actions: Iterable[Action], node: Node) -> None:
        """Run a block of actions of a state; a variable whose value is unknown becomes so."""
        for action in actions:
            try:
                action.run(self, UNKNOWN)  # type: ignore[arg-type]
            except FAILURES:
                self._forget(action, node)
                if action.kind == "raise" and action.message:
                    self.raised.append((None, action.message.event))

    def _forget(self, action: Action, node: Node) -> None:
        if action.kind in ("set", "append") and isinstance(action.node, MapNode):
            names = {key.text for key, _ in action.node}
            for around in node.outwards():
                for data in around.data:
                    if data.name in names:
                        self.slots[data.slot] = UNKNOWN

    def record(self, what: str, **fields: Any) -> None: ...

    def raise_event(self, name: str, fields: Any, origin: Origin | None = None) -> None:
        self.raised.append((None, name))

    def send(self, *_: Any, **__: Any) -> None:
        """What is sent may arrive at any time: it is followed as an event."""

    def cancel(self, id_: str) -> None: ...

    def call(self, name: str, arguments: Any) -> None: ...


def leaves_of(moment: Moment) -> list[Node]:
    return [node for node in moment.active if not node.children]


def is_finished(region: Node, moment: Moment) -> bool:
    """Whether a final child of a region is active, or its behaviour has ended."""
    if region.type == "parallel":
        return all(is_finished(inner, moment) for inner in default_entry(region))
    if region.children and region.children[0].border:
        return is_finished(region.children[0], moment)
    if region.children:
        return any(child.type == "final" and child in moment.active for child in region.children)
    return region in moment.ended


def remembered(left: Iterable[Node], active: Sequence[Node]) -> dict[Node, tuple[Node, ...]]:
    """What the history states of states that are left remember."""
    found = {}
    for node in left:
        for history in node.children:
            if history.type == "history":
                inside = [n for n in active if node.contains(n)]
                kept = [n for n in inside if (not n.children if history.deep else n.parent is node)]
                found[history] = tuple(kept)
    return found


def restorable(history: Node) -> set[Node]:
    """The states that a history state may restore."""
    assert history.parent is not None
    pending, found = list(history.parent.children), set[Node]()
    while pending:
        node = pending.pop()
        found.add(node)
        pending.extend(node.children)
    return found
