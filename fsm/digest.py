"""A hash of what a mission says: the same for the same words, whatever its layout and comments."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import Any

from fsm.spec import MissionSpec
from vencejo.errors import Where


def digest_of(spec: MissionSpec) -> str:
    """SHA-256 of everything a mission says, in order; places in files do not count."""
    said = sha256()
    _add(spec, said.update)
    return said.hexdigest()


def _add(value: Any, update: Any) -> None:
    if is_dataclass(value):
        update(f"{type(value).__name__}(".encode())
        for field in fields(value):
            inner = getattr(value, field.name)
            if not isinstance(inner, Where) and field.name != "file":
                _add(inner, update)
    elif isinstance(value, dict):
        _add(list(value.items()), update)
    elif isinstance(value, (list, tuple)):
        update(f"{len(value)}[".encode())
        for inner in value:
            _add(inner, update)
    else:
        update(f"{value!r},".encode())
