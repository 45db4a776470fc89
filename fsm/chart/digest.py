"""A hash of what a mission says: the same for the same words, whatever its layout and comments."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import Any

from vencejo.errors import Where


def digest_of(root: object) -> str:
    """SHA-256 of all that a mission or a document says, in order; places in files do not count."""
    said = sha256()
    _add(root, said.update)
    return said.hexdigest()


def _add(value: Any, update: Any) -> None:
    if isinstance(value, Where):
        return
    if is_dataclass(value):
        update(f"{type(value).__name__}(".encode())
        for field in fields(value):
            if field.name != "file":
                _add(getattr(value, field.name), update)
    elif isinstance(value, dict):
        _add(list(value.items()), update)
    elif isinstance(value, (list, tuple)):
        update(f"{len(value)}[".encode())
        for inner in value:
            _add(inner, update)
    else:
        update(f"{value!r},".encode())
