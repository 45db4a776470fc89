"""The kinds of value that stand behind the keys of the language: how each is read and completed.

A kind names the reader that turns the YAML value into a field of the spec, and the JSON Schema that
tells an editor what may stand there.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

Schema = dict[str, Any]
"""A JSON Schema (draft 2020-12), or the part of one that describes one value."""

Reader = Literal[
    "text",  # a text
    "scalar",  # a text with its place: an expression, or a word that is looked up later
    "scalars",  # one such text, or a list of them
    "boolean",  # true or false
    "choice",  # one of a few words
    "name",  # a text of a certain form, with its place
    "outcome",  # the word of an outcome
    "named",  # a map from names of a certain form to values that are read later
    "define",  # a map from `name` or `name(args)` to expressions
    "actions",  # an action block
    "triggers",  # a map from events, conditions or durations to transitions
    "transition",  # a transition, or a list of alternatives
    "states",  # a map from names to states
    "graphs",  # a map from names to graphs
    "node",  # the YAML value itself, read by whoever compiles it
]


@dataclass(frozen=True, slots=True, eq=False)
class ValueKind:
    """A kind of value: its reader and its JSON Schema."""

    reader: Reader
    schema: Schema
    pattern: re.Pattern[str] | None = None
    """The form of the name, or of each name of the map."""
    options: tuple[str, ...] = ()
    """The words of a choice."""
    hint: str = ""
    """The form of the name in words, for the hint of a fault."""


def one_or_many(item: Schema) -> Schema:
    """An item, or a list of such items."""
    return {"anyOf": [item, {"type": "array", "items": item}]}


def map_of(pattern: str, values: Schema) -> Schema:
    """A map whose keys match a regular expression."""
    return {"type": "object", "propertyNames": {"pattern": pattern}, "additionalProperties": values}


def closed(properties: Mapping[str, Schema]) -> Schema:
    """A map that has these keys and no others."""
    return {"type": "object", "properties": dict(properties), "additionalProperties": False}


def definition(name: str) -> Schema:
    """A reference to one of the schema's own definitions."""
    return {"$ref": f"#/$defs/{name}"}


def whole(pattern: re.Pattern[str]) -> str:
    """A regular expression that the whole text must match, as JSON Schema writes it."""
    return f"^({pattern.pattern})$"


_TEXT: Schema = {"type": ["string", "number", "boolean"]}

TEXT = ValueKind("text", _TEXT)
SCALAR = ValueKind("scalar", _TEXT)
SCALARS = ValueKind("scalars", one_or_many(_TEXT))
BOOLEAN = ValueKind("boolean", {"enum": [True, False, "true", "false"]})
ACTIONS = ValueKind("actions", definition("actions"))


def scalar(schema: Schema) -> ValueKind:
    """A text with its place, of which JSON Schema says more than that."""
    return ValueKind("scalar", schema)


def choice(*options: str) -> ValueKind:
    """One of a few words."""
    return ValueKind("choice", {"enum": list(options)}, options=options)


def name(pattern: re.Pattern[str], hint: str, schema: Schema | None = None) -> ValueKind:
    """A name of a certain form."""
    usual: Schema = {"type": "string", "pattern": whole(pattern)}
    return ValueKind("name", schema or usual, pattern, hint=hint)


def named(pattern: re.Pattern[str], values: Schema | None = None) -> ValueKind:
    """A map from names of a certain form to values."""
    return ValueKind("named", map_of(whole(pattern), values or {}), pattern)


def node(schema: Schema) -> ValueKind:
    """A YAML value that is read by whoever compiles it."""
    return ValueKind("node", schema)
