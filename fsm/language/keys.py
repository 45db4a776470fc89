"""The keys of the mission language: where each may stand, how its value is read, what it means.

The table :data:`KEYS` is the reference of the language. The reader, the checks of parameters,
`send` and fleets, the JSON Schema and the drawings take what they know of a key from its row. A new
key is a row here, the field of :mod:`fsm.language.spec` that it is read into, a line in
docs/language.md, and the code that does what it says.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from keyword import iskeyword
from typing import Literal, get_args

from fsm.language import value_kinds as kinds
from fsm.language.value_kinds import Schema, ValueKind, definition, map_of, whole
from fsm.values.types import NAMED

# -- names -----------------------------------------------------------------------------------

SMALL_NAME = re.compile(r"[a-z][a-z0-9_]*")
"""The form of the names of states, outcomes and vehicles."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
"""The form of the names that expressions use: parameters, data, places."""
MISSION_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
EVENT_NAME = re.compile(r"[a-z][a-z0-9_]*(\.[a-z0-9_]+)+")
TRIGGER = re.compile(r"\*|[a-z][a-z0-9_]*(\.[a-z0-9_]+)*(\.\*)?")
"""The form of the keys of `on`: an outcome, an event, a family of events, or all events."""

# -- the table -------------------------------------------------------------------------------

Place = Literal[
    "mission",  # the top of a mission's file
    "graph",  # the top of a graph kept under `graphs`
    "state",  # a state with states inside, or with none
    "final",  # a state of `type: final`
    "history",  # a state of `type: history`
    "transition",  # the long form of a transition
    "actions",  # an action block
    "send",  # what stands behind the action `send`
    "parameter",  # the long form of a declared parameter
    "fleet",  # the top of a fleet's file
    "vehicle",  # a vehicle of a fleet
]

MISSION: tuple[Place, ...] = ("mission",)
GRAPH: tuple[Place, ...] = ("mission", "graph")
STATE: tuple[Place, ...] = ("mission", "graph", "state")
FINAL: tuple[Place, ...] = ("final",)
HISTORY: tuple[Place, ...] = ("history",)
TRANSITION: tuple[Place, ...] = ("transition",)
BLOCK: tuple[Place, ...] = ("actions",)
SEND: tuple[Place, ...] = ("send",)
PARAMETER: tuple[Place, ...] = ("parameter",)
FLEET: tuple[Place, ...] = ("fleet",)
VEHICLE: tuple[Place, ...] = ("vehicle",)


@dataclass(frozen=True, slots=True, eq=False)
class Key:
    """A key of the language. One name may have several rows, in different places."""

    name: str
    places: tuple[Place, ...]
    kind: ValueKind
    help: str
    own_field: str = ""
    """The field of the spec that it is read into, where that has another name."""
    apart: bool = False
    """The reader has code of its own for it, since its value is not simply a field."""
    label: str = ""
    """The word that drawings write before its value."""

    @property
    def field(self) -> str:
        """The field of the spec that its value is read into."""
        return self.own_field or (f"{self.name}_" if iskeyword(self.name) else self.name)


_EVENT: Schema = {"type": "string", "pattern": whole(EVENT_NAME)}
_ONE_EVENT: Schema = {**map_of(whole(EVENT_NAME), {}), "minProperties": 1, "maxProperties": 1}
_ONE_CALL: Schema = {"type": "object", "minProperties": 1, "maxProperties": 1}
_TYPES: Schema = {
    "anyOf": [{"enum": sorted(NAMED)}, {"type": "array", "minItems": 1, "maxItems": 1}]
}
_FIELDS: Schema = {"type": ["object", "null"], "additionalProperties": _TYPES}
_MAP: Schema = {"type": "object"}
_ANY: Schema = {}
_START: Schema = {
    "type": "object",
    "properties": {"at": {"type": "array", "minItems": 2, "maxItems": 3}, "heading": _ANY},
    "required": ["at"],
    "additionalProperties": False,
}
_COLOR: Schema = {"type": ["string", "array"]}
_TEXT = kinds.TEXT.schema

_MISSION_NAME = kinds.name(
    MISSION_NAME,
    "letters, digits, - and _",
    {"type": "string", "pattern": f"^{MISSION_NAME.pattern}$"},
)
_OUTCOME = ValueKind(
    "outcome",
    {"type": ["string", "boolean"], "pattern": whole(SMALL_NAME)},
    SMALL_NAME,
    hint="an outcome is one small word",
)
_DEFINE = ValueKind("define", map_of(r"^[A-Za-z]\w*\s*(\([^()]*\))?$", _TEXT))
_STATES = ValueKind("states", map_of(whole(SMALL_NAME), definition("state")), SMALL_NAME)
_GRAPHS = ValueKind("graphs", map_of(whole(NAME), definition("graph")), NAME)
_ON = ValueKind("triggers", map_of(whole(TRIGGER), definition("transition")), TRIGGER)
_WHEN = ValueKind("triggers", {"type": "object", "additionalProperties": definition("lasting")})
_AFTER = ValueKind("triggers", {"type": "object", "additionalProperties": definition("transition")})
_ALWAYS = ValueKind("transition", definition("transition"))

