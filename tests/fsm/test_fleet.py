# ruff: noqa: E501  (a mission stands in one line with what becomes of it)
"""Fleets: read and checked; and what one vehicle sends to another."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from fsm import compile_mission, read_mission_text
from fsm.faults import Faults
from fsm.fleet import check_fleet, compile_until, read_fleet
from tests.fsm.toy import VOCABULARY, Run
from vencejo.errors import UserError, Where

CAT = """\
parameters: {limit: 1 s, speed: {type: speed}}
states:
  a: {after: {limit: {target: b, actions: {send: {event: game.over, to: mouse, with: {by: cat}}}}}}
  b: {type: final}
"""
MOUSE = """\
events: {game.over: {by: text}}
states: {a: {on: {game.over: b}}, b: {type: final}}
"""
FLEET = """\
fleet: chase
world: yard
vehicles:
  cat: {mission: cat.yaml, with: {speed: 2 m/s}}
  mouse: {mission: mouse.yaml}
until: time > 200 s or cat.vehicle.altitude > 3 m
"""


def faults(folder: Path, fleet: str = FLEET, cat: str = CAT, mouse: str = MOUSE) -> list[str]:
    for name, text in (("fleet", fleet), ("cat", cat), ("mouse", mouse)):
        (folder / f"{name}.yaml").write_text(text)
    (folder / "cat.scxml").write_text("<scxml/>")
    spec, found = read_fleet(folder / "fleet.yaml", "fleet.yaml")
    vocabulary = replace(VOCABULARY, peers=frozenset(name.text for name in spec.names))
    graphs = {}
    for member in spec.members:
        if member.spec is None:
            continue
        with found.collecting():
            graphs[member.name.text] = compile_mission(member.spec, vocabulary)
    found.extend(check_fleet(spec, graphs))
    return [f"{fault.where}: {fault.code}" for fault in found]


def test_a_fleet_without_mistakes(tmp_path: Path) -> None:
    assert faults(tmp_path) == []


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("speed: 2", "sped: 2", ["fleet.yaml:4:35: unknown-parameter", "fleet.yaml:4:3: missing-parameter"]),
        ("2 m/s", "2 s", ["fleet.yaml:4:42: wrong-dimension"]),
        ("cat.yaml", "cta.yaml", ["fleet.yaml:4:18: no-such-file"]),
        ("cat.yaml", "../cat.yaml", ["fleet.yaml:4:18: outside-folder"]),
        ("mission: mouse.yaml", "misson: mouse.yaml", ["fleet.yaml:5:11: unknown-key"]),
        ("time > 200 s", "tim > 200 s", ["fleet.yaml:6:8: unknown-name"]),
        ("200 s", "200 m", ["fleet.yaml:6:8: wrong-dimension"]),
        ("  mouse:", "  mouze:", ["cat.yaml:3:73: unknown-vehicle"]),
        ("until", "untill", ["fleet.yaml:6:1: unknown-key"]),
        ("cat.yaml", "fleet.yaml", ["fleet.yaml:4:18: not-a-mission"]),
        ("cat.yaml", "cat.scxml", ["fleet.yaml:4:18: not-a-mission"]),
        ("fleet: chase", "fleet: cat/mouse", ["fleet.yaml:1:8: bad-name"]),
        ("mouse: {mission: mouse.yaml}", "mouse: {}", []),
        ("mouse: {mission: mouse.yaml}", "mouse: mouse.yaml", ["fleet.yaml:5:10: wrong-type"]),
        ("mouse: {mission: mouse.yaml}", "time: {mission: mouse.yaml}", ["cat.yaml:3:73: unknown-vehicle", "fleet.yaml:5:3: name-taken"]),
        ("time > 200 s", "1 > 2", ["fleet.yaml:6:8: constant-condition"]),
    ],
)  # fmt: skip
def test_faults_of_a_fleet(tmp_path: Path, old: str, new: str, found: list[str]) -> None:
    assert faults(tmp_path, FLEET.replace(old, new)) == found


def test_faults_of_its_missions_are_told(tmp_path: Path) -> None:
    broken = CAT.replace("target: b", "target: c")
    assert faults(tmp_path, cat=broken, mouse=MOUSE + "what: 1\n") == [
        "mouse.yaml:3:1: unknown-key",
        "cat.yaml:3:31: unknown-target",
    ]


def test_a_fleet_needs_vehicles(tmp_path: Path) -> None:
    assert faults(tmp_path, "fleet: none\n") == ["fleet.yaml:1:1: no-vehicles"]
    empty = "fleet: none\nvehicles: {}\n"
    assert faults(tmp_path, empty) == ["fleet.yaml:2:11: no-vehicles"]
    listed = "fleet: none\nvehicles: [cat, mouse]\n"
    assert faults(tmp_path, listed) == ["fleet.yaml:2:11: wrong-type"]


def test_what_is_sent_to_another_vehicle_is_the_hosts_to_deliver() -> None:
    run = Run(CAT, parameters={"limit": 0.05})
    run.run(3)
    assert run.instance.outcome == "done"
    assert run.log == ["send game.over to mouse: {'by': 'cat'}"]
    later = CAT.replace("to: mouse", "delay: 50 ms, to: mouse").replace(
        "{type: final}", "{after: {1 s: a}}"
    )
    run = Run(later, parameters={"limit": 0.05})
    run.run(4)
    assert run.log == []
    run.run()
    assert run.log == ["send game.over to mouse: {'by': 'cat'}"]


def test_a_receiver_has_a_name() -> None:
    with pytest.raises(UserError) as error:
        Run(CAT.replace("to: mouse", "to: $limit"))
    assert error.value.code == "bad-name"


@pytest.mark.parametrize(
    ("sent", "heard", "found"),
    [
        ("with: {by: cat}", "{by: text}", []),
        ("with: {by: $limit}", "{by: time}", []),
        ("with: {by: $limit}", "{by: number}", []),
        ("with: {by: 3, more: 4}", "{}", []),
        ("with: {by: 5 s}", "{by: length}", ["cat.yaml:3:91: wrong-dimension"]),
        ("with: {by: $speed}", "{by: time}", ["cat.yaml:3:92: wrong-dimension"]),
        ("with: {by: 3}", "{by: text}", ["cat.yaml:3:91: wrong-type"]),
        ("with: {bye: cat}", "{by: text}", ["cat.yaml:3:58: missing-key", "cat.yaml:3:92: unknown-key"]),
        ("delay: 2 s", "{by: text}", ["cat.yaml:3:58: missing-key"]),
    ],
)  # fmt: skip
def test_fields_that_are_sent_fit_the_mission_that_hears_them(
    tmp_path: Path, sent: str, heard: str, found: list[str]
) -> None:
    cat = CAT.replace("with: {by: cat}", sent)
    mouse = MOUSE.replace("{by: text}", heard)
    assert faults(tmp_path, cat=cat, mouse=mouse) == found


@pytest.mark.parametrize(
    ("guard", "found"),
    [
        ("event.source == 'cat'", []),
        ("event.source in ['cat', 'dog']", []),
        ("event.source > 3", ["mouse.yaml:2:50: wrong-type"]),
        ("event.sauce == 'cat'", ["mouse.yaml:2:50: unknown-field"]),
    ],
)
def test_an_event_says_who_sent_it(tmp_path: Path, guard: str, found: list[str]) -> None:
    mouse = MOUSE.replace("game.over: b", f'game.over: {{target: b, guard: "{guard}"}}')
    assert faults(tmp_path, mouse=mouse) == found


def test_until_is_a_condition_over_all_vehicles(tmp_path: Path) -> None:
    graphs = {name: compile_mission(read_mission_text(MOUSE), VOCABULARY) for name in ("a", "b")}
    names = next(iter(VOCABULARY.names))
    assert names == "vehicle"
    found = Faults()
    text = "time > 2 s and a.vehicle.altitude + b.vehicle.altitude > 3 m"
    until = compile_until(text, Where("fleet.yaml", 1, 1), graphs, found)
    assert until.text == text and found == []
    high, low = (SimpleNamespace(vehicle=SimpleNamespace(altitude=h)) for h in (2.5, 0.4))
    assert until.holds(2.1, [high, high])
    assert not until.holds(1.9, [high, high])
    assert not until.holds(2.1, [high, low])


def test_an_event_that_the_other_vehicle_does_not_hear(tmp_path: Path) -> None:
    cat = CAT.replace("game.over", "game.ovr")
    assert faults(tmp_path, cat=cat) == ["cat.yaml:3:58: unheard-event"]
