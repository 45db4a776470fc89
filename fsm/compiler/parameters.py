"""The parameters of a mission: declared in its file, given from outside."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

from fsm.chart.graph import Graph
from fsm.expressions.compiled import Compiled
from fsm.expressions.literals import Context, read_value
from fsm.expressions.scope import Scope
from fsm.faults import Faults
from fsm.host import Parameter
from fsm.language.keys import AT
from fsm.language.spec import Named
from fsm.values.types import ANY, NAMED, TEXT, ListOf, Mixed, NoneType, Number, Text, Type
from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Scalar, Sequence, YamlNode, read_text


def parse_parameters(
    graph: Graph, given: Mapping[str, str], warnings: list[Fault] | None = None
) -> dict[str, Any]:
    """Values for a graph's parameters from texts (``-p cruise=6m``), with the defaults of others.

    What is doubtful in them is added to ``warnings``.
    Raises UserError for unknown names, values that do not fit, and required ones not given.
    """
    faults = Faults()
    values: dict[str, Any] = {}
    with faults.collecting():
        values = parse_given(graph, given, warnings)
    for name, parameter in graph.parameters.items():
        if parameter.required and name not in given:
            message = f"the parameter '{name}' has no default and must be given"
            faults.fail("missing-parameter", message, None, f"-p {name}=…")
        values.setdefault(name, parameter.default)
    faults.raise_any()
    return values


def parse_given(
    graph: Graph,
    given: Mapping[str, str],
    warnings: list[Fault] | None = None,
    *,
    vehicle: str = "",
) -> dict[str, Any]:
    """Values for those of a graph's parameters that are given as texts.

    ``vehicle`` is the one of a fleet that flies it, which the option names too (``-p cat.speed``).
    What is doubtful is added to ``warnings``. Raises UserError for unknown names, and values that
    do not fit.
    """
    faults: list[Fault] = []
    values: dict[str, Any] = {}
    scope = Scope(warnings=[] if warnings is None else warnings)
    context = Context(scope, graph.places, graph.vocabulary.places)
    for name, text in given.items():
        place = Where(f"-p {vehicle}.{name}" if vehicle else f"-p {name}")
        parameter = graph.parameters.get(name)
        if parameter is None:
            hint = nearest(name, graph.parameters, None if graph.parameters else "it has none")
            faults.append(
                Fault("unknown-parameter", f"{graph.name} has no parameter '{name}'", place, hint)
            )
            continue
        try:
            values[name] = _given(text, parameter.type, place, context)
        except UserError as error:
            faults.extend(
                Fault(f.code, f"{name}={text}: {f.message}", place, f.hint) for f in error.faults
            )
    if faults:
        raise UserError.of(faults)
    return values


def _given(text: str, type_: Type, place: Where, context: Context) -> Any:
    """The value of a text from the command line."""
    if isinstance(type_, Text):
        # A text needs no quotes there, whatever it holds.
        node: YamlNode = Scalar(text.replace("$", "$$"), place, plain=False)
    else:
        node = read_text(f"value: {text}", str(place)).entries[0][1]
    return constant_value(node, type_, context).value()


def read_parameter(named: Named, context: Context, faults: Faults) -> Parameter:
    """Read a declared parameter; faults of single keys are added to ``faults``.

    Raises UserError when its default cannot be read.
    """
    node, name = named.node, named.name.text
    if not isinstance(node, MapNode):
        compiled = constant_value(node, ANY, context)
        return Parameter(name, widened(compiled.type), compiled.value())
    for key, _ in node:
        if key.text not in AT["parameter"]:
            hint = nearest(key.text, AT["parameter"])
            faults.fail("unknown-key", f"a parameter has no '{key.text}'", key.where, hint)
    declared, default, help_ = node.get("type"), node.get("default"), node.get("help")
    type_: Type = ANY
    if declared is not None:
        type_ = named_type(declared, faults) or ANY
    elif default is not None:
        type_ = widened(constant_value(default, ANY, context).type)
    type_ = _bounded(node, type_, context, faults)
    value = None if default is None else _default(name, default, type_, context)
    return Parameter(
        name,
        type_,
        value,
        required=default is None,
        help=help_.text if isinstance(help_, Scalar) else "",
    )


def _default(name: str, node: YamlNode, type_: Type, context: Context) -> Any:
    try:
        return constant_value(node, type_, context).value()
    except UserError as error:
        if error.code != "out-of-range":
            raise
        raise UserError(
            "default-out-of-range",
            f"the default of '{name}' lies outside its own bounds: {error.faults[0].message}",
            node.where,
        ) from None


def _bounded(node: MapNode, type_: Type, context: Context, faults: Faults) -> Type:
    """A type with the bounds or choices that a parameter declares for it."""
    bounds = {"min": -inf, "max": inf}
    for key in bounds:
        bound = node.get(key)
        if bound is None:
            continue
        if not isinstance(type_, Number):
            faults.fail("wrong-type", f"`{key}` needs a number, this is {type_}", bound.where)
            continue
        with faults.collecting():
            limit = constant_value(bound, Number(type_.dimension), context)
            bounds[key] = float(limit.value())
    if isinstance(type_, Number):
        if bounds["min"] > bounds["max"]:
            faults.fail("wrong-bounds", "`min` is larger than `max`", node.where)
            return type_
        type_ = Number(type_.dimension, bounds["min"], bounds["max"])
    choices = node.get("choices")
    if isinstance(choices, Sequence):
        return Text(tuple(item.text for item in choices.items if isinstance(item, Scalar)))
    if choices is not None:
        faults.fail("wrong-type", "`choices` is a list of texts", choices.where)
    return type_


def constant_value(node: YamlNode, type_: Type, context: Context) -> Compiled:
    """Compile a value that does not change while the mission runs. Raises UserError."""
    scope = Scope(warnings=context.scope.warnings)
    compiled = read_value(node, type_, Context(scope, context.places, context.world_places))
    if not compiled.constant:
        raise UserError("not-constant", "only a plain value may stand here", node.where)
    return compiled


def named_type(node: YamlNode, faults: Faults) -> Type | None:
    """The type that a ``type:`` names; None, with a fault, when there is none of that name.

    A list of one type is the type of lists of it: ``[length]``.
    """
    if isinstance(node, Scalar) and node.text in NAMED:
        return NAMED[node.text]
    if isinstance(node, Sequence):
        if len(node.items) == 1:
            item = named_type(node.items[0], faults)
            return None if item is None else ListOf(item, f"a list, each {item}")
        hint = "a list of lengths is [length]"
        faults.fail("unknown-type", "a typed list names one type", node.where, hint)
        return None
    text = f"'{node.text}'" if isinstance(node, Scalar) else "this"
    faults.fail("unknown-type", f"{text} is no type", node.where, nearest(text.strip("'"), NAMED))
    return None


def widened(type_: Type) -> Type:
    """The type of a variable from the type of its first value."""
    if isinstance(type_, Number):
        return Number(type_.dimension)
    if isinstance(type_, Text):
        return TEXT
    if isinstance(type_, (NoneType, Mixed)):
        return ANY
    if isinstance(type_, ListOf):
        return ListOf(widened(type_.item), type_.named)
    return type_
