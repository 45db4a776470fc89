"""Values that come from expressions, put into the form that literals of their place have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import nextafter
from types import MappingProxyType
from typing import Any

from fsm.values.functions import EvaluationError, shown
from fsm.values.types import (
    MAX_NUMBER,
    ROUTE,
    WAYPOINT,
    Bool,
    HeadingType,
    ListOf,
    MapOf,
    Number,
    PointType,
    Text,
    Type,
    in_bounds,
)
from vencejo.errors import UserError
from vencejo.geometry import Point
from vencejo.units import LENGTH

LARGEST = nextafter(MAX_NUMBER, 0.0)
HEADING_WORDS = ("keep", "travel")
_LENGTH = Number(LENGTH)
_BARE = Number()
POINT_FORMS: tuple[Mapping[str, Type], ...] = (
    MappingProxyType(
        {"x": _LENGTH, "y": _LENGTH, "z": _LENGTH, "frame": Text(("mission", "world"))}
    ),
    MappingProxyType({"forward": _LENGTH, "left": _LENGTH, "up": _LENGTH}),
    MappingProxyType({"lat": _BARE, "lon": _BARE, "above_home": _LENGTH}),
)


def point_of(values: list[Any]) -> Any:
    if len(values) == 3:
        return Point(float(values[0]), float(values[1]), float(values[2]))
    return {"x": float(values[0]), "y": float(values[1])}


def converted(function: Callable[..., Any], place: Type) -> Callable[..., Any]:
    """``function`` with its value converted for a place: quickly, if it is a number as it should
    be already.
    """
    if not isinstance(place, Number):
        return lambda slots, event: convert(function(slots, event), place)
    kinds = {int} if place.whole else {float} if place.dimension is not None else {int, float}
    low, high = max(place.min, -LARGEST), min(place.max, LARGEST)

    def number(slots: Any, event: Any) -> Any:
        value = function(slots, event)
        as_is = type(value) in kinds and low <= value <= high
        return value if as_is else convert(value, place)

    return number


def convert(value: Any, place: Type) -> Any:
    """A value checked for its place and put into the form literals have there.

    Raises EvaluationError with a sentence when it does not fit.
    """
    match place:
        case Number(dimension=dimension):
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise EvaluationError(f"{shown(value)} is not {place}")
            try:
                in_bounds(place, value)
            except UserError as error:
                raise EvaluationError(error.faults[0].message) from None
            return value if dimension is None or place.whole else float(value)
        case Bool():
            if not isinstance(value, bool):
                raise EvaluationError(f"{shown(value)} is not {place}")
        case Text(choices=choices):
            if not isinstance(value, str) or (choices and value not in choices):
                raise EvaluationError(f"{shown(value)} is not {place}")
        case PointType():
            return _convert_point(value)
        case HeadingType():
            if isinstance(value, dict) and "face" in value:
                return {"face": _convert_point(value["face"])}
            if isinstance(value, bool) or not (
                isinstance(value, (int, float)) or value in HEADING_WORDS
            ):
                raise EvaluationError(f"{shown(value)} is not a heading")
        case ListOf(item=item_type):
            if not isinstance(value, (list, tuple)):
                raise EvaluationError(f"{shown(value)} is not {place}")
            return [
                _convert_waypoint(element) if place == ROUTE else convert(element, item_type)
                for element in value
            ]
        case MapOf(fields=fields, required=required):
            if not isinstance(value, dict):
                raise EvaluationError(f"{shown(value)} is not {place}")
            if fields is None:
                return value
            if not required <= set(value) <= set(fields):
                raise EvaluationError(f"{shown(value)} has other fields than {', '.join(fields)}")
            return {name: convert(element, fields[name]) for name, element in value.items()}
    return value


def _convert_point(value: Any) -> Any:
    if isinstance(value, (Point, str)):
        return value
    if isinstance(value, (list, tuple)) and len(value) in (2, 3):
        return point_of([convert(element, _LENGTH) for element in value])
    if isinstance(value, dict) and any(set(value) <= set(form) for form in POINT_FORMS):
        return value
    raise EvaluationError(f"{shown(value)} is not a point")


def _convert_waypoint(value: Any) -> Any:
    if isinstance(value, dict) and "at" in value:
        return convert(value, WAYPOINT)
    return _convert_point(value)
