"""ECMAScript's conversions, operators and functions (ECMA-262, chapter 7, and 13.5 to 13.15).

``undefined`` is None here, and ``null`` is NULL. Numbers are whole or floats, and whole ones beyond
2⁵³ become floats as in ECMAScript. Inside an expression a number may be NaN or infinite; what an
expression gives may not.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from typing import Any

from fsm.values.functions import EvaluationError, bounded, shown
from fsm.values.null import NULL

Binary = Callable[[Any, Any], Any]
_EXACT = 2**53
_DECIMAL = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_OTHER_BASE = re.compile(r"0[xX][0-9a-fA-F]+|0[oO][0-7]+|0[bB][01]+")
_INDEX = re.compile(r"0|[1-9]\d{0,8}")


def kept(value: Any) -> Any:
    """A value that may leave an expression. Raises EvaluationError for one that may not."""
    if isinstance(value, float) and math.isnan(value):
        raise EvaluationError("the result is no number")
    return bounded(value)


def kind(value: Any) -> str:
    """The type of a value by the name that ``typeof`` gives it."""
    match value:
        case None:
            return "undefined"
        case bool():
            return "boolean"
        case int() | float():
            return "number"
        case str():
            return "string"
    return "object"


# -- conversions ----------------------------------------------------------------------------


def truth(value: Any) -> bool:
    """Whether a value counts as true."""
    if isinstance(value, float) and math.isnan(value):
        return False
    return isinstance(value, (list, dict)) or bool(value)


def number_of(value: Any) -> float:
    """The number that a value is converted to; NaN for what is none."""
    match value:
        case bool():
            return int(value)
        case int() | float():
            return value
        case str():
            return _number_in(value.strip())
        case None:
            return math.nan
    return 0 if value is NULL else _number_in(text_of(value))


def _number_in(text: str) -> float:
    if not text:
        return 0
    if _OTHER_BASE.fullmatch(text):
        return whole(int(text, 0))
    if _DECIMAL.fullmatch(text):
        return whole(int(text)) if text.isdigit() and len(text) < 400 else float(text)
    sign, name = (text[0], text[1:]) if text[0] in "+-" else ("", text)
    return float(sign + "inf") if name == "Infinity" else math.nan


def whole(value: int) -> float:
    """A whole number as ECMAScript has it: beyond 2⁵³ it is rounded to a float."""
    if -_EXACT <= value <= _EXACT:
        return value
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def text_of(value: Any) -> str:
    """The text that a value is converted to."""
    match value:
        case None:
            return "undefined"
        case bool():
            return "true" if value else "false"
        case int() | float():
            return _number_text(value)
        case list():
            return ",".join("" if each in (None, NULL) else text_of(each) for each in value)
        case dict():
            return "[object Object]"
    return str(value)


def _number_text(value: float) -> str:
    """A number in decimal (ECMA-262, Number::toString)."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    if value == int(value) and abs(value) <= _EXACT:
        return str(int(value))
    negative, parts, exponent = Decimal(repr(float(value))).normalize().as_tuple()
    assert isinstance(exponent, int), "the number is finite"
    digits, point = "".join(map(str, parts)), len(parts) + exponent
    if len(digits) <= point <= 21:
        text = digits.ljust(point, "0")
    elif 0 < point <= 21:
        text = f"{digits[:point]}.{digits[point:]}"
    elif -6 < point <= 0:
        text = f"0.{'0' * -point}{digits}"
    else:
        mantissa = f"{digits[0]}.{digits[1:]}" if len(digits) > 1 else digits
        text = f"{mantissa}e{point - 1:+d}"
    return f"-{text}" if negative else text


def _primitive(value: Any) -> Any:
    return value if kind(value) != "object" or value is NULL else text_of(value)


def _units(text: str) -> bytes:
    """The UTF-16 code units of a text, which ECMAScript counts and compares."""
    return text.encode("utf-16-be")


# -- operators ------------------------------------------------------------------------------


def same(a: Any, b: Any) -> bool:
    """``===``: lists and maps are equal only to themselves."""
    if kind(a) != kind(b):
        return False
    return a is b if kind(a) == "object" else bool(a == b)


def equal(a: Any, b: Any) -> bool:
    """``==``, which converts values of unlike types (ECMA-262, IsLooselyEqual)."""
    if a in (None, NULL) or b in (None, NULL):
        return a in (None, NULL) and b in (None, NULL)
    if kind(a) == kind(b):
        return same(a, b)
    a, b = _primitive(a), _primitive(b)
    if isinstance(a, str) and isinstance(b, str):
        return a == b
    return number_of(a) == number_of(b)


def _ordered(compare: Binary) -> Binary:
    def ordered(a: Any, b: Any) -> Any:
        a, b = _primitive(a), _primitive(b)
        if isinstance(a, str) and isinstance(b, str):
            return compare(_units(a), _units(b))
        return compare(number_of(a), number_of(b))

    return ordered


def _add(a: Any, b: Any) -> Any:
    a, b = _primitive(a), _primitive(b)
    if isinstance(a, str) or isinstance(b, str):
        return bounded(text_of(a) + text_of(b))
    return _rounded(number_of(a) + number_of(b))


def _rounded(value: float) -> float:
    return whole(value) if isinstance(value, int) else value


