"""Parameters, outcomes and published values of behaviours, declared as annotated classes."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from math import inf
from operator import or_
from typing import Any, ClassVar

from behaviors.path_file import PathFile
from fsm.host import Parameter
from fsm.values.types import (
    ANY,
    AREA,
    AREAS,
    BOOL,
    HEADING,
    POINT,
    ROUTE,
    ListOf,
    Number,
    Text,
    Type,
)
from vencejo.geometry import Point
from vencejo.units import UNITS, Dimension, in_unit


@dataclass(frozen=True, slots=True)
class Face:
    """A heading that keeps the nose towards a point (mission frame)."""

    point: Point


Heading = float | str | Face
"""Radians counter-clockwise from east, ``keep``, ``travel`` or :class:`Face`."""


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A point of a route; None leaves a setting to the route's own."""

    at: Point
    heading: Heading | None = None
    speed: float | None = None
    dwell: float | None = None


Route = list[Waypoint]
"""Points in order, mission frame."""
Area = list[Point]
"""The corners of a polygon, mission frame."""
Areas = list[Area]
"""Several polygons."""

_TYPES: dict[Any, Type] = {
    bool: BOOL,
    str: Text(),
    int: Number(whole=True),
    float: Number(),
    Point: POINT,
    PathFile: Text(file=True),
    Heading: HEADING,
    Route: ROUTE,
    Area: AREA,
    Areas: AREAS,
    Any: ANY,
    list: ListOf(),
    list[Any]: ListOf(),
}


@dataclass(frozen=True)
class ParamSpec:
    """The declaration of one parameter in a class body. Bounds and default are in ``unit``."""

    default: Any
    required: bool
    live: bool
    unit: str
    min: float
    max: float
    choices: tuple[str, ...]
    help: str
    names: str


_MISSING: Any = object()


def param(
    default: Any = _MISSING,
    *,
    unit: str = "",
    min: float = -inf,
    max: float = inf,
    choices: tuple[str, ...] = (),
    help: str = "",
    names: str = "",
) -> Any:
    """Declare a parameter of ``with``; without a default it is required. Bounds are in ``unit``.

    One that ``names="camera"`` is the name of a camera, which the vehicle then needs and which is
    the active one when the behaviour begins.
    """
    required = default is _MISSING
    default = None if required else default
    return ParamSpec(default, required, False, unit, min, max, choices, help, names)


def live(default: Any = _MISSING, **settings: Any) -> Any:
    """Declare a parameter that may also stand under ``live``; see :func:`param`."""
    return dataclasses.replace(param(default, **settings), live=True)


def value(unit: str = "", default: Any = 0.0) -> Any:
    """Declare a field, with its unit, of published values, of an event or of an outcome."""
    return dataclasses.field(default=default, metadata={"unit": unit})


def _dimension(unit: str) -> Dimension | None:
    if unit and unit not in UNITS:
        raise ValueError(f"there is no unit '{unit}'")
    return UNITS[unit][1] if unit else None


def _si(number: Any, unit: str) -> Any:
    plain = isinstance(number, (int, float)) and not isinstance(number, bool)
    return in_unit(float(number), unit) if unit and plain and abs(number) < inf else number


def type_of(annotation: Any) -> Type:
    """The language's type for a Python annotation; ANY for one that it does not know."""
    options = typing.get_args(annotation)
    if type(None) in options:
        annotation = reduce(or_, (option for option in options if option is not type(None)))
    return _TYPES.get(annotation) or _TYPES.get(typing.get_origin(annotation), ANY)


def _type(annotation: Any, spec: ParamSpec) -> Type:
    type_ = type_of(annotation)
    if isinstance(type_, Number):
        low, high = _si(spec.min, spec.unit), _si(spec.max, spec.unit)
        return Number(_dimension(spec.unit), low, high, type_.whole)
    return Text(spec.choices) if type_ == Text() else type_


class BehaviorParams:
    """The base of a behaviour's ``Params``: annotated attributes set to param() or live()."""

    _declared: ClassVar[Mapping[str, Parameter]] = {}

    def __init_subclass__(cls) -> None:
        hints = typing.get_type_hints(cls)
        declared = dict(cls._declared)
        for name, spec in list(vars(cls).items()):
            if isinstance(spec, ParamSpec):
                type_ = _type(hints.get(name, Any), spec)
                declared[name] = Parameter(
                    name,
                    type_,
                    _si(spec.default, spec.unit),
                    spec.required,
                    spec.live,
                    spec.help,
                    spec.unit,
                    spec.names,
                )
                setattr(cls, name, declared[name].default)
        cls._declared = declared

    def __init__(self, **values: Any) -> None:
        for name, given in values.items():
            setattr(self, name, given)


def parameters_of(params: type[BehaviorParams]) -> Mapping[str, Parameter]:
    """The declared parameters, in order."""
    return params._declared


def fields_of(record: type | None) -> dict[str, Type]:
    """The fields of a dataclass of outcomes, events or published values, as language types."""
    if record is None:
        return {}
    hints = typing.get_type_hints(record)
    fields: dict[str, Type] = {}
    for declared in dataclasses.fields(record):
        type_ = type_of(hints[declared.name])
        if isinstance(type_, Number):
            type_ = Number(_dimension(declared.metadata.get("unit", "")))
        fields[declared.name] = type_
    return fields
