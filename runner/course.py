"""The course of a mission: the states that it entered, and why; the things that it ran into."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from fsm.engine.instance import Instance, Record
from hal.vehicle import Observation

WORDS = ("reason", "message", "thing")
"""Fields of an event that say in words how it came about; the first that has a text is shown."""


class Entered(NamedTuple):
    """A state that a mission entered and stayed in: an active leaf, or the final state."""

    time: float
    """Seconds of the vehicle's clock."""
    state: str
    """Its path."""
    why: str
    """The cause of the transition: ``blocked: came no nearer for 15 s``, ``battery.low``,
    ``after 5 s``; empty for the initial states."""


def entered(instance: Instance, records: Iterable[Record]) -> list[Entered]:
    """The states of ``records``, those of the period that ``instance`` has just done, in order.

    A state that was left in the same period is passed over: what led to it is the cause of the
    next one, unless something else is.
    """
    found = list(_causes(records))
    if not found:
        return []
    stays = set(instance.paths())
    by_path, root = instance.graph.by_path, instance.graph.root
    return [
        Entered(instance.now, state, why)
        for state, why in found
        if state in stays or (by_path[state].final and by_path[state].parent is root)
    ]


def _causes(records: Iterable[Record]) -> Iterator[tuple[str, str]]:
    """The path of every state entered, with the cause.

    The transitions of a microstep stand between the states left and those entered, and before them
    the event that took them.
    """
    event: Mapping[str, Any] = {}
    last = ""
    step: list[tuple[Sequence[str], str]] = []
    """The transitions of a microstep: targets and cause."""
    for kind, fields in records:
        if kind == "event" and fields["taken"]:
            event = fields
        elif kind == "exit":
            step = []
        elif kind == "transition":
            last = _cause(fields, event, last)
            step.append((fields["to"], last))
        elif kind == "enter":
            state = fields["state"]
            yield (
                state,
                max(step, key=lambda taken: _nearness(taken[0], state), default=((), ""))[1],
            )


def _cause(transition: Mapping[str, Any], event: Mapping[str, Any], before: str) -> str:
    """The cause of a transition; an ``always`` one is due to what led to its state."""
    by: str = transition["by"]
    if by == "always":
        return before or by
    if not by.startswith("on "):
        return by
    owner = event.get("state", transition["from"])
    name = event["name"] if owner == transition["from"] else f"{owner} {event['name']}"
    words = in_words(event.get("fields", {}))
    return f"{name}: {words}" if words else name


def in_words(fields: Mapping[str, Any]) -> str:
    """What an event's fields say about how it came about, in one line; empty for nothing."""
    texts = (fields.get(name) for name in WORDS)
    return one_line(next((text for text in texts if text and isinstance(text, str)), ""))


def one_line(text: str) -> str:
    """A text without line breaks and control characters."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _nearness(targets: Sequence[str], state: str) -> int:
    """The number of names that the path of a state begins with in common with a target."""
    names = state.split(".")
    return max((_common(target.split("."), names) for target in targets), default=0)


def _common(a: Sequence[str], b: Sequence[str]) -> int:
    for count, (one, other) in enumerate(zip(a, b, strict=False)):
        if one != other:
            return count
    return min(len(a), len(b))


def collisions(seen: Observation) -> list[str]:
    """The names of the things that a vehicle began to touch in this period."""
    return [event.fields["thing"] for event in seen.events if event.name == "vehicle.collision"]
