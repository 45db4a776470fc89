"""Plug-ins: what installed packages offer as entry points, by group and name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType


@cache
def plugins(group: str) -> Mapping[str, EntryPoint]:
    """The entry points of a group by name; nothing is imported before one is loaded.

    Found once in a process: to look through all installed packages takes a millisecond.
    """
    return MappingProxyType({point.name: point for point in entry_points(group=group)})
