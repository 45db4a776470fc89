"""The value ``null`` of ECMAScript, where ``None`` stands for ``undefined``."""

from __future__ import annotations

from enum import Enum


class Null(Enum):
    """The class of :data:`NULL`. In JSON its value is written: ``null``."""

    NULL = None

    def __bool__(self) -> bool:
        return False

    def __str__(self) -> str:
        return "null"


NULL = Null.NULL
