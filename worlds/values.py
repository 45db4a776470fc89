"""The values of world files: how each is read, and its JSON Schema.

Reading raises UserError with every fault of the value, each at its place.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import inf, isfinite, pi
from typing import Any, Generic, NamedTuple, TypeVar

from vencejo import nodes
from vencejo.errors import Fault, UserError, nearest
from vencejo.nodes import Scalar, Sequence, YamlNode, kind
from vencejo.units import (
    ANGLE,
    LENGTH,
    NUMBER,
    POWER,
    RATIO,
    SPEED,
    UNITS,
    Dimension,
    format_quantity,
    parse_number,
    read_quantity,
)
from worlds.colors import COLORS
from worlds.things import Color

T = TypeVar("T")
_S = TypeVar("_S")
_DEGREE = pi / 180
_FAR = 1e5
"""The largest coordinate and the largest size, metres."""
NAME = r"[a-z][a-z0-9_]*"
Schema = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Value(Generic[T]):
    """A kind of value that can stand in a world file."""

    read: Callable[[YamlNode], T]
    schema: Schema


class Misfit(Exception):
    """Values of a map that do not go together; ``key`` is the one that the error points at."""

    def __init__(self, code: str, message: str, key: str = "", hint: str | None = None) -> None:
        super().__init__(message)
        self.code, self.message, self.key, self.hint = code, message, key, hint


# Words and numbers.


def _text(node: YamlNode) -> str:
    if isinstance(node, Scalar) and not node.null:
        return node.text
    raise UserError("wrong-type", f"a text is needed here, not {kind(node)}", node.where)


def _flag(node: YamlNode) -> bool:
    if isinstance(node, Scalar) and node.text in ("true", "false"):
        return node.text == "true"
    raise UserError("wrong-type", f"true or false is needed here, not {kind(node)}", node.where)


def _color(node: YamlNode) -> Color:
    if isinstance(node, Scalar):
        if node.text not in COLORS:
            hint = nearest(node.text, COLORS)
            raise UserError("unknown-color", f"no colour is called '{node.text}'", node.where, hint)
        return COLORS[node.text]
    items = node.items if isinstance(node, Sequence) else []
    parts = [parse_number(item.text) for item in items if isinstance(item, Scalar)]
    values = [part for part in parts if isinstance(part, int) and 0 <= part <= 255]
    if len(values) != 3 or len(items) != 3:
        raise UserError(
            "wrong-type", "a colour is a name, or [red, green, blue] from 0 to 255", node.where
        )
    return (values[0], values[1], values[2])


def count(low: int) -> Value[int]:
    """A whole number of ``low`` or more."""

    def read(node: YamlNode) -> int:
        number = parse_number(node.text) if isinstance(node, Scalar) else None
        if not isinstance(number, int):
            raise UserError(
                "wrong-type", f"a whole number is needed here, not {kind(node)}", node.where
            )
        if number < low:
            raise UserError("out-of-range", f"{number}; it must be {low} or more", node.where)
        return number

    return Value(read, {"type": "integer", "minimum": low})


def quantity(dimension: Dimension, low: float = -inf, high: float = inf) -> Value[float]:
    """A number with a unit of that dimension, or a bare one in SI units."""

    def read(node: YamlNode) -> float:
        if not isinstance(node, Scalar):
            raise UserError(
                "wrong-type", f"{dimension} is needed here, not {kind(node)}", node.where
            )
        value = read_quantity(node.text, dimension, node.where)
        if not (isfinite(value) and low <= value <= high):
            span = "a finite number"
            if isfinite(high):
                span = " to ".join(format_quantity(bound, dimension) for bound in (low, high))
            raise UserError(
                "out-of-range", f"{dimension} of {node.text}; it must be {span}", node.where
            )
        return value

    units = "|".join(re.escape(name) for name, (_, known) in UNITS.items() if known == dimension)
    bounds = {"minimum": low, "maximum": high}
    number = {"type": "number", **{key: v for key, v in bounds.items() if isfinite(v)}}
    text = {"type": "string", "pattern": rf"^{NUMBER}\s*({units})?$"}
    return Value(read, {"anyOf": [number, text]})


def above_zero(dimension: Dimension, high: float) -> Value[float]:
    """A quantity above 0, such as a size or a speed."""
    any_sign = quantity(dimension, -high, high)

    def read(node: YamlNode) -> float:
        value = any_sign.read(node)
        if value <= 0:
            assert isinstance(node, Scalar)
            raise UserError(
                "bad-size", f"{dimension} of {node.text}; it must be above 0", node.where
            )
        return value

    number, text = any_sign.schema["anyOf"]
    pattern = text["pattern"].replace("^", "^(?=[+0.]*[1-9])", 1)
    positive = {"type": "string", "pattern": pattern}
    return Value(read, {"anyOf": [{**number, "minimum": 0, "exclusiveMinimum": 0}, positive]})


def degrees(most: float) -> Value[float]:
    """A latitude or longitude, in degrees: a bare number is in degrees too."""
    angle = quantity(ANGLE, -most * _DEGREE, most * _DEGREE)

    def read(node: YamlNode) -> float:
        bare = parse_number(node.text) if isinstance(node, Scalar) else None
        if bare is None:
            return angle.read(node) / _DEGREE
        if not -most <= bare <= most:
            raise UserError(
                "out-of-range", f"{bare:g} degrees; it must be {-most:g} to {most:g}", node.where
            )
        return float(bare)

    number = {"type": "number", "minimum": -most, "maximum": most}
    return Value(read, {"anyOf": [number, angle.schema["anyOf"][1]]})


TEXT = Value(_text, {"type": ["string", "number", "boolean"]})
FLAG = Value(_flag, {"type": "boolean"})
COLOR = Value(
    _color,
    {
        "anyOf": [
            {"enum": list(COLORS)},
            {
                "type": "array",
                "items": {"type": "integer", "minimum": 0, "maximum": 255},
                "minItems": 3,
                "maxItems": 3,
            },
        ]
    },
)
COORDINATE = quantity(LENGTH, -_FAR, _FAR)
SIZE = above_zero(LENGTH, _FAR)
ANGLE_VALUE = quantity(ANGLE)
SPEED_VALUE = above_zero(SPEED, 1000.0)
CHARGING = above_zero(POWER, 1e6)
SHARE = quantity(RATIO, 0.0, 1.0)
FACTOR = above_zero(RATIO, _FAR)


# Lists.


def each(items: Iterable[YamlNode], read: Callable[[YamlNode], _S]) -> list[_S]:
    """Read some nodes. Raises UserError with the faults of all of them."""
    values, faults = [], list[Fault]()
    for item in items:
        try:
            values.append(read(item))
        except UserError as error:
            faults.extend(error.faults)
    if faults:
        raise UserError.of(faults)
    return values


def array(what: str, item: Value[_S], low: int, high: int | None = None) -> Value[tuple[_S, ...]]:
    """A list of ``low`` to ``high`` values; ``what`` begins the errors: "a place is [x, y]"."""

    def read(node: YamlNode) -> tuple[_S, ...]:
        items = node.items if isinstance(node, Sequence) else []
        enough = low <= len(items) and (high is None or len(items) <= high)
        if not isinstance(node, Sequence) or not enough:
            shown = f"a list of {len(items)}" if isinstance(node, Sequence) else kind(node)
            raise UserError("wrong-type", f"{what}, not {shown}", node.where)
        return tuple(each(items, item.read))

    top = {} if high is None else {"maxItems": high}
    return Value(read, {"type": "array", "items": item.schema, "minItems": low, **top})


class Spot(NamedTuple):
    """A place whose height may be left out: then it is on the ground."""

    x: float
    y: float
    z: float | None = None


def _converted(value: Value[_S], convert: Callable[[_S], T]) -> Value[T]:
    return Value(lambda node: convert(value.read(node)), value.schema)


SPOT = _converted(
    array("a place is [x, y] or [x, y, z] in metres", COORDINATE, 2, 3), lambda v: Spot(*v)
)
FLAT_SPOT = _converted(
    array("a place on the ground is [x, y] in metres", COORDINATE, 2, 2), lambda v: (v[0], v[1])
)
PLACE = array("a place is [x, y, z] in metres", COORDINATE, 3, 3)


# Maps.


class _Needed:
    """Stands for the default of a key that has none, and so has to be given."""


NEEDED = _Needed()


@dataclass(frozen=True, slots=True)
class Field:
    """A key of a map: its kind of value, and the default."""

    value: Value[Any]
    default: Any = NEEDED


def record(what: str, fields: Mapping[str, Field], build: Callable[..., T]) -> Value[T]:
    """A map of known keys, whose values become the arguments of ``build``.

    ``build`` raises Misfit where they do not go together; ``what`` names the map in errors.
    """

    def read(node: YamlNode) -> T:
        values, faults = read_fields(node, what, fields)
        if faults:
            raise UserError.of(faults)
        assert isinstance(node, nodes.Mapping)
        try:
            return build(**values)
        except Misfit as misfit:
            found = node.get(misfit.key)
            place = (found or node).where
            raise UserError(misfit.code, misfit.message, place, misfit.hint) from None

    return Value(read, fields_schema(fields))


def read_fields(
    node: YamlNode, what: str, fields: Mapping[str, Field]
) -> tuple[dict[str, Any], list[Fault]]:
    """The values of a map by key, with defaults, and the faults of all others."""
    if not isinstance(node, nodes.Mapping):
        fault = Fault("wrong-type", f"{what} is a map, not {kind(node)}", node.where)
        return {}, [fault]
    values, faults = {}, []
    for key, value in node:
        if key.text not in fields:
            hint = nearest(key.text, fields)
            fault = Fault("unknown-key", f"{what} has no '{key.text}'", key.where, hint)
            faults.append(fault)
            continue
        try:
            values[key.text] = fields[key.text].value.read(value)
        except UserError as error:
            faults.extend(error.faults)
    given = {key.text for key, _ in node}
    for name, field in fields.items():
        if name not in given and field.default is NEEDED:
            faults.append(Fault("missing-key", f"{what} needs '{name}'", node.where))
        elif name not in given:
            values[name] = field.default
    return values, faults


def fields_schema(fields: Mapping[str, Field]) -> Schema:
    """The JSON Schema of a map of known keys."""
    return {
        "type": "object",
        "properties": {name: field.value.schema for name, field in fields.items()},
        "required": [name for name, field in fields.items() if field.default is NEEDED],
        "additionalProperties": False,
    }


class NamedEntries(NamedTuple, Generic[T]):
    """The readable entries of a map of names, and the faults of the others."""

    entries: tuple[tuple[Scalar, T], ...] = ()
    faults: tuple[Fault, ...] = ()


def names(what: str, value: Value[T]) -> Value[NamedEntries[T]]:
    """A map of names. Reading raises nothing: faults are returned beside the readable entries."""

    def read(node: YamlNode) -> NamedEntries[T]:
        if not isinstance(node, nodes.Mapping):
            message = f"'{what}' is a map of names, not {kind(node)}"
            return NamedEntries((), (Fault("wrong-type", message, node.where),))
        entries, faults = [], []
        for key, item in node:
            if not re.fullmatch(NAME, key.text):
                hint = "small letters, digits and _, a letter first"
                faults.append(Fault("bad-name", f"'{key.text}' is no name", key.where, hint))
            try:
                entries.append((key, value.read(item)))
            except UserError as error:
                faults.extend(error.faults)
        return NamedEntries(tuple(entries), tuple(faults))

    schema = {
        "type": "object",
        "patternProperties": {f"^{NAME}$": value.schema},
        "additionalProperties": False,
    }
    return Value(read, schema)