# The order is the one in which keys are read, and so that of the mistakes found in them.
# fmt: off
KEYS: tuple[Key, ...] = (
    # The top of a mission's file; some of it stands in a kept graph too.
    Key("mission", MISSION, _MISSION_NAME,
        "The mission's name: letters, digits, - and _.", apart=True),
    Key("language", MISSION, kinds.node({"enum": [1, "1"]}),
        "Version of the language.", apart=True),
    Key("priority", MISSION, kinds.choice("inner", "outer"),
        "Which of nested states is asked first.", apart=True),
    Key("description", GRAPH, kinds.TEXT,
        "One sentence that says what it does."),
    Key("world", MISSION, kinds.SCALAR,
        "The world it flies in by default: a name, or a .yaml file beside the mission."),
    Key("uses", MISSION, kinds.SCALARS,
        "Python files beside the mission, with behaviours of its own."),
    Key("places", GRAPH, kinds.named(NAME),
        "Named points of this mission."),
    Key("parameters", GRAPH, kinds.named(NAME),
        "Values that can be given with -p name=value: a default, or a map."),
    Key("events", GRAPH, kinds.named(EVENT_NAME, _FIELDS),
        "Events from outside, each with its fields and their types."),
    Key("graphs", MISSION, _GRAPHS,
        "Graphs kept in this file, to `include` in states.", apart=True),

    # Any state; the mission and a kept graph are states too.
    Key("type", (*STATE, *FINAL, *HISTORY), kinds.choice("parallel", "final", "history"),
        "parallel: all states inside at once; final: an end; history: back to where it was.",
        apart=True),
    Key("states", STATE, _STATES,
        "The states inside, in order; the first is initial.", apart=True),
    Key("on", STATE, _ON,
        "Outcomes (a word) and events (with a dot), and what is done then.", apart=True),
    Key("when", STATE, _WHEN,
        "Conditions, each taken when it becomes true.", apart=True, label="when"),
    Key("after", STATE, _AFTER,
        "Durations since entry.", apart=True, label="after"),
    Key("always", STATE, _ALWAYS,
        "Taken at once: for choices.", apart=True, label="always"),
    Key("initial", STATE, kinds.SCALAR,
        "The state inside that is entered first."),
    Key("description", ("state", *FINAL, *HISTORY), kinds.TEXT,
        "What the state is for."),
    Key("data", STATE, kinds.named(NAME),
        "Variables; they begin anew whenever the state is entered."),
    Key("define", STATE, _DEFINE,
        "Named expressions, perhaps with arguments."),
    Key("entry", (*STATE, *FINAL), kinds.ACTIONS,
        "Actions on entering.", label="entry"),
    Key("exit", STATE, kinds.ACTIONS,
        "Actions on leaving.", label="exit"),
    Key("throughout", STATE, kinds.ACTIONS,
        "Actions in every mission period.", label="throughout"),
    Key("do", STATE, kinds.scalar({"type": "string"}),
        "The behaviour that runs while the state is active.", label="do"),
    Key("with", STATE, kinds.named(NAME),
        "Parameters of the behaviour, evaluated once at its start."),
    Key("live", STATE, kinds.named(NAME),
        "Parameters of the behaviour, evaluated before each of its steps."),
    Key("as", STATE, kinds.name(NAME, "letters, digits and _"),
        "The name its published values are read under."),
    Key("include", STATE, kinds.scalar({"type": "string", "minLength": 1}),
        "A graph inside this state: a file beside this one, or a name under `graphs`."),
    Key("outcome", FINAL, _OUTCOME,
        "The outcome that the state around it ends with; `done` unless it is given.",
        label="outcome"),
    Key("output", FINAL, kinds.named(NAME),
        "The fields of `event` outside."),
    Key("deep", HISTORY, kinds.BOOLEAN,
        "Whether states further inside are remembered too."),
    Key("breakpoint", (*STATE, *FINAL), kinds.BOOLEAN,
        "Stop here under `drone-cli step`."),
    Key("target", HISTORY, kinds.SCALAR,
        "Where to go the first time.", apart=True),

    # A transition in its long form.
    Key("target", TRANSITION, kinds.SCALARS,
        "The state to go to, or one in each of several regions; none: nothing is left.",
        own_field="targets"),
    Key("guard", TRANSITION, kinds.SCALAR,
        "A condition; where it is false the next alternative is tried."),
    Key("actions", TRANSITION, kinds.ACTIONS,
        "Actions between leaving and entering."),
    Key("for", TRANSITION, kinds.SCALAR,
        "In `when`: how long the condition must last without a break.",
        own_field="hold", label="for"),
    Key("reenter", TRANSITION, kinds.BOOLEAN,
        "Leave and enter the state anew, even where the target lies inside."),
    Key("name", TRANSITION, kinds.TEXT,
        "What drawings and logs call it."),
    Key("description", TRANSITION, kinds.TEXT,
        "What the transition is for."),

    # An action block; its keys are :data:`fsm.language.spec.ActionKind`.
    Key("set", BLOCK, kinds.node(map_of(whole(NAME), _ANY)),
        "Assign variables; all right sides first."),
    Key("append", BLOCK, kinds.node(map_of(whole(NAME), _ANY)),
        "Add a value to the end of a list."),
    Key("raise", BLOCK, kinds.node({"anyOf": [_EVENT, _ONE_EVENT]}),
        "An event of this graph, heard at once."),
    Key("send", BLOCK, kinds.node(_MAP),
        "An event that is heard in a later period, or by another vehicle."),
    Key("cancel", BLOCK, kinds.node(_TEXT),
        "The id of a delayed `send` that is not to come."),
    Key("log", BLOCK, kinds.node(_TEXT),
        "A line in the run's record."),
    Key("call", BLOCK, kinds.node({"anyOf": [_TEXT, _ONE_CALL]}),
        "A Python function beside the mission, marked with @action."),

    Key("event", SEND, kinds.node(_EVENT),
        "The event's name, with a dot."),
    Key("to", SEND, kinds.node({"type": "string", "pattern": whole(SMALL_NAME)}),
        "The vehicle of the fleet that hears it; none: this one."),
    Key("with", SEND, kinds.node(_MAP),
        "The fields of the event."),
    Key("delay", SEND, kinds.node(_ANY),
        "A duration: how long from now it is heard."),
    Key("id", SEND, kinds.node(_TEXT),
        "What `cancel` calls it; the event's name unless it is given."),

    # A declared parameter in its long form.
    Key("type", PARAMETER, kinds.node(_TYPES),
        "Its type; that of the default unless it is given."),
    Key("default", PARAMETER, kinds.node(_ANY),
        "Its value unless another is given; without a default one must be."),
    Key("min", PARAMETER, kinds.node(_ANY),
        "The least value it may have."),
    Key("max", PARAMETER, kinds.node(_ANY),
        "The greatest value it may have."),
    Key("choices", PARAMETER, kinds.node(_ANY),
        "The texts it may be."),
    Key("help", PARAMETER, kinds.node(_ANY),
        "What it is for, in a few words."),

    # The top of a fleet's file, and each of its vehicles.
    Key("fleet", FLEET, kinds.SCALAR,
        "The fleet's name."),
    Key("world", FLEET, kinds.SCALAR,
        "The world they fly in."),
    Key("until", FLEET, kinds.SCALAR,
        "A condition that ends the run: an expression over vehicles and `time`."),
    Key("referee", FLEET, kinds.node(_MAP),
        "The two vehicles whose distance is looked at, and what counts as near."),
    Key("description", FLEET, kinds.TEXT,
        "One sentence that says what they do."),
    Key("vehicles", FLEET, kinds.node(_MAP),
        "Each vehicle with its mission and the parameters of that."),
    Key("mission", VEHICLE, kinds.SCALAR,
        "The file of its mission, beside this one; without a mission it stands."),
    Key("with", VEHICLE, kinds.node(_MAP),
        "Parameters of that mission."),
    Key("model", VEHICLE, kinds.SCALAR,
        "The name of its model."),
    Key("start", VEHICLE, kinds.node(_START),
        "Its place and heading at the start; none: a start of the world."),
    Key("color", VEHICLE, kinds.node(_COLOR),
        "The colour of its hull in pictures."),
)
# fmt: on

AT: dict[Place, dict[str, Key]] = {
    place: {key.name: key for key in KEYS if place in key.places} for place in get_args(Place)
}
"""The keys that may stand in a place, by their names."""
ANY_STATE = AT["state"] | AT["final"] | AT["history"]
"""The keys of all kinds of state."""
TOP_ONLY = {name: key for name, key in AT["mission"].items() if key is not ANY_STATE.get(name)}
"""The keys of a mission's file that it has beside those of a state."""
NOT_YET = frozenset({"filters"})
"""Keys of the language that this version does not fly yet."""
