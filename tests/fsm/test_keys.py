"""The table of keys against all that must know them: spec, reader, schema and guide."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any, get_args

import pytest

from fsm.fleet import read_fleet
from fsm.language.keys import ANY_STATE, AT, KEYS, NOT_YET, TOP_ONLY, Key, Place
from fsm.language.spec import ActionKind, MissionSpec, StateSpec, TransitionSpec, TriggerKind
from fsm.schema import mission_schema
from tests.fsm.toy import VOCABULARY, faults_of
from vencejo.errors import Fault

GUIDE = (Path(__file__).parents[2] / "docs/language.md").read_text()
SCHEMA = mission_schema(VOCABULARY)
PLACES: tuple[Place, ...] = get_args(Place)
NAMES = sorted({key.name for key in KEYS} | NOT_YET)

# A map for each place, to put a key into; its first character stands where `{` is.
TEXTS: dict[Place, str] = {
    "mission": "@: {}\nstates: {a: {}}\n",
    "graph": "states: {a: {include: g}}\ngraphs:\n  g:\n    states: {b: {}}\n    @: {}\n",
    "state": "states:\n  a:\n    @: {}\n",
    "final": "states:\n  a:\n    type: final\n    @: {}\n",
    "history": "states:\n  b: {}\n  a:\n    type: history\n    @: {}\n",
    "transition": "states:\n  a:\n    on:\n      failed:\n        @: {}\n",
    "actions": "states:\n  a:\n    entry:\n      @: {}\n",
    "send": "states:\n  a:\n    entry:\n      send:\n        @: {}\n",
    "parameter": "parameters:\n  p:\n    @: {}\nstates: {a: {}}\n",
    "fleet": "vehicles: {a: {mission: m.yaml}}\n@: {}\n",
    "vehicle": "fleet: f\nvehicles:\n  a:\n    mission: m.yaml\n    @: {}\n",
}


def faults_at(place: Place, name: str, folder: Path) -> list[Fault]:
    """The faults of a file in which a key stands in a place, which has that key's only once."""
    text = TEXTS[place].replace("@", name)
    if place not in ("fleet", "vehicle"):
        return list(faults_of(text))
    (folder / "m.yaml").write_text("states: {a: {}}\n")
    (folder / "f.yaml").write_text(text)
    return list(read_fleet(folder / "f.yaml", "f.yaml")[1])


def place_of(text: str) -> str:
    before = text[: text.index("@")]
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


def properties(place: Place) -> dict[str, Any]:
    """The schema's properties for the keys of a place."""
    defs, fleet = SCHEMA["$defs"], SCHEMA["then"]["properties"]
    top = SCHEMA["else"]["properties"]
    actions = defs["actions"]["anyOf"][0]["properties"]
    state = defs["state"]["properties"]
    found: dict[Place, dict[str, Any]] = {
        "mission": top,
        "graph": defs["graph"]["properties"],
        "state": state,
        "final": state,
        "history": state,
        "transition": defs["lasting"]["anyOf"][1]["properties"],
        "actions": actions,
        "send": actions["send"]["properties"],
        "parameter": top["parameters"]["additionalProperties"]["anyOf"][1]["properties"],
        "fleet": fleet,
        "vehicle": fleet["vehicles"]["additionalProperties"]["properties"],
    }
    return found[place]


ROWS = [pytest.param(key, place, id=f"{place}-{key.name}") for key in KEYS for place in key.places]


def test_a_name_means_one_thing_in_a_place() -> None:
    for place in PLACES:
        names = [key.name for key in KEYS if place in key.places]
        assert len(names) == len(set(names)), place


def test_the_spec_has_a_field_for_every_key_that_is_read_into_one() -> None:
    for keys, spec in (
        (TOP_ONLY, MissionSpec),
        (ANY_STATE, StateSpec),
        (AT["transition"], TransitionSpec),
    ):
        known = {field.name for field in fields(spec)}
        assert {key.field for key in keys.values() if not key.apart} <= known
    assert set(AT["actions"]) == set(get_args(ActionKind))
    readers = {name: key.kind.reader for name, key in AT["state"].items()}
    triggers = [name for name, reader in readers.items() if reader in ("triggers", "transition")]
    assert tuple(triggers) == get_args(TriggerKind)


UNEXPLAINED = {"transition", "send", "parameter"}
"""Places whose keys an editor completes without their help."""
ROOT_TYPE = {("type", "mission"), ("type", "graph")}
"""The schema lists the types of a root without any help."""


@pytest.mark.parametrize(("key", "place"), ROWS)
def test_the_schema_knows_the_key_with_its_help(key: Key, place: Place) -> None:
    assert key.help.endswith(".")
    said = properties(place)[key.name]
    if place in UNEXPLAINED or (key.name, place) in ROOT_TYPE:
        assert "description" not in said
    else:
        assert said["description"] == key.help


def test_the_schema_knows_no_other_key() -> None:
    states = set(ANY_STATE)
    for place in PLACES:
        expected = states if place in ("state", "final", "history") else set(AT[place])
        assert set(properties(place)) == expected, place
    for rule in SCHEMA["$defs"]["state"]["allOf"][:2]:
        type_: Place = rule["if"]["properties"]["type"]["const"]
        assert set(rule["then"]["propertyNames"]["enum"]) == set(AT[type_])


def guide_to(place: Place) -> str:
    """The part of the guide where the keys of a place stand."""
    sections = re.split(r"^## ", GUIDE, flags=re.M)
    title = "Fleets" if place in ("fleet", "vehicle") else "Keys"
    section = next(section for section in sections if section.startswith(title))
    if place in ("mission", "graph", "state", "final", "history"):
        return "\n".join(re.findall(r"^\|(.*?)\|", section, re.M))
    return section


@pytest.mark.parametrize(("key", "place"), ROWS)
def test_the_guide_names_the_key(key: Key, place: Place) -> None:
    code = re.findall(r"```.*?```|`[^`]+`", guide_to(place), re.S)
    assert any(re.search(rf"\b{key.name}\b", part) for part in code)


OTHER_READERS = {"send", "parameter", "fleet", "vehicle"}
"""Places where `filters` is a key like any other that is unknown."""


@pytest.mark.parametrize("place", PLACES)
def test_a_key_is_known_where_it_may_stand_and_nowhere_else(place: Place, tmp_path: Path) -> None:
    where = place_of(TEXTS[place])
    for name in NAMES:
        if f"{name}:" in TEXTS[place] or (place == "mission" and name == "fleet"):
            continue  # stands there already, or makes another file of it
        found = faults_at(place, name, tmp_path)
        code = "not-yet" if name in NOT_YET and place not in OTHER_READERS else "unknown-key"
        refused = [str(f.where).partition(":")[2] for f in found if f.code == code]
        assert refused == ([] if name in AT[place] else [where]), (name, found)
