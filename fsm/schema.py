"""The mission language as a JSON Schema (draft 2020-12), for completion and help in editors.

It refuses nothing that the checker takes; what only the checker can know (names, targets, types of
expressions) it lets pass.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

from fsm.compiler.parameters import PARAMETER_KEYS
from fsm.fleet import FLEET_KEYS, VEHICLE_KEYS
from fsm.host import BehaviorInfo, Parameter, Vocabulary
from fsm.language.keys import (
    ACTIONS,
    EVENT_NAME,
    FINAL_KEYS,
    GRAPH_KEYS,
    HISTORY_KEYS,
    NAME,
    ROOT_KEYS,
    SMALL_NAME,
    STATE_KEYS,
    TRANSITION_KEYS,
    TRIGGER,
)
from fsm.values.types import NAMED, Bool, HeadingType, ListOf, MapOf, Number, PointType, Text, Type

Schema = dict[str, Any]

_ANY_STATE = STATE_KEYS | FINAL_KEYS | HISTORY_KEYS
_NAME, _STATE, _EVENT, _TRIGGER = (
    f"^({form.pattern})$" for form in (NAME, SMALL_NAME, EVENT_NAME, TRIGGER)
)
_TEXT: Schema = {"type": ["string", "number", "boolean"]}
_QUANTITY = r"^\s*[-+]?[0-9.]|\$"
_EXPRESSION: Schema = {"type": "string", "pattern": r"\$"}
_TRUTH: Schema = {"enum": [True, False, "true", "false"]}
_ROOT_HELP = {
    "mission": "The mission's name: letters, digits, - and _.",
    "description": "One sentence that says what it does.",
    "world": "The world it flies in by default: a name, or a .yaml file beside the mission.",
    "language": "Version of the language.",
    "uses": "Python files beside the mission, with behaviours of its own.",
    "places": "Named points of this mission.",
    "parameters": "Values that can be given with -p name=value: a default, or a map.",
    "events": "Events from outside, each with its fields and their types.",
    "priority": "Which of nested states is asked first.",
    "graphs": "Graphs kept in this file, to `include` in states.",
}
_FLEET_HELP = {
    "fleet": "The fleet's name.",
    "description": "One sentence that says what they do.",
    "world": "The world they fly in.",
    "vehicles": "Each vehicle with its mission and the parameters of that.",
    "until": "A condition that ends the run: an expression over vehicles and `time`.",
}
_ACTION_HELP = {
    "set": "Assign variables; all right sides first.",
    "append": "Add a value to the end of a list.",
    "raise": "An event of this graph, heard at once.",
    "send": "An event that is heard in a later period, or by another vehicle.",
    "cancel": "The id of a delayed `send` that is not to come.",
    "log": "A line in the run's record.",
    "call": "A Python function beside the mission, marked with @action.",
}
_STATE_HELP = {
    "states": "The states inside, in order; the first is initial.",
    "initial": "The state inside that is entered first.",
    "type": "parallel: all states inside at once; final: an end; history: back to where it was.",
    "data": "Variables; they begin anew whenever the state is entered.",
    "define": "Named expressions, perhaps with arguments.",
    "entry": "Actions on entering.",
    "exit": "Actions on leaving.",
    "throughout": "Actions in every mission period.",
    "include": "A graph inside this state: a file beside this one, or a name under `graphs`.",
    "breakpoint": "Stop here under `drone-cli step`.",
    "do": "The behaviour that runs while the state is active.",
    "with": "Parameters of the behaviour, evaluated once at its start.",
    "live": "Parameters of the behaviour, evaluated before each of its steps.",
    "as": "The name its published values are read under.",
    "on": "Outcomes (a word) and events (with a dot), and what is done then.",
    "when": "Conditions, each taken when it becomes true.",
    "after": "Durations since entry.",
    "always": "Taken at once: for choices.",
    "description": "What the state is for.",
    "deep": "Whether states further inside are remembered too.",
    "target": "Where to go the first time.",
    "outcome": "The outcome that the state around it ends with; `done` unless it is given.",
    "output": "The fields of `event` outside.",
}


def mission_schema(vocabulary: Vocabulary) -> Schema:
    """The schema of missions that name this host's behaviours and events, and of fleets."""
    state = _properties(vocabulary)
    root = {**state, **_root_properties(), "type": {"enum": ["parallel"]}}
    needed = _any_of("states", "include")
    behaviors = [_for_behavior(behavior) for _, behavior in sorted(vocabulary.behaviors.items())]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Vencejo mission",
        "type": "object",
        "if": {"required": ["fleet"]},
        "then": _fleet(),
        "else": {
            **_closed({key: root[key] for key in sorted(ROOT_KEYS | STATE_KEYS)}),
            **needed,
            "allOf": behaviors,
        },
        "$defs": {
            "graph": {
                **_closed({key: root[key] for key in sorted(GRAPH_KEYS | STATE_KEYS)}),
                **needed,
                "allOf": behaviors,
            },
            "state": {
                **_closed({key: state[key] for key in sorted(_ANY_STATE)}),
                "type": ["object", "null"],
                "dependentSchemas": {
                    **dict.fromkeys(("with", "live"), _any_of("do", "include")),
                    "as": {"required": ["do"]},
                    "initial": _any_of("states", "include"),
                    "include": {"not": _any_of("do", "states", "type")},
                },
                "allOf": [
                    _only("final", FINAL_KEYS),
                    _only("history", HISTORY_KEYS),
                    {"if": _is("history"), "then": {"required": ["target"]}},
                    {
                        "if": _is("parallel"),
                        "then": {"required": ["states"]},
                    },
                    *behaviors,
                ],
            },
            "transition": _transition(TRANSITION_KEYS - {"for"}),
            "lasting": _transition(TRANSITION_KEYS),
            "actions": _one_or_many(_closed(_actions())),
        },
    }


