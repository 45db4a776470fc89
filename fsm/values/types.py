"""The types of the mission language: those of expressions and of the places for values.

A type is a value; two types are compared with :func:`fits`. How a literal is read into a place of
a type stands in :mod:`fsm.expressions.literals`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from math import inf
from types import MappingProxyType
from typing import Any

from vencejo.errors import UserError
from vencejo.geometry import Point
from vencejo.units import ANGLE, LENGTH, SPEED, TIME, Dimension, format_quantity

MAX_NUMBER = 1e300


@dataclass(frozen=True)
class Type:
    """Any type at all; the base of the others."""

    def __str__(self) -> str:
        return "anything"


@dataclass(frozen=True)
class AnyType(Type):
    """A type that is not known before the flight; fits everywhere, and is checked in flight."""


@dataclass(frozen=True)
class NoneType(Type):
    """The type of ``null``, which is compared and assigned, and fits no place of another type."""

    def __str__(self) -> str:
        return "none"


@dataclass(frozen=True)
class Mixed(AnyType):
    """One of several types that are unlike: an element of ``[1 m, 2 s]``."""

    options: tuple[Type, ...] = ()

    def __str__(self) -> str:
        return " or ".join(map(str, self.options))


@dataclass(frozen=True)
class Number(Type):
    """A number of a dimension; ``None`` is a bare number, which fits every dimension."""

    dimension: Dimension | None = None
    min: float = -inf
    max: float = inf
    whole: bool = False

    def __str__(self) -> str:
        if self.whole:
            return "a whole number"
        return "a number" if self.dimension is None else str(self.dimension)


@dataclass(frozen=True)
class Bool(Type):
    def __str__(self) -> str:
        return "true or false"


@dataclass(frozen=True)
class Text(Type):
    choices: tuple[str, ...] = ()
    file: bool = False
    """It is the name of a file that the host reads before the flight."""

    def __str__(self) -> str:
        if self.file:
            return "the name of a file"
        return f"one of {', '.join(self.choices)}" if self.choices else "a text"


@dataclass(frozen=True)
class PointType(Type):
    """A place: a :class:`vencejo.Point`, or a form that is resolved where it is used."""

    def __str__(self) -> str:
        return "a point"


@dataclass(frozen=True)
class HeadingType(Type):
    """An angle, ``keep``, ``travel`` or ``{face: point}``."""

    def __str__(self) -> str:
        return "a heading"


@dataclass(frozen=True)
class ListOf(Type):
    item: Type = field(default_factory=AnyType)
    named: str = "a list"

    def __str__(self) -> str:
        return self.named


@dataclass(frozen=True)
class MapOf(Type):
    """A map; with ``fields`` only these names exist, without any may."""

    fields: Mapping[str, Type] | None = None
    required: frozenset[str] = frozenset()

    def __str__(self) -> str:
        return "a map"

    def __hash__(self) -> int:
        return hash(tuple(self.fields or ()))


ANY = AnyType()
NONE = NoneType()
BARE = Number()
BOOL = Bool()
TEXT = Text()
POINT = PointType()
HEADING = HeadingType()
WAYPOINT = MapOf(
    MappingProxyType(
        {
            "at": POINT,
            "heading": HEADING,
            "speed": Number(SPEED, min=0.01),
            "dwell": Number(TIME, 0.0),
        }
    ),
    required=frozenset({"at"}),
)
ROUTE = ListOf(ANY, "a route")
AREA = ListOf(POINT, "an area")
AREAS = ListOf(AREA)
NAMED: Mapping[str, Type] = MappingProxyType(
    {
        "number": BARE,
        "bool": BOOL,
        "text": TEXT,
        "point": POINT,
        "heading": HEADING,
        "route": ROUTE,
        "area": AREA,
        "list": ListOf(),
        "map": MapOf(),
        "any": ANY,
        "length": Number(LENGTH),
        "time": Number(TIME),
        "angle": Number(ANGLE),
        "speed": Number(SPEED),
    }
)
"""The types a mission may write after ``type:``."""


_FORMS: Mapping[type[Type], tuple[type[Type], ...]] = {
    Text: (Text,),
    MapOf: (MapOf,),
    HeadingType: (Text, MapOf),
    PointType: (Text, ListOf, MapOf),
}
"""The types whose values may be written in a place; what is in them is checked in flight."""


def fits(place: Type, given: Type) -> bool:
    """Whether a value of the type ``given`` may stand in a place of type ``place``, as far as that
    is known before the flight.
    """
    if isinstance(place, Number) and isinstance(given, Number):
        asked, found = place.dimension, given.dimension
        if asked is None or found is None or asked == found:
            return True
        return found == _without_angle(asked)
    if isinstance(place, AnyType) or isinstance(given, AnyType) or place == given:
        return True
    match place, given:
        case HeadingType(), Number():
            return fits(Number(ANGLE), given)
        case ListOf(item=a), ListOf(item=b):
            return fits(a, b)
        case _:
            return isinstance(given, _FORMS.get(type(place), ()))


def _without_angle(dimension: Dimension) -> Dimension:
    """A dimension for which a radian is a plain number: ``v / r`` is a turn rate, ``v / r · t`` an
    angle.
    """
    return dimension._replace(angle=0) if dimension.angle and not dimension.length else dimension


def alike(a: Type, b: Type) -> bool:
    """Whether values of two types may be equal, as far as that is known before the flight."""
    return isinstance(a, NoneType) or isinstance(b, NoneType) or fits(a, b) or fits(b, a)


def join(a: Type, b: Type) -> Type:
    """The type of a value that may be of either type."""
    match a, b:
        case _ if a == b:
            return a
        case Number(), Number() if fits(a, b):
            return Number(b.dimension if a.dimension is None else a.dimension)
        case Number(), Number() if fits(b, a):
            return Number(b.dimension)
        case Text(), Text():
            return TEXT
        case ListOf(), ListOf():
            return ListOf(join(a.item, b.item))
    options = (*_options(a), *_options(b))
    return ANY if ANY in options else Mixed(tuple(sorted(set(options), key=str)))


def _options(type_: Type) -> tuple[Type, ...]:
    return type_.options if isinstance(type_, Mixed) else (type_,)


def join_all(types: Sequence[Type]) -> Type:
    """The type of a value that may be of any of these types; ANY if there are none."""
    return reduce(join, types) if types else ANY


def product(a: Number, b: Number, sign: int) -> Number:
    """The type of a product (``sign`` 1) or quotient (-1).

    Any product with a bare number is bare, and angles count as bare there.
    """
    bare = (None, ANGLE)
    if a.dimension is None or b.dimension is None:
        return BARE
    if sign > 0 and (a.dimension in bare or b.dimension in bare):
        return BARE
    if sign < 0 and b.dimension == ANGLE and a.dimension != ANGLE:
        return BARE
    return Number(a.dimension.times(b.dimension, sign))


def raised(base: Number, exponent: float | None) -> Number | None:
    """The type of a power; None when the dimension has none, like the square root of a length.

    Where the exponent is only known in flight (None) the power is bare; that of an angle always is.
    """
    if base.dimension in (None, ANGLE) or exponent is None:
        return BARE
    assert base.dimension is not None
    powers = [power * exponent for power in base.dimension]
    if not all(power == int(power) for power in powers):
        return None
    return Number(Dimension(*map(int, powers)))


_TYPE_OF_CLASS: tuple[tuple[type, Type], ...] = (
    (bool, BOOL),  # before int, whose subclass it is
    (int, BARE),
    (float, BARE),
    (str, TEXT),
    (Point, POINT),  # before tuple
    (dict, MapOf()),
)


def type_of(value: Any) -> Type:
    """The type of a value at run time."""
    for class_, type_ in _TYPE_OF_CLASS:
        if isinstance(value, class_):
            return type_
    if isinstance(value, (list, tuple)):
        return ListOf(join_all([type_of(item) for item in value]))
    return ANY


def in_bounds(type_: Type, value: Any) -> None:
    """Raise UserError (``out-of-range``) when a number lies outside its type's bounds."""
    if not isinstance(type_, (Number, AnyType)) or not isinstance(value, (int, float)):
        return
    if not abs(value) < MAX_NUMBER:
        raise UserError("out-of-range", "this number is too large")
    if isinstance(type_, AnyType):
        return
    if not type_.min <= value <= type_.max:
        low, high = (format_quantity(bound, type_.dimension) for bound in (type_.min, type_.max))
        allowed = (
            f"{low} … {high}"
            if type_.min > -inf and type_.max < inf
            else f"at least {low}"
            if type_.min > -inf
            else f"at most {high}"
        )
        raise UserError(
            "out-of-range",
            f"{format_quantity(value, type_.dimension)} is out of range; allowed is {allowed}",
        )
    if type_.whole and value != int(value):
        raise UserError("wrong-type", f"{value:g} is no whole number")
