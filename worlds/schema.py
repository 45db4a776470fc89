"""The JSON Schema of world files, for editors and for programs that write them."""

from __future__ import annotations

from typing import Any

from worlds.loader import FIELDS
from worlds.values import fields_schema


def world_schema() -> dict[str, Any]:
    """What can be said of a world file without its neighbours: keys, types, bounds, words.

    What needs more than one value (names used twice, starts in things, files that are missing) is
    left to the loader.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "World",
        **fields_schema(FIELDS),
    }
