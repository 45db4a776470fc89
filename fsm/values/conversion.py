"""Converts the values of expressions to the form that literals have in the same place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import nextafter
from types import MappingProxyType
from typing import Any

from fsm.values.functions import EvaluationError, shown
from fsm.values.types import (
    MAX_NUMBER,
    POINT,
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
ABOVE_GROUND = "above_ground"
"""The key of a point's height above the terrain straight below it."""
POINT_FORMS: tuple[Mapping[str, Type], ...] = (
    MappingProxyType(
        {"x": _LENGTH, "y": _LENGTH, "z": _LENGTH, "frame": Text(("mission", "world"))}
    ),
    MappingProxyType({"forward": _LENGTH, "left": _LENGTH, "up": _LENGTH}),
    MappingProxyType({"lat": _BARE, "lon": _BARE, "above_home": _LENGTH}),
    MappingProxyType(
        {"x": _LENGTH, "y": _LENGTH, ABOVE_GROUND: _LENGTH, "frame": Text(("mission", "world"))}
    ),
    MappingProxyType({"forward": _LENGTH, "left": _LENGTH, ABOVE_GROUND: _LENGTH}),
    MappingProxyType({"lat": _BARE, "lon": _BARE, ABOVE_GROUND: _LENGTH}),
)


def point_of(values: list[Any]) -> Any:
    """A point of three coordinates in metres, or the map of two, whose third is known in flight."""
    if len(values) == 3:
        return Point(float(values[0]), float(values[1]), float(values[2]))
    return {"x": float(values[0]), "y": float(values[1])}


def converted(function: Callable[..., Any], place: Type) -> Callable[..., Any]:
    """``function`` with its value converted for a place; fast where it is a number that fits."""
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
    """The value in the form that literals have in its place.

    Raises EvaluationError with a sentence when it does not fit.
    """
    converter = _CONVERTERS.get(type(place))
    return value if converter is None else converter(value, place)


def _misfit(value: Any, place: Type) -> EvaluationError:
    return EvaluationError(f"{shown(value)} is not {place}")


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _convert_number(value: Any, place: Number) -> Any:
    if not _is_number(value):
        raise _misfit(value, place)
    try:
        in_bounds(place, value)
    except UserError as error:
        raise EvaluationError(error.faults[0].message) from None
    return value if place.dimension is None or place.whole else float(value)


def _convert_bool(value: Any, place: Bool) -> Any:
    if not isinstance(value, bool):
        raise _misfit(value, place)
    return value


def _convert_text(value: Any, place: Text) -> Any:
    if not isinstance(value, str) or (place.choices and value not in place.choices):
        raise _misfit(value, place)
    return value


def _convert_heading(value: Any, place: HeadingType) -> Any:
    if isinstance(value, dict) and "face" in value:
        return {"face": _convert_point(value["face"], POINT)}
    if not (_is_number(value) or value in HEADING_WORDS):
        raise _misfit(value, place)
    return value


def _convert_list(value: Any, place: ListOf) -> Any:
    if not isinstance(value, (list, tuple)):
        raise _misfit(value, place)
    if place == ROUTE:
        return [_convert_waypoint(element) for element in value]
    return [convert(element, place.item) for element in value]


def _convert_map(value: Any, place: MapOf) -> Any:
    if not isinstance(value, dict):
        raise _misfit(value, place)
    fields = place.fields
    if fields is None:
        return value
    if not place.required <= set(value) <= set(fields):
        raise EvaluationError(f"{shown(value)} has other fields than {', '.join(fields)}")
    return {name: convert(element, fields[name]) for name, element in value.items()}


def _convert_point(value: Any, place: PointType) -> Any:
    if isinstance(value, (Point, str)):
        return value
    if isinstance(value, (list, tuple)) and len(value) in (2, 3):
        return point_of([convert(element, _LENGTH) for element in value])
    if isinstance(value, dict) and any(set(value) <= set(form) for form in POINT_FORMS):
        return value
    raise _misfit(value, place)


def _convert_waypoint(value: Any) -> Any:
    if isinstance(value, dict) and "at" in value:
        return convert(value, WAYPOINT)
    return _convert_point(value, POINT)


_CONVERTERS: Mapping[type[Type], Callable[[Any, Any], Any]] = {
    Number: _convert_number,
    Bool: _convert_bool,
    Text: _convert_text,
    PointType: _convert_point,
    HeadingType: _convert_heading,
    ListOf: _convert_list,
    MapOf: _convert_map,
}
"""Type of the place → conversion; values in places of other types stay as they are."""
