"""What a flight leaves in `events.jsonl`: its records, as docs/runs.md lists them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fsm.engine.instance import Record
from tests.behaviors.flying import Rig

FLIGHT = """
mission: records
parameters: {pace: {default: 1 m/s, max: 3 m/s}}
data: {n: 0, all: []}
events: {my.own: {by: number}}
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: fly, failed: end}}
  fly:
    entry: [{set: {n: 3}}, {append: {all: $n}}, {log: "n=$n"}, {call: {lights: {pattern: "off"}}}]
    do: move
    live: {forward: $pace}
    on:
      my.own:
        target: wait
        name: told
        actions: [{send: {event: my.own, to: cat, with: {by: 7}}}, {log: "${1 / (n - 3)}"}]
  wait: {after: {1 s: end}, on: {error.execution: {}}}
  end: {type: final, output: {all: $all}}
"""


def documented() -> dict[str, set[str]]:
    """The fields of each kind, by the table of the guide."""
    guide = (Path(__file__).parents[2] / "docs" / "runs.md").read_text()
    table = guide.partition("| `kind` |")[2].partition("\n\n")[0]
    found: dict[str, set[str]] = {}
    for row in table.splitlines()[2:]:
        _, kinds, fields, _ = row.split("|", 3)
        names = set(re.findall(r"`(\w+)`", re.sub(r"\(.*?\)", "", fields)))
        found.update(dict.fromkeys(re.findall(r"`(\w+)`", kinds), names))
    return found


def of(rig: Rig, *kinds: str) -> list[Record]:
    return [(kind, dict(fields)) for kind, fields in rig.records if kind in kinds]


@pytest.fixture
def rig() -> Rig:
    """A flight in which nearly everything happens that is recorded."""
    rig = Rig(FLIGHT)
    rig.until_in("fly")
    rig.pilot.instance.set_parameter("pace", 2.0)
    rig.run(0.5)
    rig.pilot.instance.post("operator.takeover")
    rig.run(0.5)
    rig.pilot.instance.post("operator.release")
    rig.run(0.5)
    rig.vehicle.authority, rig.vehicle.authority_reason = "operator", "mode POSCTL"
    rig.run(0.1)
    rig.vehicle.authority, rig.vehicle.authority_reason = "mission", ""
    rig.run(0.1)
    rig.pilot.instance.post("my.own", {"by": 1})
    rig.run(30)
    assert rig.pilot.finished
    return rig


def test_the_records_of_the_mission_s_own_actions(rig: Rig) -> None:
    assert of(rig, "set", "append", "log", "call", "send", "undelivered", "parameter") == [
        ("set", {"name": "n", "value": 3}),
        ("append", {"name": "all", "value": 3}),
        ("log", {"text": "n=3"}),
        ("call", {"name": "lights", "with": {"pattern": "off"}}),
        ("parameter", {"name": "pace", "value": 2.0}),
        ("send", {"event": "my.own", "to": "cat", "fields": {"by": 7}}),
        ("undelivered", {"event": "my.own", "to": "cat"}),
    ]
    assert of(rig, "error") == [
        ("error", {"message": "log: a division by zero", "where": "test.yaml:16:69"})
    ]


def test_the_records_of_states_and_behaviours(rig: Rig) -> None:
    assert of(rig, "enter", "exit", "transition", "start", "stop") == [
        ("enter", {"state": ""}),
        ("enter", {"state": "up"}),
        ("start", {"state": "up", "do": "takeoff", "with": {"altitude": 2.0}}),
        ("exit", {"state": "up"}),
        ("transition", {"by": "on done", "from": "up", "to": ["fly"]}),
        ("enter", {"state": "fly"}),
        ("start", {"state": "fly", "do": "move", "with": {"forward": 1.0}}),
        ("stop", {"state": "fly"}),
        ("start", {"state": "fly", "do": "move", "with": {"forward": 2.0}}),
        ("stop", {"state": "fly"}),
        ("exit", {"state": "fly"}),
        ("transition", {"by": "on my.own", "from": "fly", "to": ["wait"], "name": "told"}),
        ("enter", {"state": "wait"}),
        ("transition", {"by": "on error.execution", "from": "wait", "to": []}),
        ("exit", {"state": "wait"}),
        ("transition", {"by": "after 1 s", "from": "wait", "to": ["end"]}),
        ("enter", {"state": "end"}),
        ("exit", {"state": "end"}),
        ("exit", {"state": ""}),
    ]


def test_the_records_of_events_and_of_the_host_s_reactions(rig: Rig) -> None:
    error = {"message": "log: a division by zero", "where": "test.yaml:16:69"}
    assert of(rig, "event", "reaction", "suspend", "resume", "landing", "outcome") == [
        ("event", {"name": "done", "state": "up", "taken": True}),
        ("event", {"name": "operator.takeover", "taken": False}),
        ("reaction", {"event": "operator.takeover", "does": "suspend"}),
        ("suspend", {}),
        ("resume", {}),
        ("event", {"name": "operator.release", "taken": False}),
        ("event", {"name": "my.own", "fields": {"by": 1}, "taken": True}),
        ("event", {"name": "error.execution", "fields": error, "taken": True}),
        ("outcome", {"outcome": "done", "reason": None}),
        ("landing", {"by": "host"}),
    ]


def test_the_records_of_the_vehicle(rig: Rig) -> None:
    assert of(rig, "authority", "refused") == [
        ("authority", {"authority": "operator", "reason": "mode POSCTL"}),
        ("refused", {"setpoint": "Velocity", "reason": "mode POSCTL"}),
        ("authority", {"authority": "mission", "reason": None}),
    ]


def test_the_guide_lists_the_fields_of_every_record(rig: Rig) -> None:
    known = documented()
    for kind, fields in rig.records:
        assert set(fields) <= known[kind], kind
    # What else there is are troubles of a vehicle (see test_link).
    assert known.keys() - {kind for kind, _ in rig.records} == {"link", "late", "jump"}
