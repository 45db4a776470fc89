"""Checks of the events that actions raise, send and cancel: is anybody there to hear them?"""

from __future__ import annotations

from collections.abc import Iterator

from fsm.chart.executable import Message
from fsm.chart.graph import Graph
from fsm.values.types import Number, fits
from vencejo.errors import Fault, nearest


def unheard(graph: Graph) -> Iterator[Fault]:
    """Events that no state hears, and ids of `cancel` that no `send` has."""
    ids = [message.id_ for message in graph.messages if message.event]
    for message in graph.messages:
        if not message.event:
            if message.id_ is not None and message.id_ not in ids and None not in ids:
                yield Fault(
                    "unknown-id",
                    f"nothing is sent with the id '{message.id_}'",
                    message.where,
                    nearest(message.id_, filter(None, ids), "an event's own name is its id"),
                    "warning",
                )
        elif not message.to and not hears(graph, message.event):
            yield _unheard(graph, message, "nobody here hears")


def undelivered(graph: Graph, receiver: Graph, name: str) -> Iterator[Fault]:
    """Faults of what a mission sends to the vehicle ``name`` of its fleet, which flies
    ``receiver``: events that it does not hear, and fields that it does not know.
    """
    for message in graph.messages:
        if message.to != name:
            continue
        if not hears(receiver, message.event):
            yield _unheard(receiver, message, f"'{name}' does not hear")
            continue
        declared = receiver.events.get(message.event, {})
        for field in sorted(declared.keys() - message.fields.keys() - {"source"}):
            text = f"'{name}' needs the field '{field}' of '{message.event}' ({declared[field]})"
            yield Fault("missing-key", text, message.where, f"with: {{{field}: …}}")
        for field, value in message.fields.items() if declared else ():
            type_ = declared.get(field)
            if type_ is None:
                text = f"'{message.event}' has no field '{field}' in the mission of '{name}'"
                yield Fault("unknown-key", text, value.where, nearest(field, declared))
            elif not fits(type_, value.type):
                numbers = isinstance(type_, Number) and isinstance(value.type, Number)
                text = f"'{name}' takes {type_} as '{field}', not {value.type}"
                code = "wrong-dimension" if numbers else "wrong-type"
                yield Fault(code, text, value.where, f"its `events` say so: {message.event}")


def hears(graph: Graph, event: str) -> bool:
    """Whether a state may take an event, or the host reacts to it."""
    vocabulary = graph.vocabulary
    if vocabulary.is_urgent(event):
        return True
    return any(node.edges_for(event, vocabulary) for node in graph.nodes)


def _unheard(graph: Graph, message: Message, who: str) -> Fault:
    heard = {name for node in graph.nodes for name, _ in node.on if "." in name}
    known = heard | graph.events.keys() - {message.event}
    return Fault(
        "unheard-event",
        f"{who} '{message.event}'",
        message.where,
        nearest(message.event, known, f"on: {{{message.event}: …}}"),
        "warning",
    )
