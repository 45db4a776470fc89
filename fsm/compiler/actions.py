"""Compiles actions: set, append, raise, send, cancel, log, and call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NoReturn

from fsm.chart.executable import Action, ActionFunction, EventFields, Message, Runtime
from fsm.expressions.compiled import Compiled
from fsm.expressions.literals import Context, collecting, read_value
from fsm.expressions.scope import Binding
from fsm.host import Function
from fsm.language.keys import AT, EVENT_NAME, SMALL_NAME
from fsm.language.spec import ActionKind, ActionSpec
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


@dataclass(frozen=True, slots=True, eq=False)
class Environment:
    """The names that the actions of a state can use."""

    context: Context
    """Variables and places, for reading values."""
    events: Events
    """Declared events with their fields."""
    functions: Mapping[str, Function]
    """Registered functions, for `call`."""


def compile_action(spec: ActionSpec, environment: Environment) -> Action:
    """Compile an action. Raises UserError."""
    if spec.kind in _SPEAKERS:
        run, message = _SPEAKERS[spec.kind](spec, environment)
        return Action(spec.kind, spec.where, run, spec.node, message)
    return Action(spec.kind, spec.where, _COMPILERS[spec.kind](spec, environment), spec.node)


def _log(spec: ActionSpec, environment: Environment) -> ActionFunction:
    node = spec.node
    # A value by itself is shown as it would be inside a text.
    alone = isinstance(node, Scalar) and "$" in node.text
    text = read_value(node, ANY if alone else TEXT, environment.context)
    return lambda i, e: i.record("log", text=as_text(text(i.slots, e)))


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
        place = place.item if isinstance(place, ListOf) else ANY
    value = read_value(node, place, context)
    if not fits(place, value.type):
        _mistyped(name, f"'{name.text}' is {place}, not {value.type}")
    return variable, value


def _mistyped(name: Scalar, message: str) -> NoReturn:
    raise UserError("wrong-type", message, name.where)


def _set(spec: ActionSpec, environment: Environment) -> ActionFunction:
    assignments = _assignments(spec, environment.context)
    if len(assignments) == 1:
        return _set_one(*assignments[0])

    def run(instance: Runtime, event: EventFields) -> None:
        slots = instance.slots
        # All right sides first, so that {a: $b, b: $a} swaps.
        values = [bounded(value.function(slots, event)) for _, value in assignments]
        for (variable, _), value in zip(assignments, values, strict=True):
            slots[variable.slot] = value
            instance.records.append(("set", {"name": variable.name, "value": value}))

    return run


def _set_one(variable: Binding, value: Compiled) -> ActionFunction:
    """Assign one variable, as nearly every `set` does: half the time of the general case."""
    name, slot, function = variable.name, variable.slot, value.function

    def run(instance: Runtime, event: EventFields) -> None:
        slots = instance.slots
        new = slots[slot] = bounded(function(slots, event))
        instance.records.append(("set", {"name": name, "value": new}))

    return run


def _append(spec: ActionSpec, environment: Environment) -> ActionFunction:
    assignments = _assignments(spec, environment.context)

    def run(instance: Runtime, event: EventFields) -> None:
        slots = instance.slots
        values = [value(slots, event) for _, value in assignments]
        for (variable, _), value in zip(assignments, values, strict=True):
            # A new list: whoever read the old one keeps what was read.
            slots[variable.slot] = bounded([*(slots[variable.slot] or ()), value])
            instance.record("append", name=variable.name, value=value)

    return run


def _fields(
    node: YamlNode | None, shape: Mapping[str, Type], context: Context, where: Where
) -> Compiled:
    """Compile the fields of an event; all that are declared for it are required."""
    fields = MapOf(shape, frozenset(shape)) if shape else MapOf()
    return read_value(node if node is not None else MapNode([], where), fields, context)


def _event_name(node: YamlNode | None, where: Where) -> str:
    name = node.text if isinstance(node, Scalar) else ""
    if not EVENT_NAME.fullmatch(name):
        raise UserError("bad-event", "the name of an event with a dot is missing here", where)
    if name.startswith("error."):
        raise UserError("bad-event", f"'{name}' is not yours to raise", where)
    return name


def _raise(spec: ActionSpec, environment: Environment) -> tuple[ActionFunction, Message]:
    node, place = spec.node, spec.node.where
    body: YamlNode | None = None
    if isinstance(node, MapNode):
        if len(node.entries) != 1:
            raise UserError("wrong-type", "`raise` names one event", node.where)
        key, body = node.entries[0]
        name, place = _event_name(key, key.where), key.where
    else:
        name = _event_name(node, node.where)
    fields = _fields(body, environment.events.get(name, {}), environment.context, node.where)
    return lambda i, e: i.raise_event(name, fields(i.slots, e)), Message(name, place)


def _send(spec: ActionSpec, environment: Environment) -> tuple[ActionFunction, Message]:
    context = environment.context
    node = _map(spec.node, "send")
    for key, _ in node:
        if key.text not in AT["send"]:
            hint = nearest(key.text, AT["send"])
            raise UserError("unknown-key", f"`send` has no '{key.text}'", key.where, hint)
    name = _event_name(node.get("event"), node.where)
    to = _receiver(node.get("to"), context)
    # Which fields an event has is the receiver's to say.
    shape = {} if to else environment.events.get(name, {})
    fields = _fields(node.get("with"), shape, context, node.where)
    delay_node, id_node = node.get("delay"), node.get("id")
    delay = read_value(delay_node, Number(TIME, 0.0), context) if delay_node else None
    id_ = read_value(id_node, TEXT, context) if id_node else None
    named = node.get("event")
    message = Message(
        name,
        named.where if named else node.where,
        to,
        _constant_text(id_) if id_ else name,
        _untyped(node.get("with"), context) if to else {},
    )

    def run(instance: Runtime, event: EventFields) -> None:
        slots = instance.slots
        instance.send(
            name,
            fields(slots, event),
            delay(slots, event) if delay else 0.0,
            id_(slots, event) if id_ else name,
            to,
        )

    return run, message


def _constant_text(text: Compiled) -> str | None:
    return text.value() if text.constant else None


def _untyped(node: YamlNode | None, context: Context) -> dict[str, Compiled]:
    """The fields of an event whose types another mission says."""
    entries = node.entries if isinstance(node, MapNode) else []
    return {key.text: read_value(value, ANY, context) for key, value in entries}


def _receiver(node: YamlNode | None, context: Context) -> str:
    """The name of the vehicle that an event is sent to; empty for its own. Raises UserError."""
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


def _call(spec: ActionSpec, environment: Environment) -> ActionFunction:
    name, body = spec.node, None
    if isinstance(name, MapNode):
        if len(name.entries) != 1:
            raise UserError("wrong-type", "`call` names one function", name.where)
        name, body = name.entries[0]
    if not isinstance(name, Scalar):
        raise UserError("wrong-type", f"`call` names a function, not {kind(name)}", name.where)
    function = environment.functions.get(name.text)
    if function is None:
        hint = nearest(name.text, environment.functions) or _NO_FUNCTIONS
        message = f"there is no function '{name.text}' to call"
        raise UserError("unknown-function", message, name.where, hint)
    parameters = function.parameters
    required = frozenset(p.name for p in parameters.values() if p.required)
    shape = MapOf({p.name: p.type for p in parameters.values()}, required)
    if function.on_trust:
        shape = MapOf()
    given = MapNode([], name.where) if body is None else _given(body, function)
    arguments = read_value(given, shape, environment.context)

    def run(instance: Runtime, event: EventFields) -> None:
        values = arguments(instance.slots, event)
        instance.record("call", name=function.name, **{"with": values})
        instance.host.call(function.name, values)

    return run


def _given(body: YamlNode, function: Function) -> MapNode:
    """The arguments of a call; that of a function with one parameter may stand without its name."""
    is_value = not isinstance(body, MapNode) and not (isinstance(body, Scalar) and body.null)
    if not is_value or len(function.parameters) != 1:
        return _map(body, function.name)
    (name,) = function.parameters
    return MapNode([(Scalar(name, body.where), body)], body.where)


def _cancel(spec: ActionSpec, environment: Environment) -> tuple[ActionFunction, Message]:
    id_ = read_value(spec.node, TEXT, environment.context)
    message = Message("", spec.node.where, id_=_constant_text(id_))
    return lambda i, e: i.cancel(id_(i.slots, e)), message


_COMPILERS: Mapping[ActionKind, Callable[[ActionSpec, Environment], ActionFunction]] = {
    "set": _set,
    "append": _append,
    "log": _log,
    "call": _call,
}
_SPEAKERS: Mapping[
    ActionKind, Callable[[ActionSpec, Environment], tuple[ActionFunction, Message]]
] = {"raise": _raise, "send": _send, "cancel": _cancel}
"""The actions whose messages the checks look at."""
