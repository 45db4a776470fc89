"""drone-cli guide: the language and the behaviours on one page, for programs that write missions.

What can be counted (keys, types, units, functions, events, behaviours) is taken from the code; the
rules between them are told in :data:`RULES`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import click

from behaviors import drone_vocabulary
from cli.lists import described, plain
from cli.options import call_limit_option
from cli.user_code import user_code
from fsm import BehaviorInfo, Vocabulary
from fsm.host import Function
from fsm.language.keys import AT, NOT_YET, Key, Place
from fsm.values.functions import FUNCTIONS
from fsm.values.types import NAMED, MapOf, Type
from runner.missions import SHIPPED
from vencejo.units import UNITS
from worlds import world_families, world_names

EXAMPLES = ("first_flight", "beacon_route", "survey_square")
"""Shipped missions that are printed whole."""
PLACES: Mapping[Place, str] = {
    "mission": "At the top of the file",
    "state": "In a state; all but `as` and `do` stand at the top too",
    "final": "In a state of `type: final`",
    "history": "In a state of `type: history`",
    "transition": "In a transition",
    "actions": "In an action block, run in order; a list of such maps to repeat one",
    "send": "Inside `send`",
    "parameter": "In a parameter, and with `type` and `default` in `data`",
    "fleet": "At the top of a fleet's file",
    "vehicle": "In a vehicle of a fleet",
}
"""The places of keys, in the order of the page."""

RULES = """\
# Writing missions for drone-cli

A mission is a YAML file: a hierarchical state graph (a statechart in the sense of SCXML and
XState). Each state may run one behaviour. `drone-cli check FILE --json` reports all mistakes, each
with `where`, `hint`, and, where it is certain, a `fix` (`file`, `line`, `column`, `end_line`,
`end_column`, `text`; the end is exclusive). `drone-cli run FILE --json` flies it in the simulator
and prints the summary. Exit codes: 0 the outcome was `done`, 1 another one, 2 the mission or its
arguments are wrong, 3 the vehicle failed, 4 it flew but could not be recorded. `-p NAME=VALUE` sets
a parameter, `--world NAME` the world, `--seed N` all randomness.

## Reading

- YAML 1.2: only `true`, `false`, `null` and decimal numbers are special. Unknown and repeated keys,
  and tags, are errors. Inside `{ }` and `[ ]` put quotes around `"${…}"`, around texts with a comma
  or bracket, and always around `"*"`. Write a blank after each colon.
- Names of states are small letters, digits and `_`. The first state is initial.
- A value is a literal of the type that its place asks for, or an expression: `$name`, else
  `"${…}"`. In a text it is inserted: `"at ${height:.1f} m"`; `$$` is a dollar. The keys of `when`
  and `after`, and `guard`, `for`, `until` and `define`, are expressions written bare.
- Numbers carry units (`3 m`, `90 deg`, `1.5 m/s`, `30 %`); without one they are SI: metres,
  seconds, radians. `heading: 90` is 90 radians.
- Points are metres east, north and up of home: `[x, y, z]`; `[x, y]` keeps the height;
  `{forward: 2 m, left: 0, up: 1 m}` from where the vehicle is and looks; `{x, y, z, frame: world}`;
  `{lat, lon, above_home}`; `{x, y, above_ground: 4 m}`; `home`; the name of a place;
  `$vehicle.position`. A heading is an angle counter-clockwise from east, `keep`, `travel` or
  `{face: point}`.

## Expressions

Python's arithmetic, comparison, `and or not`, `in`, `a if c else b`, indexing, fields, lists and
comprehensions. Dimensions are checked: a length and a time are neither added nor compared. Names:
the `parameters`; `data`, `define` and published values (`goto.distance`, or under the name that
`as` gives) of the state and the states around it; `time`, `time_in_state`, `dt`; `event`, with the
fields of what is handled, in an `on` transition; and those of the host below. No name may hide
another. `active('a.b')` tells whether a state is active.

## Transitions

- A target alone (`done: land`), a map in the long form, or a list of these, of which the first
  whose `guard` passes is taken. Without a target nothing is left; `{}` only takes the event.
- A target is looked up among the children of the state it stands in, then its siblings, then
  outwards; `a.b` goes inside. Naming the state itself restarts it.
- An *outcome* is one word: how the behaviour ended, or the `outcome` of a final state inside. Its
  own state hears it, then the states around it; `done` only its own state. Every outcome of a
  behaviour but `failed` must be handled, there or further out. A behaviour that never ends needs
  another way out: `after`, `when` or an event.
- An *event* has a dot and is heard by all active states. `battery.*` takes a family, `"*"` all but
  errors and urgent ones. Events from outside are declared under `events`, with their fields.
- What stands in a state holds in all states inside it: handle `battery.low` and `blocked` once,
  in the state around. A state with `states` may `do` only what never ends.
- `when` is taken once when it becomes true, and is tested each period (25 ms); `after` counts from
  entry; `always` is for choices. `type: parallel` has all its children active.
- What nobody handles: `failed`, `error.*` and urgent events make the host hold, land and end the
  mission in `failed`; but `battery.low` has no consequence, and `operator.takeover` suspends the
  mission until `operator.release`.
