"""What a state graph can do: assign, append, raise, send, cancel, log, and call functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NoReturn

from fsm.chart.graph import Action
from fsm.expressions.compiled import Compiled
from fsm.expressions.literals import Context, collecting, read_value
from fsm.expressions.scope import Binding
from fsm.host import Vocabulary
from fsm.language.keys import AT, EVENT_NAME, SMALL_NAME
from fsm.language.spec import ActionSpec
from fsm.values.functions import as_text, bounded
from fsm.values.types import ANY, TEXT, ListOf, MapOf, Number, Type, fits
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Scalar, YamlNode, kind
from vencejo.units import TIME

_NO_FUNCTIONS = "functions to call stand, marked with @action, in a Python file under `uses`"

Events = Mapping[str, Mapping[str, Type]]


def raised(spec: ActionSpec) -> tuple[str, tuple[str, ...]] | None:
    """The event that an action raises or sends, with the names of its fields."""
    node, body = spec.node, None
    name: YamlNode | None = node if spec.kind == "raise" else None
    if spec.kind == "raise" and isinstance(node, MapNode) and len(node.entries) == 1:
        name, body = node.entries[0]
    elif spec.kind == "send" and isinstance(node, MapNode) and not node.get("to"):
        name, body = node.get("event"), node.get("with")
    if not isinstance(name, Scalar):
        return None
    return name.text, tuple(key.text for key, _ in body) if isinstance(body, MapNode) else ()


def compile_action(
    spec: ActionSpec, context: Context, events: Events, vocabulary: Vocabulary
) -> Action:
    """An action ready to run. Raises UserError."""
    match spec.kind:
        case "set":
            return _set(spec, context)
        case "append":
            return _append(spec, context)
        case "log":
            return _log(spec, context)
        case "raise":
            return _raise(spec, context, events)
        case "send":
            return _send(spec, context, events)
        case "cancel":
            return _cancel(spec, context)
        case "call":
            return _call(spec, context, vocabulary)


def _log(spec: ActionSpec, context: Context) -> Action:
    node = spec.node
    # A value by itself is shown as it would be inside a text.
    alone = isinstance(node, Scalar) and "$" in node.text
    text = read_value(node, ANY if alone else TEXT, context)
    return Action("log", spec.where, lambda i, e: i.record("log", text=as_text(text(i.slots, e))))


def _map(node: YamlNode, what: str) -> MapNode:
    if isinstance(node, MapNode):
        return node
    raise UserError("wrong-type", f"`{what}` is a map, not {kind(node)}", node.where)


def _variable(name: Scalar, context: Context) -> Binding:
    found = context.scope.find(name.text)
    if isinstance(found, Binding) and found.kind == "data":
        return found
    known = [
        known
        for known in context.scope.visible()
        if isinstance(binding := context.scope.find(known), Binding) and binding.kind == "data"
    ]
    if found is None:
        message, hint = f"there is no variable '{name.text}'", nearest(name.text, known)
    else:
        message, hint = f"'{name.text}' is no variable", "only what stands under `data` can be set"
    raise UserError("unknown-variable", message, name.where, hint or "declare it under `data`")


def _assignments(spec: ActionSpec, context: Context) -> list[tuple[Binding, Compiled]]:
    found: list[tuple[Binding, Compiled]] = []
    faults: list[Fault] = []
    for name, node in _map(spec.node, spec.kind):
        with collecting(faults):
            found.append(_assignment(spec, name, node, context))
    if faults:
        raise UserError.of(faults)
    return found


def _assignment(
    spec: ActionSpec, name: Scalar, node: YamlNode, context: Context
) -> tuple[Binding, Compiled]:
    variable = _variable(name, context)
    place = variable.type
    if spec.kind == "append":
        if not fits(ListOf(), place):
            _mistyped(name, f"'{name.text}' is {place}, and only a list can be appended to")
        place = ANY
    value = read_value(node, place, context)
    if not fits(place, value.type):
        _mistyped(name, f"'{name.text}' is {place}, not {value.type}")
    return variable, value


def _mistyped(name: Scalar, message: str) -> NoReturn:
    raise UserError("wrong-type", message, name.where)


def _set(spec: ActionSpec, context: Context) -> Action:
    assignments = _assignments(spec, context)
    if len(assignments) == 1:
        return Action("set", spec.where, _set_one(*assignments[0]))

    def run(instance: Any, event: dict[str, Any]) -> None:
        slots = instance.slots
        # All right sides first, so that {a: $b, b: $a} swaps.
        values = [bounded(value.function(slots, event)) for _, value in assignments]
        for (variable, _), value in zip(assignments, values, strict=True):
            slots[variable.slot] = value
            instance.records.append(("set", {"name": variable.name, "value": value}))

    return Action("set", spec.where, run)


def _set_one(variable: Binding, value: Compiled) -> Callable[[Any, dict[str, Any]], None]:
    """What nearly every `set` does, in half the time."""
    name, slot, function = variable.name, variable.slot, value.function

    def run(instance: Any, event: dict[str, Any]) -> None:
        slots = instance.slots
        new = slots[slot] = bounded(function(slots, event))
        instance.records.append(("set", {"name": name, "value": new}))

    return run


def _append(spec: ActionSpec, context: Context) -> Action:
    assignments = _assignments(spec, context)

    def run(instance: Any, event: dict[str, Any]) -> None:
        slots = instance.slots
        values = [value(slots, event) for _, value in assignments]
        for (variable, _), value in zip(assignments, values, strict=True):
            # A new list: whoever read the old one keeps what was read.
            slots[variable.slot] = bounded([*(slots[variable.slot] or ()), value])
            instance.record("append", name=variable.name, value=value)

    return Action("append", spec.where, run)


def _fields(
    node: YamlNode | None, shape: Mapping[str, Type], context: Context, where: Where
) -> Compiled:
    """The fields of an event; those declared for it must be there."""
    fields = MapOf(shape, frozenset(shape)) if shape else MapOf()
    return read_value(node if node is not None else MapNode([], where), fields, context)


def _event_name(node: YamlNode | None, where: Where) -> str:
    name = node.text if isinstance(node, Scalar) else ""
    if not EVENT_NAME.fullmatch(name):
        raise UserError("bad-event", "the name of an event with a dot is missing here", where)
    if name.startswith("error."):
        raise UserError("bad-event", f"'{name}' is not yours to raise", where)
    return name


def _raise(spec: ActionSpec, context: Context, events: Events) -> Action:
    node = spec.node
    body: YamlNode | None = None
    if isinstance(node, MapNode):
        if len(node.entries) != 1:
            raise UserError("wrong-type", "`raise` names one event", node.where)
        key, body = node.entries[0]
        name = _event_name(key, key.where)
    else:
        name = _event_name(node, node.where)
    fields = _fields(body, events.get(name, {}), context, node.where)
    return Action("raise", spec.where, lambda i, e: i.raise_event(name, fields(i.slots, e)))


def _send(spec: ActionSpec, context: Context, events: Events) -> Action:
    node = _map(spec.node, "send")
    for key, _ in node:
        if key.text not in AT["send"]:
            hint = nearest(key.text, AT["send"])
            raise UserError("unknown-key", f"`send` has no '{key.text}'", key.where, hint)
    name = _event_name(node.get("event"), node.where)
    to = _receiver(node.get("to"), context)
    # Which fields an event has is the receiver's to say.
    fields = _fields(node.get("with"), {} if to else events.get(name, {}), context, node.where)
    delay_node, id_node = node.get("delay"), node.get("id")
    delay = read_value(delay_node, Number(TIME, 0.0), context) if delay_node else None
    id_ = read_value(id_node, TEXT, context) if id_node else None

    def run(instance: Any, event: dict[str, Any]) -> None:
        slots = instance.slots
        instance.send(
            name,
            fields(slots, event),
            delay(slots, event) if delay else 0.0,
            id_(slots, event) if id_ else name,
            to,
        )

    return Action("send", spec.where, run)


def _receiver(node: YamlNode | None, context: Context) -> str:
    """The vehicle an event is sent to; empty for one's own."""
    if node is None:
        return ""
    if not isinstance(node, Scalar) or not SMALL_NAME.fullmatch(node.text):
        raise UserError("bad-name", "`to` is the name of a vehicle of the fleet", node.where)
    if context.peers is not None and node.text not in context.peers:
        raise UserError(
            "unknown-vehicle",
            f"the fleet has no vehicle '{node.text}'",
            node.where,
            nearest(node.text, context.peers),
        )
    return node.text