def _closed(properties: Mapping[str, Schema]) -> Schema:
    return {"type": "object", "properties": dict(properties), "additionalProperties": False}


def _map(names: str, values: Schema) -> Schema:
    return {"type": "object", "propertyNames": {"pattern": names}, "additionalProperties": values}


def _ref(name: str) -> Schema:
    return {"$ref": f"#/$defs/{name}"}


def _one_or_many(item: Schema) -> Schema:
    return {"anyOf": [item, {"type": "array", "items": item}]}


def _is(type_: str) -> Schema:
    return {"properties": {"type": {"const": type_}}, "required": ["type"]}


def _only(type_: str, keys: frozenset[str]) -> Schema:
    return {"if": _is(type_), "then": {"propertyNames": {"enum": sorted(keys)}}}


def _any_of(*keys: str) -> Schema:
    return {"anyOf": [{"required": [key]} for key in keys]}


def _actions() -> dict[str, Schema]:
    event = {"type": "string", "pattern": _EVENT}
    send = {"event": event, "to": {"type": "string", "pattern": _STATE}, "with": {"type": "object"}}
    shapes: dict[str, Schema] = {
        "set": _map(_NAME, {}),
        "append": _map(_NAME, {}),
        "raise": {"anyOf": [event, {**_map(_EVENT, {}), "minProperties": 1, "maxProperties": 1}]},
        "send": {**_closed({**send, "delay": {}, "id": _TEXT}), "required": ["event"]},
        "log": _TEXT,
        "cancel": _TEXT,
        "call": {"anyOf": [_TEXT, {"type": "object", "minProperties": 1, "maxProperties": 1}]},
    }
    return {
        action: {**shapes[action], "description": _ACTION_HELP[action]}
        for action in sorted(ACTIONS)
    }


def _transition(keys: frozenset[str]) -> Schema:
    values: dict[str, Schema] = {
        "target": _one_or_many(_TEXT),
        "guard": _TEXT,
        "actions": _ref("actions"),
        "for": _TEXT,
        "reenter": _TRUTH,
        "name": _TEXT,
        "description": _TEXT,
    }
    target = {**_TEXT, "minLength": 1, "description": "the state to go to"}
    long: Schema = _closed({key: values[key] for key in sorted(keys)})
    alternatives = {"type": "array", "minItems": 1, "items": {"anyOf": [target, long]}}
    return {"anyOf": [target, long, alternatives]}


