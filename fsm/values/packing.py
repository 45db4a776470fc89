"""Values as JSON and back, exactly: what a running graph holds, in a file.

JSON has no points, tuples or records, and its maps no keys but texts. A map with one key that
begins with ``$`` stands for each of them: ``{"$point": [0.0, 1.5, 3.0]}``. Floats keep every bit,
since Python writes the shortest decimal that reads back as the same number.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from math import isfinite
from types import SimpleNamespace
from typing import Any

from vencejo.errors import UserError
from vencejo.geometry import Point


def pack(value: Any) -> Any:
    """A value in the form JSON can hold. Raises UserError (``unsavable``)."""
    match value:
        case None | bool() | str():
            return value
        case int():
            return int(value)
        case float():
            return float(value) if isfinite(value) else {"$float": str(value)}
        case Point():
            return {"$point": [pack(axis) for axis in value]}
        case list():
            return [pack(element) for element in value]
        case tuple() if not hasattr(value, "_fields"):
            return {"$tuple": [pack(element) for element in value]}
        case Mapping():
            if all(isinstance(key, str) and not key.startswith("$") for key in value):
                return {key: pack(inner) for key, inner in value.items()}
            return {"$map": [[pack(key), pack(inner)] for key, inner in value.items()]}
        case set() | frozenset():
            return {f"${type(value).__name__}": [pack(element) for element in value]}
        case SimpleNamespace():
            return {"$namespace": pack(vars(value))}
    if is_dataclass(value) and not isinstance(value, type):
        kept = {field.name: pack(getattr(value, field.name)) for field in fields(value)}
        return {"$record": [type(value).__module__, type(value).__qualname__, kept]}
    raise UserError(
        "unsavable",
        f"a {type(value).__name__} cannot be saved",
        hint="behaviours keep and publish numbers, texts, points, lists, maps and dataclasses",
    )


def unpack(packed: Any) -> Any:
    """The value that was packed. Raises ValueError for what :func:`pack` does not write."""
    if isinstance(packed, list):
        return [unpack(element) for element in packed]
    if not isinstance(packed, dict):
        return packed
    tag = next(iter(packed), "")
    if not tag.startswith("$"):
        return {key: unpack(inner) for key, inner in packed.items()}
    inside = packed[tag]
    match tag:
        case "$float":
            return float(inside)
        case "$point":
            return Point(*map(unpack, inside))
        case "$tuple":
            return tuple(unpack(element) for element in inside)
        case "$map":
            return {unpack(key): unpack(inner) for key, inner in inside}
        case "$set":
            return {unpack(element) for element in inside}
        case "$frozenset":
            return frozenset(unpack(element) for element in inside)
        case "$namespace":
            return SimpleNamespace(**unpack(inside))
        case "$record":
            return _record(*inside)
    raise ValueError(f"'{tag}' is no kind of value")


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
