"""The operators and functions of SCXML's expressions."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from fsm.values.functions import EvaluationError, bounded, number, power, shown

MATH: Mapping[str, tuple[int, int, Callable[..., Any]]] = {
    "abs": (1, 1, abs),
    "ceil": (1, 1, math.ceil),
    "floor": (1, 1, math.floor),
    "round": (1, 1, lambda x: math.floor(x + 0.5)),
    "sqrt": (1, 1, math.sqrt),
    "sin": (1, 1, math.sin),
    "cos": (1, 1, math.cos),
    "atan2": (2, 2, math.atan2),
    "pow": (2, 2, power),
    "min": (1, 100, lambda *numbers: min(numbers)),
    "max": (1, 100, lambda *numbers: max(numbers)),
}


def truth(value: Any) -> bool:
    """Whether a value is true by ECMAScript's rules."""
    if isinstance(value, (list, dict)):
        return True
    return bool(value)


def text_of(value: Any) -> str:
    """The text that ECMAScript converts a value to."""
    match value:
        case None:
            return "undefined"
        case bool():
            return "true" if value else "false"
        case float() if value.is_integer() and abs(value) < 1e21:
            return str(int(value))
        case list():
            return ",".join(text_of(element) for element in value)
        case dict():
            return "[object Object]"
    return str(value)


def _add(a: Any, b: Any) -> Any:
    if isinstance(a, str) or isinstance(b, str):
        return bounded(text_of(a) + text_of(b))
    return number(a) + number(b)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, bool) is not isinstance(b, bool):
        return False
    return bool(a == b)


def _order(compare: Callable[[Any, Any], bool]) -> Callable[[Any, Any], bool]:
    def ordered(a: Any, b: Any) -> bool:
        if isinstance(a, str) and isinstance(b, str):
            return compare(a, b)
        return compare(number(a), number(b))

    return ordered


def _arithmetic(compute: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    return lambda a, b: compute(number(a), number(b))


LEVELS: Sequence[Mapping[str, Callable[[Any, Any], Any]]] = (
    {"===": _same, "==": _same, "!==": lambda a, b: not _same(a, b)}
    | {"!=": lambda a, b: not _same(a, b)},
    {
        "<": _order(operator.lt),
        "<=": _order(operator.le),
        ">": _order(operator.gt),
        ">=": _order(operator.ge),
    },
    {"+": _add, "-": _arithmetic(operator.sub)},
    {
        "*": _arithmetic(operator.mul),
        "/": _arithmetic(operator.truediv),
        "%": _arithmetic(math.fmod),
    },
)
"""Operators of two sides, from the loosest to the tightest."""
OPERATORS = {sign: function for level in LEVELS for sign, function in level.items()} | {
    "**": _arithmetic(power)
}


def member(value: Any, name: str) -> Any:
    if isinstance(value, dict):
        return value.get(name)
    if name == "length" and isinstance(value, (list, str)):
        return len(value)
    raise EvaluationError(f"{shown(value)} has no '{name}'")


def item(value: Any, index: Any) -> Any:
    if isinstance(value, dict):
        return value.get(index)
    if not isinstance(value, (list, str)):
        raise EvaluationError(f"{shown(value)} has no elements")
    place = number(index)
    return value[int(place)] if place == int(place) and 0 <= place < len(value) else None
