"""Values that the code of a host's behaviours gives: checked, and copied, before a graph has them.

A graph computes with values, logs them as JSON and saves them, in every later period. So each is
brought to plain ones here: numbers that are finite, texts of whole characters, true, false and
none, points, lists, tuples, maps, and records (dataclasses) of those, of limited size. Lists and
maps are copied, so that nobody changes them afterwards; numbers of other libraries become Python's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from numbers import Integral, Real
from operator import attrgetter
from types import MappingProxyType
from typing import Any, TypeVar

from fsm.values.functions import MAX_NESTING, MAX_RESULT, EvaluationError, shown
from fsm.values.types import (
    ANY,
    MAX_NUMBER,
    Bool,
    ListOf,
    MapOf,
    Number,
    PointType,
    Text,
    Type,
)
from vencejo.geometry import Point

Record = TypeVar("Record")


def admitted(value: Any, place: Type = ANY) -> Any:
    """A value in plain form; where it is plain already and cannot change, the very same.

    None fits every place. Raises EvaluationError for what is not of the type of its ``place``, and
    what no graph can hold.
    """
    plain = _Intake().plain(value)
    fits = _FITS.get(type(place))
    if plain is None or fits is None:
        return plain
    if not fits(plain, place):
        raise EvaluationError(f"{shown(plain)} is not {place}")
    if isinstance(place, Number) and place.dimension is not None:
        return float(plain)
    return plain


def record_reader(places: Mapping[str, Type]) -> Callable[[Record], Record]:
    """A function that gives a record (dataclass) with its fields admitted; ``places`` are their
    types. It raises EvaluationError, which names the field.
    """
    numbers = attrgetter(*places) if len(places) > 1 else None
    if not all(type(place) is Number for place in places.values()):
        numbers = None

    def read(record: Record) -> Record:
        if numbers is not None:
            # Most behaviours publish a few numbers, many times a second: one sum tests them all.
            with_all: Any = numbers(record)
            try:
                total = sum(with_all)
            except TypeError:
                total = None
            if type(total) is float and -MAX_NUMBER < total < MAX_NUMBER:
                return record
        taken = {name: _field(getattr(record, name), name, place) for name, place in places.items()}
        if all(taken[name] is getattr(record, name) for name in places):
            return record
        return _record_of(type(record), taken)

    return read


def admitted_fields(given: Mapping[Any, Any], places: Mapping[str, Type]) -> dict[str, Any]:
    """The fields of an event or outcome, admitted; ``places`` are the types of those declared.

    Raises EvaluationError, which names the field.
    """
    for name in given:
        if name not in places:
            known = ", ".join(places) or "none"
            raise EvaluationError(f"there is no field {name!r:.40} (declared: {known})")
    return {str(name): _field(value, name, places[name]) for name, value in given.items()}


def kind_of(value: Any) -> str:
    """The kind of a wrong value, for a message: ``an int``, ``the class Point``."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    name = type(value).__name__
    return f"{'an' if name[:1].lower() in 'aeiou' else 'a'} {name}"


def copied(value: Any) -> Any:
    """The value with its lists and maps copied, for somebody who might change them."""
    if isinstance(value, dict):
        return {key: copied(inner) for key, inner in value.items()}
    return [copied(inner) for inner in value] if type(value) is list else value


def _field(value: Any, name: str, place: Type) -> Any:
    try:
        return admitted(value, place)
    except EvaluationError as error:
        raise EvaluationError(f"{name}: {error}") from None


def _record_of(class_: type[Record], values: Mapping[str, Any]) -> Record:
    """A record with these values, whatever its class does when one is made."""
    record = object.__new__(class_)
    for name, value in values.items():
        object.__setattr__(record, name, value)
    return record


class _Intake:
    """One value on its way in, with the size it has so far."""

    def __init__(self) -> None:
        self._size = 0

    def plain(self, value: Any, depth: int = 0) -> Any:
        """The plain form of a value. Raises EvaluationError."""
        self._size += len(value) if isinstance(value, (str, bytes)) else 8
        if self._size > MAX_RESULT:
            raise EvaluationError("the value is larger than 1 MB")
        if depth > MAX_NESTING:
            raise EvaluationError(f"lists and maps lie more than {MAX_NESTING} deep in each other")
        if value is None or value is True or value is False:
            return value
        for class_, reader in _READERS:
            if isinstance(value, class_):
                return reader(self, value, depth)
        return self._others(value, depth)

    def _others(self, value: Any, depth: int) -> Any:
        """The plain form of a record, and of numpy's numbers that Python does not know as such."""
        if is_dataclass(value) and not isinstance(value, type):
            inside = {
                each.name: self.plain(getattr(value, each.name), depth + 1)
                for each in fields(value)
            }
            return _record_of(type(value), inside)
        if getattr(value, "shape", None) == () and hasattr(value, "item"):
            return self.plain(value.item(), depth + 1)
        raise EvaluationError(f"{kind_of(value)} is no value of a mission")

    def number(self, value: Any, depth: int) -> int | float:
        plain = int(value) if isinstance(value, Integral) else float(value)
        if not -MAX_NUMBER < plain < MAX_NUMBER:
            raise EvaluationError("the number is not finite, or too large")
        return plain

    def text(self, value: str, depth: int) -> str:
        plain = "".join([value])  # of a class of its own it is a plain text then
        if not plain.isascii() and any("\ud800" <= letter <= "\udfff" for letter in plain):
            raise EvaluationError("the text has half a character in it")
        return plain

    def point(self, value: Point, depth: int) -> Point:
        return Point(*(float(self.number(axis, depth)) for axis in value))

    def list(self, value: Any, depth: int) -> list[Any]:
        return [self.plain(element, depth + 1) for element in value]

    def tuple(self, value: Any, depth: int) -> tuple[Any, ...]:
        return tuple([self.plain(element, depth + 1) for element in value])

    def map(self, value: Mapping[Any, Any], depth: int) -> dict[Any, Any]:
        taken = {}
        for key, inner in value.items():
            if isinstance(key, bool) or not isinstance(key, (str, Integral)):
                raise EvaluationError(f"the key of a map is a text, not {kind_of(key)}")
            taken[self.plain(key, depth + 1)] = self.plain(inner, depth + 1)
        return taken


_READERS: tuple[tuple[Any, Callable[[_Intake, Any, int], Any]], ...] = (
    (str, _Intake.text),
    (Real, _Intake.number),
    (Point, _Intake.point),  # before tuple
    (list, _Intake.list),
    (tuple, _Intake.tuple),
    (Mapping, _Intake.map),
)
"""Class of a value → how it is read; the first match counts."""
_FITS: Mapping[type[Type], Callable[[Any, Any], bool]] = MappingProxyType(
    {
        Number: lambda value, place: (
            isinstance(value, int if place.whole else (int, float)) and not isinstance(value, bool)
        ),
        Bool: lambda value, place: isinstance(value, bool),
        Text: lambda value, place: (
            isinstance(value, str) and (not place.choices or value in place.choices)
        ),
        PointType: lambda value, place: isinstance(value, Point),
        ListOf: lambda value, place: isinstance(value, (list, tuple)),
        MapOf: lambda value, place: isinstance(value, dict),
    }
)
"""Type of a place → whether a plain value fits it; all values fit places of other types."""