def _fleet() -> Schema:
    vehicle: dict[str, Schema] = {
        "mission": {**_TEXT, "description": "The file of its mission, beside this one."},
        "with": {"type": "object", "description": "Parameters of that mission."},
    }
    vehicle = {key: vehicle[key] for key in sorted(VEHICLE_KEYS)}
    found: dict[str, Schema] = dict.fromkeys(sorted(FLEET_KEYS), _TEXT)
    found["vehicles"] = _map(_STATE, _closed(vehicle) | {"required": ["mission"]})
    found["vehicles"]["minProperties"] = 1
    return {
        **_closed({key: {**found[key], "description": _FLEET_HELP[key]} for key in found}),
        "required": ["vehicles"],
    }


def _root_properties() -> dict[str, Schema]:
    types = {"enum": sorted(NAMED)}
    long: dict[str, Schema] = {key: {} for key in sorted(PARAMETER_KEYS)}
    long["type"] = types
    scalars = {"type": ["string", "number", "boolean", "array"]}
    found: dict[str, Schema] = {
        "mission": {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_-]*$"},
        "description": _TEXT,
        "world": _TEXT,
        "language": {"enum": [1, "1"]},
        "uses": _one_or_many(_TEXT),
        "places": _map(_NAME, {}),
        "parameters": _map(_NAME, {"anyOf": [scalars, _closed(long)]}),
        "events": _map(_EVENT, {"type": ["object", "null"], "additionalProperties": types}),
        "priority": {"enum": ["inner", "outer"]},
        "graphs": _map(_NAME, _ref("graph")),
    }
    return {key: {**schema, "description": _ROOT_HELP[key]} for key, schema in found.items()}


def _properties(vocabulary: Vocabulary) -> dict[str, Schema]:
    actions, transitions = _ref("actions"), _ref("transition")
    names = [
        {"const": name, "description": behavior.help.replace("``", "`")}
        for name, behavior in sorted(vocabulary.behaviors.items())
    ]
    events = dict.fromkeys(sorted(vocabulary.events), transitions)
    found: dict[str, Schema] = {
        "states": _map(_STATE, _ref("state")),
        "initial": _TEXT,
        "type": {"enum": ["parallel", "final", "history"]},
        "data": _map(_NAME, {}),
        "define": _map(r"^[A-Za-z]\w*\s*(\([^()]*\))?$", _TEXT),
        "entry": actions,
        "exit": actions,
        "throughout": actions,
        "include": {"type": "string", "minLength": 1},
        "breakpoint": _TRUTH,
        # A mission's own behaviours may have any name.
        "do": {"type": "string", "anyOf": [*names, {"pattern": _NAME}]},
        "with": _map(_NAME, {}),
        "live": _map(_NAME, {}),
        "as": {"type": "string", "pattern": _NAME},
        "on": {**_map(_TRIGGER, transitions), "properties": events},
        "when": {"type": "object", "additionalProperties": _ref("lasting")},
        "after": {"type": "object", "additionalProperties": transitions},
        "always": transitions,
        "description": _TEXT,
        "deep": _TRUTH,
        "target": _TEXT,
        "outcome": {"type": ["string", "boolean"], "pattern": _STATE},
        "output": _map(_NAME, {}),
    }
    return {key: {**schema, "description": _STATE_HELP[key]} for key, schema in found.items()}


def _for_behavior(behavior: BehaviorInfo) -> Schema:
    """What holds in a state whose ``do`` is this behaviour."""
    parameters = behavior.parameters.values()
    places = {
        "with": _closed({p.name: _parameter(p) for p in parameters}),
        "live": _closed({p.name: _parameter(p) for p in parameters if p.live}),
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


def value_schema(type_: Type) -> Schema:
    """What may stand in a place of a type, as far as a schema can say it."""
    match type_:
        case Number(min=low, max=high):
            found: Schema = {"type": ["number", "string"], "pattern": _QUANTITY}
            return (
                found
                | ({"minimum": low} if low > -inf else {})
                | ({"maximum": high} if high < inf else {})
            )
        case Bool():
            return {"anyOf": [_TRUTH, _EXPRESSION]}
        case Text(choices=choices):
            return {"anyOf": [{"enum": list(choices)}, _EXPRESSION]} if choices else dict(_TEXT)
        case PointType():
            return {"type": ["array", "object", "string", "boolean"]}
        case HeadingType():
            return {"type": ["number", "string", "object"]}
        case ListOf():
            return {"anyOf": [{"type": "array"}, _EXPRESSION]}
        case MapOf():
            return {"anyOf": [{"type": "object"}, _EXPRESSION]}
        case _:
            return {}
