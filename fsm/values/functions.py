"""The pure functions of expressions, and the guarded operations their code is made of.

Each function has a rule for its type; whatever goes wrong in flight is an :class:`EvaluationError`
with a sentence for the log.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from fsm.values.types import (
    ANY,
    BARE,
    BOOL,
    MAX_NUMBER,
    POINT,
    AnyType,
    Bool,
    ListOf,
    MapOf,
    Mixed,
    Number,
    PointType,
    Text,
    Type,
    alike,
    fits,
    join,
    raised,
)
from vencejo.geometry import Point, bearing, distance, wrap
from vencejo.units import ANGLE, LENGTH, RATIO

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
    if value == "home" and name in ("x", "y"):
        return 0.0
    raise EvaluationError(f"{shown(value)} has no '{name}'")


def source(event: Any) -> str:
    """The vehicle that sent an event; empty for one that no other vehicle sent."""
    found = event.get("source", "")
    return found if isinstance(found, str) else ""


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
            self.spend(1)
            yield value

    def spend(self, steps: int) -> None:
        """Count steps. Raises EvaluationError when there were too many."""
        self.left -= steps
        if self.left < 0:
            raise EvaluationError(f"more than {LOOP_BUDGET} steps of loops at once")


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
class Misfit:
    """The reason why a function cannot take its arguments, as the end of a sentence; code, hint."""

    message: str
    code: str = "wrong-type"
    hint: str | None = None


@dataclass(frozen=True)
class BuiltinFunction:
    """A callable of expressions: its code, how many arguments, and the rule of its type."""

    call: Callable[..., Any]
    least: int
    most: int
    result: Callable[[Sequence[Type]], Type | Misfit]
    """The type of the result, or what does not fit."""
    counted: bool = False
    """Its work counts as steps of a loop: its first argument is the :class:`Budget`."""


def _numbers(types: Sequence[Type]) -> Misfit | None:
    for given in types:
        if not isinstance(given, (Number, AnyType)):
            return Misfit(f"takes numbers, not {given}")
    joined = types[0]
    for given in types[1:]:
        if not alike(joined, given):
            message = f"takes numbers of one dimension, not {joined} and {given}"
            return Misfit(message, "wrong-dimension")
        joined = join(joined, given)
    return None


def _same(types: Sequence[Type]) -> Type | Misfit:
    """Numbers of one dimension give that dimension."""
    wrong = _numbers(types)
    if wrong:
        return wrong
    joined = types[0]
    for given in types[1:]:
        joined = join(joined, given)
    return Number(joined.dimension) if isinstance(joined, Number) else joined


def _items(types: Sequence[Type]) -> Type | Misfit:
    """A list of numbers gives a number of their dimension."""
    if isinstance(types[0], AnyType):
        return ANY
    if not isinstance(types[0], ListOf):
        return Misfit(f"takes a list, not {types[0]}")
    item = types[0].item
    return _same(item.options if isinstance(item, Mixed) else [item])


def _same_or_items(types: Sequence[Type]) -> Type | Misfit:
    return _items(types) if len(types) == 1 and isinstance(types[0], ListOf) else _same(types)


def _rounded(types: Sequence[Type]) -> Type | Misfit:
    """The second argument is a number of digits."""
    wrong = _numbers(types[:1]) or _counts(types[1:])
    return wrong or (Number(types[0].dimension) if isinstance(types[0], Number) else ANY)


def _counts(types: Sequence[Type]) -> Misfit | None:
    """Plain numbers: bare ones, or ratios, as a length over a length is one."""
    for given in types:
        if isinstance(given, Number) and not fits(Number(RATIO), given):
            return Misfit(f"counts with a plain number, not {given}", "wrong-dimension")
    return _numbers(types) if types else None


def _range(types: Sequence[Type]) -> Type | Misfit:
    return _counts(types) or ListOf(BARE)


def _gives(result: Type, *allowed: type[Type]) -> Callable[[Sequence[Type]], Type | Misfit]:
    def rule(types: Sequence[Type]) -> Type | Misfit:
        for given in types:
            if not isinstance(given, (*allowed, AnyType)):
                return Misfit(f"cannot take {given}")
        return result

    return rule


def _numeric(result: Type) -> Callable[[Sequence[Type]], Type | Misfit]:
    return lambda types: _numbers(types) or result


def _truths(types: Sequence[Type]) -> Type | Misfit:
    wrong = _gives(BOOL, ListOf)(types)
    item = types[0].item if isinstance(types[0], ListOf) else ANY
    if isinstance(wrong, Misfit) or isinstance(item, (Bool, AnyType)):
        return wrong
    return Misfit(f"takes a list of true or false, not of {item}")


def _angle(result: Type) -> Callable[[Sequence[Type]], Type | Misfit]:
    def rule(types: Sequence[Type]) -> Type | Misfit:
        if fits(Number(ANGLE), types[0]):
            return result
        is_number = isinstance(types[0], Number)
        code = "wrong-dimension" if is_number else "wrong-type"
        return Misfit(f"takes an angle, not {types[0]}", code)

    return rule


def _root(types: Sequence[Type]) -> Type | Misfit:
    wrong = _numbers(types)
    if wrong:
        return wrong
    if not isinstance(types[0], Number):
        return BARE
    return raised(types[0], 0.5) or Misfit(
        f"has no root of {types[0]}",
        "wrong-dimension",
        "the root of a product is that of its dimension: of m·m a length",
    )


def _lengths(types: Sequence[Type]) -> Type | Misfit:
    return next(_not_lengths(types), POINT)


def _points(result: Type) -> Callable[[Sequence[Type]], Type | Misfit]:
    def rule(types: Sequence[Type]) -> Type | Misfit:
        wrong = _gives(result, PointType, ListOf)(types)
        items = [given.item for given in types if isinstance(given, ListOf)]
        return wrong if isinstance(wrong, Misfit) else next(_not_lengths(items), result)

    return rule


def _not_lengths(types: Iterable[Type]) -> Iterator[Misfit]:
    for given in types:
        for option in given.options if isinstance(given, Mixed) else (given,):
            if not fits(Number(LENGTH), option):
                code = "wrong-dimension" if isinstance(option, Number) else "wrong-type"
                yield Misfit(f"takes lengths, not {option}", code)


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


def _range_of(budget: Budget, *bounds: Any) -> list[int]:
    """The whole numbers from 0 or the first bound up to, and without, the next one."""
    if any(number(bound) != int(bound) for bound in bounds):
        raise EvaluationError("range() counts in whole numbers")
    found = range(*map(int, bounds))
    budget.spend(len(found))
    return list(found)


_AXES = frozenset({"x", "y", "z", "frame"})


def _between(measure: Callable[[Point, Point], float]) -> Callable[[Any, Any], float]:
    """A measure of two points; a coordinate that one leaves open (`[x, y]`, `home`) is taken to be
    the other's.
    """

    def call(one: Any, other: Any) -> float:
        a, b = _coordinates(one), _coordinates(other)
        return measure(_filled(a, b), _filled(b, a))

    return call


def _coordinates(value: Any) -> Sequence[Any]:
    """x, y and z of a point in the mission frame; None for what it leaves open."""
    match value:
        case Point():
            return value
        case "home":
            return 0.0, 0.0, None
        case [_, _] | [_, _, _]:
            return [*map(number, value), None][:3]
        case {"frame": "world"}:
            pass
        case dict() if value.keys() <= _AXES and value:
            return [value.get(axis) for axis in "xyz"]
    raise EvaluationError(f"{shown(value)} is no point of the mission frame")


def _filled(point: Sequence[Any], other: Sequence[Any]) -> Point:
    """The point, with the other's coordinates where it leaves them open, and 0 where both do."""
    pairs = zip(point, other, strict=True)
    return Point(*[next((c for c in pair if c is not None), 0.0) for pair in pairs])