- The mission ends in a final state of the top; only the outcome `done` is success. End on the
  ground: `takeoff` … `land` … a final state.
- `include` puts another graph inside a state: `with` gives its parameters, its final outcomes are
  outcomes of the state, their `output` the fields of `event`.

A *fleet* flies several missions in one world: a file with `fleet: NAME` and, under `vehicles`,
each with its `mission` (a file beside it), `with`, `start` (`{at: [x, y], heading: 90 deg}`) and
`color`; `run`, `check` and `show` take it like a mission, and `-p VEHICLE.NAME=VALUE` sets a
parameter. `send: {event: game.over, to: cat, with: {at: $vehicle.position}}` is heard by the other
in the next period, with `event.source`; places are converted. `until: cat.vehicle.battery < 30 %`
at the top ends the flight of all with `done`.

Python beside a mission (`uses: [mine.py]`) adds behaviours, classes of `behaviors.Behavior`, and
functions for `call`, marked with `behaviors.action`; `drone-cli behaviors --uses mine.py` lists
them.
"""


@click.command()
@call_limit_option
def guide(call_limit: float | None) -> None:
    """Print the language, all behaviours and three examples on one page, as Markdown.

    It is written for whoever writes missions without having seen one, programs included.
    """
    with user_code(call_limit) as limit:
        vocabulary = drone_vocabulary(calls=limit.calls)
        page = "\n".join(_page(vocabulary))
    click.echo(page)


def _page(vocabulary: Vocabulary) -> Iterator[str]:
    yield RULES
    yield "## Keys\n"
    for place, title in PLACES.items():
        yield f"{title}:\n"
        yield from map(_key, _keys_of(place))
        yield ""
    yield f"Not in this version yet: {_listed(NOT_YET)}.\n"
    yield "## Types, units, functions and names\n"
    yield f"Types: {_listed(NAMED)}, and lists of one type: `[length]`.\n"
    yield f"Units: {_listed(UNITS)}.\n"
    yield f"Functions in expressions: {_listed(_signatures())} `active(a)`.\n"
    for name, type_ in vocabulary.names.items():
        yield f"Of the host: {_listed(f'{name}.{field}' for field in _fields(type_))}.\n"
    numbered = _listed(f"{family}:1" for family in world_families())
    yield f"Worlds: {_listed(world_names())}, and any number of {numbered}.\n"
    yield "## Events from the host\n"
    for event, fields in vocabulary.events.items():
        urgent = "urgent" if vocabulary.is_urgent(event) else ""
        yield f"- `{event}`" + _in_brackets(urgent, *(f"`event.{field}`" for field in fields))
    yield "\n## Functions to `call`\n"
    yield from map(_function, vocabulary.functions.values())
    yield "\n## Behaviours\n"
    yield "`failed` (`event.reason`) is an outcome of each. `live` ones may stand under `live`.\n"
    for behavior in vocabulary.behaviors.values():
        yield from _behavior(behavior)
    yield "## Examples\n"
    for name in EXAMPLES:
        yield f"```yaml\n{(SHIPPED / f'{name}.yaml').read_text('utf-8')}```\n"


def _keys_of(place: Place) -> Iterable[Key]:
    """The keys of a place; of those at the top the ones that states do not have."""
    same = AT["state"] if place == "mission" else {}
    return [key for key in AT[place].values() if key is not same.get(key.name)]


def _key(key: Key) -> str:
    words = f" ({' | '.join(key.kind.options)})" if key.kind.options else ""
    return f"- `{key.name}`{words}: {key.help}"


def _function(function: Function) -> str:
    given = (f"`{parameter.name}` {parameter.type}" for parameter in function.parameters.values())
    return f"- `{function.name}`: {function.help} Arguments: {', '.join(given)}."


def _behavior(behavior: BehaviorInfo) -> Iterator[str]:
    yield f"`{behavior.name}`: {plain(behavior.help).partition(chr(10))[0]}\n"
    yield from (f"- `{one.name}`: {described(one)}" for one in behavior.parameters.values())
    outcomes = [word + _in_brackets(*fields) for word, fields in behavior.outcomes.items()]
    yield f"- outcomes: {', '.join(outcomes) or 'none, it never ends by itself'}"
    for event, fields in behavior.events.items():
        yield f"- raises `{event}`{_in_brackets(*fields)}"
    if behavior.publishes:
        names = (f"{behavior.name}.{value}" for value in behavior.publishes)
        yield f"- publishes {_listed(names)}"
    yield ""


def _signatures() -> Iterator[str]:
    """The functions with as many arguments as they need, and those they may have in brackets."""
    for name, function in FUNCTIONS.items():
        needed = ", ".join("abc"[: function.least])
        more = "".join(f", {one}" for one in "abc"[function.least : function.most])
        more = ", …" if function.most > len("abc") else more
        yield f"{name}({needed}{f'[{more}]' if more else ''})"


def _fields(type_: Type) -> Iterable[str]:
    return (type_.fields or ()) if isinstance(type_, MapOf) else ()


def _listed(words: Iterable[str]) -> str:
    return " ".join(f"`{word}`" for word in words)


def _in_brackets(*words: str) -> str:
    given = ", ".join(filter(None, words))
    return f" ({given})" if given else ""