def _call(spec: ActionSpec, context: Context, vocabulary: Vocabulary) -> Action:
    name, body = spec.node, None
    if isinstance(name, MapNode):
        if len(name.entries) != 1:
            raise UserError("wrong-type", "`call` names one function", name.where)
        name, body = name.entries[0]
    if not isinstance(name, Scalar):
        raise UserError("wrong-type", f"`call` names a function, not {kind(name)}", name.where)
    function = vocabulary.functions.get(name.text)
    if function is None:
        hint = nearest(name.text, vocabulary.functions) or _NO_FUNCTIONS
        message = f"there is no function '{name.text}' to call"
        raise UserError("unknown-function", message, name.where, hint)
    parameters = function.parameters
    required = frozenset(p.name for p in parameters.values() if p.required)
    shape = MapOf({p.name: p.type for p in parameters.values()}, required)
    if function.on_trust:
        shape = MapOf()
    given = MapNode([], name.where) if body is None else _map(body, name.text)
    arguments = read_value(given, shape, context)

    def run(instance: Any, event: dict[str, Any]) -> None:
        values = arguments(instance.slots, event)
        instance.record("call", name=function.name, **{"with": values})
        instance.host.call(function.name, values)

    return Action("call", spec.where, run)


def _cancel(spec: ActionSpec, context: Context) -> Action:
    id_ = read_value(spec.node, TEXT, context)
    return Action("cancel", spec.where, lambda i, e: i.cancel(id_(i.slots, e)))
