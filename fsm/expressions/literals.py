"""Reads the value in a place of some type: a literal, an expression, or both mixed.

Points, headings and routes keep the form a person wrote when it can only be resolved in flight:
a full ``[x, y, z]`` becomes a :class:`vencejo.Point`, a place name stays a text, and everything
else (``{forward: 2 m}``, ``[x, y]``, ``{lat, lon}``) stays a map of SI numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any

from fsm.expressions.compiled import Compiled, Evaluator, compile_expression, constant
from fsm.expressions.constants import warn_of_angle
from fsm.expressions.scope import Scope
from fsm.expressions.templates import NAME, Inserted, formatted, pieces
from fsm.values.conversion import ABOVE_GROUND, HEADING_WORDS, POINT_FORMS, converted, point_of
from fsm.values.functions import FAILURES, bounded, plain
from fsm.values.types import (
    ANY,
    AREA,
    BOOL,
    HEADING,
    POINT,
    ROUTE,
    TEXT,
    WAYPOINT,
    AnyType,
    Bool,
    HeadingType,
    ListOf,
    MapOf,
    Number,
    PointType,
    Text,
    Type,
    fits,
    in_bounds,
    join_all,
)
from vencejo.errors import Correction, Fault, UserError, Where, certain, nearest
from vencejo.geometry import Point
from vencejo.nodes import Mapping as MapNode
from vencejo.nodes import Scalar, Sequence, YamlNode, kind
from vencejo.units import ANGLE, LENGTH, parse_number, parse_quantity, read_quantity

_POINT_HELP = (
    "write [x, y], [x, y, z], {x, y, z}, {forward, left, up}, {lat, lon, above_home}, "
    "{x, y, above_ground}, home or a place"
)


@dataclass(frozen=True)
class Context:
    """The surroundings of a value: the names in scope and the places that are known."""

    scope: Scope = field(default_factory=Scope)
    places: Mapping[str, Point] = field(default_factory=dict)
    """Places of the mission itself, in the mission frame."""
    world_places: frozenset[str] | None = None
    """Places of the world; None when no world is known yet."""
    peers: frozenset[str] | None = None
    """The vehicles of the fleet; None outside of one."""


def read_value(node: YamlNode, place: Type, context: Context) -> Compiled:
    """The value of a node in a place of type ``place``. Raises UserError, all faults at once."""
    if isinstance(node, Scalar):
        compiled = _read_scalar(node, place, context)
    elif isinstance(node, Sequence):
        compiled = _read_sequence(node, place, context)
    else:
        compiled = _read_mapping(node, place, context)
    if compiled.constant:
        try:
            in_bounds(place, compiled.value())
        except UserError as error:
            raise UserError(error.code, error.faults[0].message, node.where) from None
        except FAILURES as error:
            raise UserError("no-value", f"this has no value: {plain(error)}", node.where) from None
    return compiled


def _wrong(node: YamlNode, place: Type, hint: str | None = None) -> UserError:
    return UserError("wrong-type", f"{kind(node)} is not {place}", node.where, hint)


# -- scalars --------------------------------------------------------------------------------


def _read_scalar(node: Scalar, place: Type, context: Context) -> Compiled:
    if "$" in node.text:
        return _with_dollars(node, place, context)
    if node.null:
        if isinstance(place, AnyType):
            return constant(None, ANY, node.where, node.text)
        raise UserError("wrong-type", f"a value is missing here: {place}", node.where)
    reader = _SCALARS.get(type(place))
    if reader is None:
        raise _wrong(node, place)
    return reader(node, place, context)


def _number(node: Scalar, place: Number, context: Context) -> Compiled:
    """A number, or a quantity of the place's dimension; of any where the place has none."""
    text, where = node.text, node.where
    if place.dimension is not None:
        value = read_quantity(text, place.dimension, where)
        if parse_number(text) is not None:
            warn_of_angle(context.scope, value, text, place, where)
        return constant(value, place, where, text)
    quantity = parse_quantity(text)
    if quantity:
        return constant(quantity[0], Number(quantity[1]), where, text)
    number = parse_number(text)
    if number is None:
        raise _wrong(node, place)
    return constant(number, place, where, text)


def _boolean(node: Scalar, place: Bool, _: Context) -> Compiled:
    text = node.text
    if text not in ("true", "false"):
        yes = text.lower() in ("yes", "on", "y", "1", "true")
        no = text.lower() in ("no", "off", "n", "0", "false")
        meant = "true" if yes else "false"
        hint = Correction(text, meant, f"write {meant}") if yes or no else None
        raise _wrong(node, place, hint)
    return constant(text == "true", BOOL, node.where, text)


def _text(node: Scalar, place: Text, _: Context) -> Compiled:
    text = node.text
    if place.choices and text not in place.choices:
        hint = nearest(text, place.choices)
        raise UserError("unknown-word", f"'{text}' is not {place}", node.where, hint)
    return constant(text, place, node.where, text)


