"""The mission language as a JSON Schema (draft 2020-12), for completion and help in editors.

It refuses nothing that the checker takes; what only the checker can know (names, targets, types of
expressions) it lets pass.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Literal

from fsm.host import BehaviorInfo, Parameter, Vocabulary
from fsm.language import value_kinds as kinds
from fsm.language.keys import ANY_STATE, AT, NAME, SMALL_NAME, Key
from fsm.language.value_kinds import Schema, closed, definition, map_of, one_or_many, whole
from fsm.values.types import Bool, HeadingType, ListOf, MapOf, Number, PointType, Text, Type

_TEXT, _TRUTH = kinds.TEXT.schema, kinds.BOOLEAN.schema
_QUANTITY = r"^\s*[-+]?[0-9.]|\$"
_EXPRESSION: Schema = {"type": "string", "pattern": r"\$"}


def mission_schema(vocabulary: Vocabulary) -> Schema:
    """The schema of missions that name this host's behaviours and events, and of fleets."""
    more = {**_host_words(vocabulary), "parameters": _parameters()}
    state = _described(ANY_STATE, more)
    top = {**_described(AT["mission"], more), "type": {"enum": ["parallel"]}}
    graph = {name: top[name] for name in sorted(AT["graph"])}
    needed = _any_of("states", "include")
    behaviors = [_for_behavior(behavior) for _, behavior in sorted(vocabulary.behaviors.items())]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Vencejo mission",
        "type": "object",
        "if": {"required": ["fleet"]},
        "then": _fleet(),
        "else": {**closed(top), **needed, "allOf": behaviors},
        "$defs": {
            "graph": {**closed(graph), **needed, "allOf": behaviors},
            "state": {
                **closed(state),
                "type": ["object", "null"],
                "dependentSchemas": {
                    **dict.fromkeys(("with", "live"), _any_of("do", "include")),
                    "as": {"required": ["do"]},
                    "initial": _any_of("states", "include"),
                    "include": {"not": _any_of("do", "states", "type")},
                },
                "allOf": [
                    _in_type("final"),
                    _in_type("history"),
                    {"if": _is("history"), "then": {"required": ["target"]}},
                    {
                        "if": _is("parallel"),
                        "then": {"required": ["states"]},
                    },
                    *behaviors,
                ],
            },
            "transition": _transition("for"),
            "lasting": _transition(),
            "actions": one_or_many(closed(_described(AT["actions"], {"send": _send()}))),
        },
    }


def _described(keys: Mapping[str, Key], more: Mapping[str, Schema]) -> dict[str, Schema]:
    """The schemas of keys with their help, by name; ``more`` adds to those in the table."""
    return {
        name: {**key.kind.schema, **more.get(name, {}), "description": key.help}
        for name, key in sorted(keys.items())
    }


def _host_words(vocabulary: Vocabulary) -> dict[str, Schema]:
    """The parts of `do` and `on` that name the host's behaviours and events."""
    names = [
        {"const": name, "description": behavior.help.replace("``", "`")}
        for name, behavior in sorted(vocabulary.behaviors.items())
    ]
    return {
        # A mission's own behaviours may have any name.
        "do": {"anyOf": [*names, {"pattern": whole(NAME)}]},
        "on": {"properties": dict.fromkeys(sorted(vocabulary.events), definition("transition"))},
    }


def _any_of(*keys: str) -> Schema:
    return {"anyOf": [{"required": [key]} for key in keys]}


def _is(type_: str) -> Schema:
    return {"properties": {"type": {"const": type_}}, "required": ["type"]}


def _in_type(type_: Literal["final", "history"]) -> Schema:
    """A state of this type has the keys of this type only."""
    return {"if": _is(type_), "then": {"propertyNames": {"enum": sorted(AT[type_])}}}


def _transition(*without: str) -> Schema:
    """A target, a transition in its long form, or a list of alternatives."""
    target = {**_TEXT, "minLength": 1, "description": "the state to go to"}
    keys = sorted(AT["transition"].items())
    long = closed({name: key.kind.schema for name, key in keys if name not in without})
    alternatives = {"type": "array", "minItems": 1, "items": {"anyOf": [target, long]}}
    return {"anyOf": [target, long, alternatives]}


def _send() -> Schema:
    return {
        **closed({name: key.kind.schema for name, key in AT["send"].items()}),
        "required": ["event"],
    }


def _parameters() -> Schema:
    """Each is a default, or the long form."""
    long = closed({name: key.kind.schema for name, key in sorted(AT["parameter"].items())})
    scalars = {"type": ["string", "number", "boolean", "array"]}
    return {"additionalProperties": {"anyOf": [scalars, long]}}


def _fleet() -> Schema:
    vehicle = closed(_described(AT["vehicle"], {}))
    vehicles = map_of(whole(SMALL_NAME), vehicle) | {"minProperties": 1}
    return {**closed(_described(AT["fleet"], {"vehicles": vehicles})), "required": ["vehicles"]}


def _for_behavior(behavior: BehaviorInfo) -> Schema:
    """The rule for states whose ``do`` is this behaviour: its parameters and outcomes."""
    parameters = behavior.parameters.values()
    places = {
        "with": closed({p.name: _parameter(p) for p in parameters}),
        "live": closed({p.name: _parameter(p) for p in parameters if p.live}),
        "on": {
            "properties": {
                word: {"description": _outcome_help(behavior, word)}
                for word in (*behavior.outcomes, "failed", *behavior.events)
            }
        },
    }
    given = [
        {
            "anyOf": [
                {"required": [key], "properties": {key: {"required": [parameter.name]}}}
                for key in ("with", "live")
            ]
        }
        for parameter in parameters
        if parameter.required
    ]
    then: Schema = {"properties": places} | ({"allOf": given} if given else {})
    condition = {"properties": {"do": {"const": behavior.name}}, "required": ["do"]}
    return {"if": condition, "then": then}


def _outcome_help(behavior: BehaviorInfo, word: str) -> str:
    fields = {**behavior.outcomes, **behavior.events}.get(word, {})
    kind = "raises" if "." in word else "ends with"
    shown = ", ".join(f"event.{name}: {type_}" for name, type_ in fields.items())
    return f"{behavior.name} {kind} {word}" + (f" ({shown})" if shown else "")


def _parameter(parameter: Parameter) -> Schema:
    default = "required" if parameter.required else f"default {parameter.default}"
    help_ = f"{parameter.help} ({parameter.type}, {default})".strip()
    return {**value_schema(parameter.type), "description": help_}


_VALUES: dict[type[Type], Schema] = {
    Bool: {"anyOf": [_TRUTH, _EXPRESSION]},
    Text: _TEXT,
    PointType: {"type": ["array", "object", "string", "boolean"]},
    HeadingType: {"type": ["number", "string", "object"]},
    ListOf: {"anyOf": [{"type": "array"}, _EXPRESSION]},
    MapOf: {"anyOf": [{"type": "object"}, _EXPRESSION]},
}


def value_schema(type_: Type) -> Schema:
    """The schema of the values that a place of some type takes, as far as a schema can say it."""
    match type_:
        case Number(min=low, max=high):
            found: Schema = {"type": ["number", "string"], "pattern": _QUANTITY}
            return (
                found
                | ({"minimum": low} if low > -inf else {})
                | ({"maximum": high} if high < inf else {})
            )
        case Text(choices=choices) if choices:
            return {"anyOf": [{"enum": list(choices)}, _EXPRESSION]}
        case _:
            return dict(_VALUES.get(type(type_), {}))
