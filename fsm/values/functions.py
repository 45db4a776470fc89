"""The pure functions of expressions, and the guarded operations their code is made of.

Each function has a rule for its type; whatever goes wrong in flight is an :class:`EvaluationError`
with a sentence for the log.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from fsm.values.types import (
    ANY,
    BARE,
    BOOL,
    MAX_NUMBER,
    POINT,
    AnyType,
    ListOf,
    MapOf,
    Number,
    PointType,
    Text,
    Type,
    fits,
    join,
)
from vencejo.geometry import Point, bearing, distance, wrap
from vencejo.units import ANGLE, LENGTH

LOOP_BUDGET = 20_000
"""The most steps of all comprehensions in one evaluation."""


MAX_RESULT = 1_000_000
"""The largest size of a value: the characters of its texts, and 8 for anything else in it."""
MAX_NESTING = 50
"""The most levels of lists and maps inside each other."""


class EvaluationError(Exception):
    """An expression has no value at present; the message says why."""


FAILURES = (EvaluationError, ArithmeticError, TypeError, ValueError, LookupError, AttributeError)
"""The exceptions that a checked expression can still raise; all become ``error.execution``."""


def plain(error: Exception) -> str:
    """The reason why an expression has no value, in plain words."""
    if isinstance(error, OverflowError):
        return "the result is too large"
    if isinstance(error, ZeroDivisionError):
        return "a division by zero"
    return str(error)


def bounded(value: Any) -> Any:
    """The value, if it is small enough to keep. Raises EvaluationError."""
    if isinstance(value, (int, float)) and -MAX_NUMBER < value < MAX_NUMBER:
        return value
    size = 0
    level: list[Any] = [value]
    for _ in range(MAX_NESTING):
        inside: list[Any] = []
        for element in level:
            size += len(element) if isinstance(element, str) else 8
            if isinstance(element, (int, float)) and not abs(element) < MAX_NUMBER:
                raise EvaluationError("the result is too large a number")
            if isinstance(element, (list, tuple, dict)):
                size += 8 * len(element)
                if size <= MAX_RESULT:
                    inside.extend(element.values() if isinstance(element, dict) else element)
            if size > MAX_RESULT:
                raise EvaluationError("the result is larger than 1 MB")
        if not inside:
            return value
        level = inside
    raise EvaluationError("the result has too many lists inside lists")


def number(value: Any) -> Any:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return value
    raise EvaluationError(f"{shown(value)} is no number")


def truth(value: Any) -> bool:
    if isinstance(value, bool):
        return value
    raise EvaluationError(f"{shown(value)} is neither true nor false")


def power(base: float, exponent: float) -> float:
    result: float | complex = float(base) ** float(exponent)
    if isinstance(result, complex):
        raise EvaluationError("a negative number has no such power")
    return result


def part(value: Any, name: str) -> Any:
    """A declared field of a record, which may be an object of the host or a map."""
    return value[name] if isinstance(value, dict) else getattr(value, name)


def field(value: Any, name: str) -> Any:
    """A field of a map or point; never an attribute of anything else."""
    if isinstance(value, dict) and name in value:
        return value[name]
    if isinstance(value, Point) and name in ("x", "y", "z"):
        return getattr(value, name)
    raise EvaluationError(f"{shown(value)} has no '{name}'")


def item(value: Any, index: Any) -> Any:
    """An element of a list (from the end when negative) or a value of a map."""
    if isinstance(value, dict):
        if index in value:
            return value[index]
        raise EvaluationError(f"the map has no {shown(index)}")
    if not isinstance(value, (list, tuple)):
        raise EvaluationError(f"{shown(value)} is no list")
    index = number(index)
    if index != int(index) or not -len(value) <= index < len(value):
        raise EvaluationError(f"a list of {len(value)} has no element {index:g}")
    return value[int(index)]


def contains(element: Any, collection: Any) -> bool:
    if isinstance(collection, str):
        return isinstance(element, str) and element in collection
    if isinstance(collection, (list, tuple, dict)):
        return element in collection
    raise EvaluationError(f"{shown(collection)} is no list")


class Budget:
    """Counts the steps of the comprehensions in one evaluation."""

    __slots__ = ("left",)

    def __init__(self) -> None:
        self.left = LOOP_BUDGET

    def loop(self, values: Any) -> Iterator[Any]:
        if not isinstance(values, (list, tuple)):
            raise EvaluationError(f"{shown(values)} is no list")
        for value in values:
            self.left -= 1
            if self.left < 0:
                raise EvaluationError(f"more than {LOOP_BUDGET} steps of loops at once")
            yield value


_WORDS = {True: "true", False: "false", None: "none"}


def shown(value: Any) -> str:
    """A value as an expression would write it, shortened."""
    text = as_text(value)
    return text if len(text) <= 40 else text[:39] + "…"


def as_text(value: Any) -> str:
    """The form of a value inside a text."""
    match value:
        case bool() | None:
            return _WORDS[value]
        case float():
            return f"{value:.6g}"
        case Point():
            return f"({value.x:.2f}, {value.y:.2f}, {value.z:.2f})"
        case list() | tuple():
            return f"[{', '.join(as_text(element) for element in value)}]"
        case dict():
            return f"{{{', '.join(f'{key}: {as_text(v)}' for key, v in value.items())}}}"
        case _:
            return str(value)


@dataclass(frozen=True)
class BuiltinFunction:
    """A callable of expressions: its code, how many arguments, and the rule of its type."""

    call: Callable[..., Any]
    least: int
    most: int
    result: Callable[[Sequence[Type]], Type | str]
    """The type of the result, or a sentence that says what does not fit."""


def _numbers(types: Sequence[Type]) -> str | None:
    for given in types:
        if not isinstance(given, (Number, AnyType)):
            return f"takes numbers, not {given}"
    joined = types[0]
    for given in types[1:]:
        if not fits(joined, given):
            return f"takes numbers of one dimension, not {joined} and {given}"
        joined = join(joined, given)
    return None


def _same(types: Sequence[Type]) -> Type | str:
    """Numbers of one dimension give that dimension."""
    wrong = _numbers(types)
    if wrong:
        return wrong
    joined = types[0]
    for given in types[1:]:
        joined = join(joined, given)
    return Number(joined.dimension) if isinstance(joined, Number) else joined


def _items(types: Sequence[Type]) -> Type | str:
    """A list of numbers gives a number of their dimension."""
    if isinstance(types[0], AnyType):
        return ANY
    return (
        _same([types[0].item]) if isinstance(types[0], ListOf) else f"takes a list, not {types[0]}"
    )


def _same_or_items(types: Sequence[Type]) -> Type | str:
    return _items(types) if len(types) == 1 and isinstance(types[0], ListOf) else _same(types)


def _first(types: Sequence[Type]) -> Type | str:
    wrong = _numbers(types[:1]) or _numbers(types[1:] or types[:1])
    return wrong or (Number(types[0].dimension) if isinstance(types[0], Number) else ANY)


def _gives(result: Type, *allowed: type[Type]) -> Callable[[Sequence[Type]], Type | str]:
    def rule(types: Sequence[Type]) -> Type | str:
        for given in types:
            if not isinstance(given, (*allowed, AnyType)):
                return f"cannot take {given}"
        return result

    return rule


def _numeric(result: Type) -> Callable[[Sequence[Type]], Type | str]:
    return lambda types: _numbers(types) or result


def _angle_in(types: Sequence[Type]) -> Type | str:
    return BARE if fits(Number(ANGLE), types[0]) else f"takes an angle, not {types[0]}"


def _angle_out(types: Sequence[Type]) -> Type | str:
    return Number(ANGLE) if fits(Number(ANGLE), types[0]) else f"takes an angle, not {types[0]}"


def _root(types: Sequence[Type]) -> Type | str:
    wrong = _numbers(types)
    if wrong:
        return wrong
    dimension = types[0].dimension if isinstance(types[0], Number) else None
    if dimension is None or any(power % 2 for power in dimension):
        return BARE
    return Number(type(dimension)(*(power // 2 for power in dimension)))


def _lengths(types: Sequence[Type]) -> Type | str:
    for given in types:
        if not fits(Number(LENGTH), given):
            return f"takes lengths, not {given}"
    return POINT


def _points(result: Type) -> Callable[[Sequence[Type]], Type | str]:
    return _gives(result, PointType, ListOf)


def _extreme(choose: Callable[[Any], Any]) -> Callable[..., Any]:
    def call(*values: Any) -> Any:
        if len(values) == 1 and isinstance(values[0], (list, tuple)):
            values = tuple(values[0])
        if not values:
            raise EvaluationError("an empty list has no smallest or largest element")
        return choose(map(number, values))

    return call


def _sqrt(value: float) -> float:
    if value < 0:
        raise EvaluationError("a negative number has no square root")
    return math.sqrt(value)


def _sign(value: float) -> int:
    return (value > 0) - (value < 0)


def _round(value: float, digits: float = 0) -> float:
    # Of a float: rounding an integer to -10**9 digits would compute that power of ten.
    return round(float(value), int(digits)) if digits else round(value)


def _point_of(value: Any) -> Point:
    if isinstance(value, Point):
        return value
    if isinstance(value, (list, tuple)) and len(value) == 3:
        return Point(*map(number, value))
    raise EvaluationError(f"{shown(value)} is no point")


FUNCTIONS: dict[str, BuiltinFunction] = {
    "abs": BuiltinFunction(abs, 1, 1, _same),
    "min": BuiltinFunction(_extreme(min), 1, 99, _same_or_items),
    "max": BuiltinFunction(_extreme(max), 1, 99, _same_or_items),
    "clamp": BuiltinFunction(lambda x, low, high: max(low, min(high, x)), 3, 3, _same),
    "sign": BuiltinFunction(_sign, 1, 1, _numeric(BARE)),
    "round": BuiltinFunction(_round, 1, 2, _first),
    "floor": BuiltinFunction(math.floor, 1, 1, _same),
    "sqrt": BuiltinFunction(_sqrt, 1, 1, _root),
    "sin": BuiltinFunction(math.sin, 1, 1, _angle_in),
    "cos": BuiltinFunction(math.cos, 1, 1, _angle_in),
    "atan2": BuiltinFunction(math.atan2, 2, 2, _numeric(Number(ANGLE))),
    "hypot": BuiltinFunction(math.hypot, 2, 3, _same),
    "wrap": BuiltinFunction(wrap, 1, 1, _angle_out),
    "len": BuiltinFunction(len, 1, 1, _gives(Number(whole=True), ListOf, MapOf, Text)),
    "any": BuiltinFunction(lambda values: any(map(truth, values)), 1, 1, _gives(BOOL, ListOf)),
    "all": BuiltinFunction(lambda values: all(map(truth, values)), 1, 1, _gives(BOOL, ListOf)),
    "sum": BuiltinFunction(lambda values: sum(map(number, values)), 1, 1, _items),
    "mod": BuiltinFunction(lambda a, b: a % b, 2, 2, _same),
    "point": BuiltinFunction(lambda x, y, z: Point(float(x), float(y), float(z)), 3, 3, _lengths),
    "distance": BuiltinFunction(
        lambda a, b: distance(_point_of(a), _point_of(b)), 2, 2, _points(Number(LENGTH))
    ),
    "bearing": BuiltinFunction(
        lambda a, b: bearing(_point_of(a), _point_of(b)), 2, 2, _points(Number(ANGLE))
    ),
}
"""Every function but ``active``, which asks about states and is compiled on its own."""