def _arithmetic(compute: Callable[[float, float], float]) -> Binary:
    return lambda a, b: _rounded(compute(number_of(a), number_of(b)))


def _divide(a: float, b: float) -> float:
    if b:
        return a / b
    if not a or math.isnan(a):
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def _remainder(a: float, b: float) -> float:
    try:
        return math.fmod(a, b)
    except ValueError:
        return math.nan


def _power(base: float, exponent: float) -> float:
    if abs(base) == 1 and math.isinf(exponent):
        return math.nan
    try:
        return math.pow(base, exponent)
    except OverflowError:
        return -math.inf if base < 0 and exponent % 2 == 1 else math.inf
    except ValueError:
        return math.inf if base == 0 else math.nan


def _int32(value: Any) -> int:
    found = number_of(value)
    if not math.isfinite(found):
        return 0
    return (int(found) + 2**31) % 2**32 - 2**31


def _bitwise(compute: Callable[[int, int], int]) -> Binary:
    return lambda a, b: _int32(compute(_int32(a), _int32(b)))


def negative(value: Any) -> float:
    """``-x``; the negative of 0 is a zero of its own."""
    found = number_of(value)
    return -found if found else -float(found)


def inverted(value: Any) -> int:
    """``~x``"""
    return ~_int32(value)


LEVELS: Sequence[Mapping[str, Binary]] = (
    {"|": _bitwise(operator.or_)},
    {"^": _bitwise(operator.xor)},
    {"&": _bitwise(operator.and_)},
    {
        "===": same,
        "==": equal,
        "!==": lambda a, b: not same(a, b),
        "!=": lambda a, b: not equal(a, b),
    },
    {
        "<": _ordered(operator.lt),
        "<=": _ordered(operator.le),
        ">": _ordered(operator.gt),
        ">=": _ordered(operator.ge),
    },
    {
        "<<": _bitwise(lambda a, b: a << (b & 31)),
        ">>": _bitwise(lambda a, b: a >> (b & 31)),
        ">>>": lambda a, b: (_int32(a) % 2**32) >> (_int32(b) & 31),
    },
    {"+": _add, "-": _arithmetic(operator.sub)},
    {"*": _arithmetic(operator.mul), "/": _arithmetic(_divide), "%": _arithmetic(_remainder)},
)
"""Operators of two sides, from the loosest to the tightest."""
POWER = _arithmetic(_power)
OPERATORS = {sign: function for level in LEVELS for sign, function in level.items()} | {"**": POWER}


# -- functions ------------------------------------------------------------------------------


def _finite(compute: Callable[..., float]) -> Callable[..., float]:
    """A function of numbers that gives NaN where ``math`` gives an error."""

    def call(*arguments: Any) -> float:
        numbers = [number_of(argument) for argument in arguments]
        try:
            return compute(*numbers)
        except ValueError:
            return math.nan

    return call


def _whole(compute: Callable[[float], int]) -> Callable[..., float]:
    return _finite(lambda x: compute(x) if math.isfinite(x) else x)


def _extreme(choose: Callable[[Sequence[float]], float]) -> Callable[..., float]:
    return _finite(lambda *xs: math.nan if any(map(math.isnan, xs)) else choose(xs))


MATH: Mapping[str, tuple[int, int, Callable[..., float]]] = {
    "abs": (1, 1, _finite(abs)),
    "ceil": (1, 1, _whole(math.ceil)),
    "floor": (1, 1, _whole(math.floor)),
    "round": (1, 1, _whole(lambda x: math.floor(x + 0.5))),
    "sqrt": (1, 1, _finite(math.sqrt)),
    "sin": (1, 1, _finite(math.sin)),
    "cos": (1, 1, _finite(math.cos)),
    "atan2": (2, 2, _finite(math.atan2)),
    "pow": (2, 2, _finite(_power)),
    "min": (1, 100, _extreme(min)),
    "max": (1, 100, _extreme(max)),
}
"""Functions of ``Math``: the least and the most arguments, and what is called."""


# -- fields and elements --------------------------------------------------------------------


def item(value: Any, key: Any) -> Any:
    """``value[key]``, and ``value.key``; ``undefined`` when there is none."""
    name = text_of(key)
    if isinstance(value, dict):
        return value.get(name)
    if isinstance(value, list):
        if name == "length":
            return len(value)
        index = int(name) if _INDEX.fullmatch(name) else len(value)
        return value[index] if index < len(value) else None
    if isinstance(value, str):
        return _letter(value, name)
    raise EvaluationError(f"{text_of(value)} has no '{name}'")


def _letter(text: str, name: str) -> Any:
    units = _units(text)
    if name == "length":
        return len(units) // 2
    index = int(name) if _INDEX.fullmatch(name) else len(units)
    unit = units[2 * index : 2 * index + 2]
    try:
        return unit.decode("utf-16-be") or None
    except UnicodeDecodeError:
        raise EvaluationError(f"element {name} of {shown(text)} is half a letter") from None


def store(value: Any, key: Any, new: Any) -> None:
    """``value[key] = new``. Raises EvaluationError when a list would get a gap."""
    name = text_of(key)
    if isinstance(value, dict):
        value[name] = new
        return
    index = int(name) if _INDEX.fullmatch(name) else None
    if index is None or index > len(value):
        raise EvaluationError(f"a list of {len(value)} has no element {name} that can be set")
    value[index : index + 1] = [new]