def _heading(node: Scalar, place: HeadingType, context: Context) -> Compiled:
    text, where = node.text, node.where
    if text in HEADING_WORDS:
        return constant(text, place, where, text)
    number = parse_number(text)
    if number is None and parse_quantity(text) is None:
        hint = "write an angle (90 deg), keep, travel or {face: point}"
        raise UserError("wrong-type", f"'{text}' is no heading", where, hint)
    if number is not None:
        warn_of_angle(context.scope, number, text, place, where)
    return constant(read_quantity(text, ANGLE, where), place, where, text)


def _untyped(node: Scalar, _place: AnyType, _: Context) -> Compiled:
    """A scalar where any value may stand: YAML 1.2's own types, quantities, else a text."""
    text, where = node.text, node.where
    if node.plain:
        if text in ("true", "false"):
            return constant(text == "true", BOOL, where, text)
        number = parse_number(text)
        if number is not None:
            return constant(number, Number(), where, text)
        quantity = parse_quantity(text)
        if quantity is not None:
            return constant(quantity[0], Number(quantity[1]), where, text)
    return constant(text, TEXT, where, text)


def _point(node: Scalar, _: PointType, context: Context) -> Compiled:
    """A named place of the mission or the world, or `home`."""
    name, where = node.text, node.where
    if name in context.places:
        return constant(context.places[name], POINT, where, name)
    known = {"home", *context.places, *(context.world_places or ())}
    if name in known or (context.world_places is None and name.isidentifier()):
        return constant(name, POINT, where, name)
    raise UserError(
        "unknown-place",
        f"there is no place '{name}'",
        where,
        nearest(name, known, otherwise=_POINT_HELP),
    )


_SCALARS: Mapping[type[Type], Callable[[Scalar, Any, Context], Compiled]] = {
    AnyType: _untyped,
    Number: _number,
    Bool: _boolean,
    Text: _text,
    PointType: _point,
    HeadingType: _heading,
}
"""Type of the place → reader of its scalars; places of other types take none."""


# -- expressions inside values --------------------------------------------------------------


def _with_dollars(node: Scalar, place: Type, context: Context) -> Compiled:
    text, where = node.text, node.where.right(0 if node.plain else 1)
    whole = NAME.fullmatch(text)
    if whole:
        return _placed(compile_expression(whole[1], where.right(1), context.scope, place), place)
    parts = list(pieces(text, where))
    if len(parts) == 1 and isinstance(parts[0], Inserted) and not parts[0].format:
        only = parts[0]
        return _placed(compile_expression(only.source, only.where, context.scope, place), place)
    if not fits(place, TEXT) or isinstance(place, PointType | HeadingType):
        raise UserError(
            "wrong-type",
            f"a text with something inserted is not {place}",
            node.where,
            "the whole value must be one expression: ${…}",
        )
    return _placed(_template(node, parts, context), place)


def _template(node: Scalar, parts: list[str | Inserted], context: Context) -> Compiled:
    if all(isinstance(part, str) for part in parts):
        return constant("".join(map(str, parts)), TEXT, node.where, node.text)
    functions: list[Evaluator] = []
    for part in parts:
        if isinstance(part, str):
            functions.append(lambda s, e, text=part: text)  # type: ignore[misc]
        else:
            value = compile_expression(part.source, part.where, context.scope)
            if part.format and not isinstance(value.type, (Number, AnyType)):
                message = f"'{part.source}' is {value.type}, and a number format follows it"
                raise UserError("wrong-type", message, part.where, "leave the format out")
            functions.append(formatted(value.function, part.format))
    return Compiled(
        TEXT,
        lambda s, e: bounded("".join(function(s, e) for function in functions)),
        node.text,
        node.where,
    )


def _placed(compiled: Compiled, place: Type) -> Compiled:
    """The expression, with its value converted for its place at each evaluation."""
    if isinstance(place, AnyType):
        return compiled
    return Compiled(
        compiled.type,
        converted(compiled.function, place),
        compiled.source,
        compiled.where,
        compiled.constant,
        compiled.reads,
    )


# -- collections ----------------------------------------------------------------------------


@contextmanager
def collecting(faults: list[Fault]) -> Iterator[None]:
    """Add the faults of a UserError to a list, and go on after the block."""
    try:
        yield
    except UserError as error:
        faults.extend(error.faults)


def _read_all(nodes: list[tuple[YamlNode, Type]], context: Context) -> list[Compiled]:
    """Read several values. Raises UserError with the faults of all of them."""
    faults: list[Fault] = []
    found = []
    for node, place in nodes:
        with collecting(faults):
            found.append(read_value(node, place, context))
    if faults:
        raise UserError.of(faults)
    return found


def _built(
    items: list[Compiled], make: Callable[[list[Any]], Any], type_: Type, where: Where
) -> Compiled:
    """A value that is made of others, and constant when they all are."""
    functions = [item.function for item in items]
    all_constant = all(item.constant for item in items)
    if all_constant:
        value = make([item.value() for item in items])
        # A mutable constant must not be shared between instances: it is built anew each time.
        if not isinstance(value, (list, dict)):
            return constant(value, type_, where)
    return Compiled(
        type_,
        lambda s, e: make([f(s, e) for f in functions]),
        "",
        where,
        constant=all_constant,
        needs=frozenset().union(*(item.needs for item in items)),
    )


