"""Constant parts of expressions: their values, and the numbers that people write by mistake."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from math import tau
from typing import Any

from fsm.expressions.scope import Scope
from fsm.values.functions import Budget, bounded
from fsm.values.types import HeadingType, Number, Type
from vencejo.errors import Correction, Where
from vencejo.units import ANGLE, TURN_RATE

LARGEST_ANGLE = tau + 0.01
"""The largest bare number that is taken for radians without a word: a full turn, rounded."""


def value_of(code: str, namespace: Mapping[str, Any], budget: Budget) -> Any:
    """The value of code that the translator made and that reads no slots.

    Raises one of :data:`fsm.values.functions.FAILURES` when it has none.
    """
    return bounded(eval(f"lambda b: {code}", dict(namespace))(budget))


def literal(node: ast.expr) -> int | float | None:
    """The number that a part of an expression consists of, perhaps with a sign; None for others."""
    sign = 1
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        sign, node = (-1 if isinstance(node.op, ast.USub) else 1), node.operand
    if not isinstance(node, ast.Constant) or isinstance(node.value, bool):
        return None
    return sign * node.value if isinstance(node.value, (int, float)) else None


def turning_unit(place: Type) -> str | None:
    """The unit in which people mean an angle or turn rate; None for a place of another type."""
    if isinstance(place, Number):
        dimension = place.dimension
        if dimension is None or not dimension.angle:
            return None
        return {ANGLE: "deg", TURN_RATE: "deg/s"}.get(dimension)
    return "deg" if isinstance(place, HeadingType) else None


def warn_of_angle(scope: Scope, number: float, text: str, place: Type, where: Where) -> None:
    """Warn of a bare number that is more than a full turn, where an angle or turn rate stands."""
    unit = turning_unit(place)
    if unit is None or abs(number) <= LARGEST_ANGLE:
        return
    scope.warn(
        "bare-angle",
        f"{text} without a unit is {text} {unit.replace('deg', 'rad')}, "
        f"{abs(number) / tau:.0f} turns" + (" a second" if "/" in unit else ""),
        where,
        Correction(text, f"{text} {unit}"),
    )