FUNCTIONS: dict[str, BuiltinFunction] = {
    "abs": BuiltinFunction(abs, 1, 1, _same),
    "min": BuiltinFunction(_extreme(min), 1, 99, _same_or_items),
    "max": BuiltinFunction(_extreme(max), 1, 99, _same_or_items),
    "clamp": BuiltinFunction(lambda x, low, high: max(low, min(high, x)), 3, 3, _same),
    "sign": BuiltinFunction(_sign, 1, 1, _numeric(BARE)),
    "round": BuiltinFunction(_round, 1, 2, _rounded),
    "floor": BuiltinFunction(math.floor, 1, 1, _same),
    "sqrt": BuiltinFunction(_sqrt, 1, 1, _root),
    "sin": BuiltinFunction(math.sin, 1, 1, _angle(BARE)),
    "cos": BuiltinFunction(math.cos, 1, 1, _angle(BARE)),
    "atan2": BuiltinFunction(math.atan2, 2, 2, _numeric(Number(ANGLE))),
    "hypot": BuiltinFunction(math.hypot, 2, 3, _same),
    "wrap": BuiltinFunction(wrap, 1, 1, _angle(Number(ANGLE))),
    "len": BuiltinFunction(len, 1, 1, _gives(Number(whole=True), ListOf, MapOf, Text)),
    "any": BuiltinFunction(lambda values: any(map(truth, values)), 1, 1, _truths),
    "all": BuiltinFunction(lambda values: all(map(truth, values)), 1, 1, _truths),
    "sum": BuiltinFunction(lambda values: sum(map(number, values)), 1, 1, _items),
    "mod": BuiltinFunction(lambda a, b: a % b, 2, 2, _same),
    "range": BuiltinFunction(_range_of, 1, 3, _range, counted=True),
    "point": BuiltinFunction(lambda x, y, z: Point(float(x), float(y), float(z)), 3, 3, _lengths),
    "distance": BuiltinFunction(_between(distance), 2, 2, _points(Number(LENGTH))),
    "bearing": BuiltinFunction(_between(bearing), 2, 2, _points(Number(ANGLE))),
}
"""Every function but ``active``, which asks about states and is compiled on its own."""
