"""Events that come from outside of a mission, given as texts."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from fsm.chart.graph import Graph
from fsm.checks.messages import hears
from fsm.compiler.parameters import constant_value
from fsm.expressions.literals import Context
from fsm.expressions.scope import Scope
from fsm.values.types import MapOf
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import YamlNode, read_text

_EVENT = re.compile(r"\s*([^\s{]+)\s*(\{.*\})?\s*", re.DOTALL)


def parse_event(
    graph: Graph,
    text: str,
    place: Where,
    warnings: list[Fault] | None = None,
    optional: frozenset[str] = frozenset(),
) -> tuple[str, dict[str, Any]]:
    """An event for a graph from a text, ``tag.seen{id: 3}``: its name and the values of its fields.

    All fields that are declared for it are required, but for ``optional`` ones. That nobody hears
    it, and what is doubtful in its fields, is added to ``warnings``. Raises UserError
    (``bad-event``, ``unknown-event``, and what wrong fields are).
    """
    match = _EVENT.fullmatch(text)
    if match is None:
        hint = "an event, and its fields if it has any: 'tag.seen{id: 3}'"
        raise UserError("bad-event", f"'{text}' is no event", place, hint)
    name, body = match.groups()
    # A foreign SCXML document declares no events.
    if name not in graph.events and not graph.scxml:
        known = [event for event in graph.events if not event.startswith("error.")]
        message = f"{graph.name} knows no event '{name}'"
        raise UserError("unknown-event", message, place, nearest(name, known))
    if name.startswith("error."):
        raise UserError("bad-event", f"'{name}' is the engine's own", place)
    found: list[Fault] = [] if warnings is None else warnings
    declared = graph.events.get(name, {})
    node: YamlNode = MapNode([], place)
    if body is not None:
        node = read_text(f"fields: {body}", str(place)).entries[0][1]
    context = Context(Scope(warnings=found), graph.places, graph.vocabulary.places)
    # An event declared without fields may have any, as where it is sent.
    fields = MapOf(declared, frozenset(declared) - optional) if declared else MapOf()
    try:
        values: Mapping[str, Any] = constant_value(node, fields, context).value()
    except UserError as error:
        raise UserError.of(
            Fault(f.code, f"{name}: {f.message}", place, f.hint) for f in error.faults
        ) from None
    if not hears(graph, name):
        found.append(
            Fault("unheard-event", f"nobody here hears '{name}'", place, severity="warning")
        )
    return name, dict(values)