def _read_sequence(node: Sequence, place: Type, context: Context) -> Compiled:
    match place:
        case PointType():
            if len(node.items) not in (2, 3):
                raise UserError(
                    "wrong-type",
                    f"a point has 2 or 3 numbers, not {len(node.items)}",
                    node.where,
                    _POINT_HELP,
                )
            items = _read_all([(item, Number(LENGTH)) for item in node.items], context)
            return _built(items, point_of, POINT, node.where)
        case ListOf(item=item_type):
            if place == ROUTE:
                _warn_of_no_points(node, context)
                types: list[Type] = [
                    WAYPOINT if isinstance(item, MapNode) and item.get("at") else POINT
                    for item in node.items
                ]
            else:
                types = [item_type] * len(node.items)
            items = _read_all(list(zip(node.items, types, strict=True)), context)
            if place == AREA and len(items) < 3:
                raise UserError("wrong-type", "an area has at least 3 points", node.where)
            return _built(
                items, list, place if item_type != ANY else _list_type(items, place), node.where
            )
        case AnyType():
            items = _read_all([(item, ANY) for item in node.items], context)
            return _built(items, list, _list_type(items, ListOf()), node.where)
        case _:
            raise _wrong(node, place)


def _warn_of_no_points(node: Sequence, context: Context) -> None:
    if not node.items:
        hint = "points: [[4, 0, 3], [4, 4, 3]]"
        context.scope.warn("empty-route", "this route has no points", node.where, hint)


def _list_type(items: list[Compiled], otherwise: Type) -> Type:
    """The type of a list from those of its items; ``otherwise`` where they do not tell."""
    if not items or otherwise == ROUTE:
        return otherwise
    return ListOf(join_all([item.type for item in items]))


def _read_mapping(node: MapNode, place: Type, context: Context) -> Compiled:
    match place:
        case PointType():
            return _point_form(node, context)
        case HeadingType():
            return _fields_of(node, MapOf({"face": POINT}, frozenset({"face"})), context, HEADING)
        case MapOf():
            return _fields_of(node, place, context, place)
        case AnyType():
            return _fields_of(node, MapOf(), context, MapOf())
        case _:
            raise _wrong(node, place)


def _point_form(node: MapNode, context: Context) -> Compiled:
    names = {key.text for key, _ in node}
    known = {name for form in POINT_FORMS for name in form}
    alike = {name if name in known else certain(name, known) for name in names}
    form = max(POINT_FORMS, key=lambda form: len(alike & set(form)))
    if names <= known and not names <= set(form):
        shown = " and ".join(f"`{name}`" for name in sorted(names - {"frame"}))
        raise UserError("wrong-type", f"no point is given by {shown}", node.where, _POINT_HELP)
    compiled = _fields_of(node, MapOf(form), context, POINT)
    if "lat" in form and not {"lat", "lon"} <= names:
        raise UserError("missing-key", "a place by latitude needs lat and lon", node.where)
    if not names:
        raise UserError("wrong-type", "an empty map is no point", node.where, _POINT_HELP)

    def whole(value: dict[str, Any]) -> Any:
        if {"x", "y", "z"} == set(value):
            return Point(float(value["x"]), float(value["y"]), float(value["z"]))
        return value

    inner = compiled.function
    needs = frozenset({"terrain"}) if ABOVE_GROUND in names else compiled.needs
    return Compiled(
        POINT,
        lambda s, e: whole(inner(s, e)),
        "",
        node.where,
        compiled.constant,
        needs=needs,
    )


def _fields_of(node: MapNode, shape: MapOf, context: Context, type_: Type) -> Compiled:
    faults: list[Fault] = []
    names: list[str] = []
    values: list[tuple[YamlNode, Type]] = []
    for key, value in node:
        if shape.fields is not None and key.text not in shape.fields:
            hint = nearest(key.text, shape.fields)
            if key.text.startswith("${") or key.text == "$":
                hint = '`${…}` inside `{ }` or `[ ]` needs quotes: "${…}"'
            faults.append(Fault("unknown-key", f"{type_} has no '{key.text}'", key.where, hint))
            continue
        names.append(key.text)
        values.append((value, shape.fields[key.text] if shape.fields is not None else ANY))
    for missing in sorted(shape.required - set(names)):
        if get_close_matches(missing, [key.text for key, _ in node]):
            continue  # misspelt, and reported as unknown
        faults.append(Fault("missing-key", f"'{missing}' is missing", node.where))
    items: list[Compiled] = []
    with collecting(faults):
        items = _read_all(values, context)
    if faults:
        raise UserError.of(faults)
    return _built(items, lambda found: dict(zip(names, found, strict=True)), type_, node.where)
