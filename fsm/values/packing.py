"""Packs the values of a running graph as JSON, and unpacks them, without any loss.

JSON has no points, tuples or records, and its maps no keys but texts. A map with one key that
begins with ``$`` stands for each of them: ``{"$point": [0.0, 1.5, 3.0]}``. Floats keep every bit,
since Python writes the shortest decimal that reads back as the same number.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, is_dataclass
from math import isfinite
from types import NoneType, SimpleNamespace
from typing import Any

from fsm.values.null import NULL, Null
from vencejo.errors import UserError
from vencejo.geometry import Point


def pack(value: Any) -> Any:
    """A value in the form JSON can hold. Raises UserError (``unsavable``)."""
    for class_, packer in _PACKERS:
        if isinstance(value, class_):
            return packer(value)
    if not is_dataclass(value) or isinstance(value, type):
        raise _unsavable(value)
    kept = {field.name: pack(getattr(value, field.name)) for field in fields(value)}
    return {"$record": [type(value).__module__, type(value).__qualname__, kept]}


def _unsavable(value: Any) -> UserError:
    return UserError(
        "unsavable",
        f"a {type(value).__name__} cannot be saved",
        hint="behaviours keep and publish numbers, texts, points, lists, maps and dataclasses",
    )


def _pack_float(value: float) -> Any:
    return float(value) if isfinite(value) else {"$float": str(value)}


def _pack_all(values: Iterable[Any]) -> list[Any]:
    return [pack(value) for value in values]


def _pack_tuple(value: tuple[Any, ...]) -> Any:
    if hasattr(value, "_fields"):
        raise _unsavable(value)  # a named tuple would come back without its names
    return {"$tuple": _pack_all(value)}


def _pack_map(value: Mapping[Any, Any]) -> Any:
    if all(isinstance(key, str) and not key.startswith("$") for key in value):
        return {key: pack(inner) for key, inner in value.items()}
    return {"$map": [[pack(key), pack(inner)] for key, inner in value.items()]}


_PACKERS: tuple[tuple[type | tuple[type, ...], Callable[[Any], Any]], ...] = (
    ((str, bool, NoneType), lambda value: value),  # bool before int, whose subclass it is
    (float, _pack_float),
    (int, int),
    (Point, lambda value: {"$point": _pack_all(value)}),  # before tuple
    (list, _pack_all),
    (tuple, _pack_tuple),
    (Mapping, _pack_map),
    ((set, frozenset), lambda value: {f"${type(value).__name__}": _pack_all(value)}),
    (SimpleNamespace, lambda value: {"$namespace": pack(vars(value))}),
    (Null, lambda value: {"$null": None}),
)
"""Class of the value → packing; the first match counts."""


def unpack(packed: Any) -> Any:
    """The value that was packed. Raises ValueError for what :func:`pack` does not write."""
    if isinstance(packed, list):
        return [unpack(element) for element in packed]
    if not isinstance(packed, dict):
        return packed
    tag = next(iter(packed), "")
    if not tag.startswith("$"):
        return {key: unpack(inner) for key, inner in packed.items()}
    unpacker = _UNPACKERS.get(tag)
    if unpacker is None:
        raise ValueError(f"'{tag}' is no kind of value")
    return unpacker(packed[tag])


def _record(module: str, name: str, kept: dict[str, Any]) -> Any:
    """A record of a class that the graph's behaviours have loaded: nothing is imported or run."""
    found: Any = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    if not (isinstance(found, type) and is_dataclass(found)):
        raise ValueError(f"there is no record '{name}' in '{module}'")
    if kept.keys() != {field.name for field in fields(found)}:
        raise ValueError(f"the record '{name}' has other fields now")
    record = object.__new__(found)
    for field, inner in kept.items():
        object.__setattr__(record, field, unpack(inner))
    return record


_UNPACKERS: Mapping[str, Callable[[Any], Any]] = {
    "$float": float,
    "$point": lambda inside: Point(*map(unpack, inside)),
    "$tuple": lambda inside: tuple(map(unpack, inside)),
    "$map": lambda inside: {unpack(key): unpack(inner) for key, inner in inside},
    "$set": lambda inside: set(map(unpack, inside)),
    "$frozenset": lambda inside: frozenset(map(unpack, inside)),
    "$namespace": lambda inside: SimpleNamespace(**unpack(inside)),
    "$record": lambda inside: _record(*inside),
    "$null": lambda inside: NULL,
}
"""Key of a packed value → unpacking."""
