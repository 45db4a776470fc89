"""Fixes in `check --json`: each is applied, and the mission checked again."""

from __future__ import annotations

import copy
import json
import random
from pathlib import Path
from typing import Any

import pytest

from runner.missions import SHIPPED
from tests.cli.run_cli import run_cli
from vencejo.errors import certain, nearest

RIGHT = """\
mission: right
parameters: {height: {default: 2 m, min: 1 m, max: 9 m, help: how high}}
data: {rounds: 0}
places: {tower: [4, 0, 2]}
states:
  takeoff: {do: takeoff, with: {altitude: $height}, on: {done: circle}}
  circle:
    on: {battery.low: land, blocked: land}
    states:
      go:
        do: goto
        with: {to: tower, speed: 1 m/s, heading: 90 deg}
        on: {done: {target: look, actions: {set: {rounds: "${rounds + 1}"}}}}
      look:
        do: hover
        when: {vehicle.altitude > 3 m and rounds > 0: {for: 1 s, target: land}}
        after: {5 s: land}
  land: {do: land, on: {done: finish, "*": finish}}
  finish: {type: final, output: {rounds: $rounds}}
"""
MISTAKES = {
    "a key": ("help: how", "hepl: how"),
    "a key of a state": ("do: goto", "doo: goto"),
    "a key at the top": ("parameters:", "paramters:"),
    "a behaviour": ("do: goto", "do: gotto"),
    "a parameter of a behaviour": ("speed:", "sped:"),
    "a target": ("target: land", "target: lnd"),
    "an outcome": ("blocked:", "bloked:"),
    "an event with an underscore": ("battery.low:", "battery_low:"),
    "an event": ("battery.low:", "battery.lo:"),
    "a parameter": ("$height", "$heigth"),
    "a variable": ("${rounds", "${ruonds"),
    "a variable that is set": ("set: {rounds", "set: {round"),
    "a name of the host": ("vehicle.altitude", "vehicle.altitud"),
    "a name without its host": ("vehicle.altitude", "altitude"),
    "signs of other languages": (" and rounds", " && rounds"),
    "a place": ("to: tower", "to: towr"),
    "a type": ("type: final", "type: finale"),
    "a bare angle": ("90 deg", "90"),
    "a blank after a colon": ("done: circle", "done:circle"),
    "a blank in an option": ("to: tower", "to:tower"),
    "a star": ('"*": finish', "*: finish"),
    "an expression without quotes": ('"${rounds + 1}"', "${rounds + 1}"),
}
"""What stands in the right mission, and what in the wrong one."""


def faults_of(mission: str) -> list[dict[str, Any]]:
    (report,) = json.loads(run_cli("check", mission, "--json").out)
    return report["faults"]


def applied(fix: dict[str, Any], text: str) -> str:
    """A file's text with a fix."""
    assert fix["line"] == fix["end_line"]
    lines = text.split("\n")
    line = lines[fix["line"] - 1]
    lines[fix["line"] - 1] = line[: fix["column"] - 1] + fix["text"] + line[fix["end_column"] - 1 :]
    return "\n".join(lines)


def test_the_right_mission_has_no_fault() -> None:
    Path("m.yaml").write_text(RIGHT)
    assert faults_of("m.yaml") == []


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_mended(mistake: str) -> None:
    right, wrong = MISTAKES[mistake]
    assert RIGHT.count(right) == 1
    text = RIGHT.replace(right, wrong)
    Path("m.yaml").write_text(text)
    fixes = [fault["fix"] for fault in faults_of("m.yaml") if fault["fix"]]
    assert fixes, faults_of("m.yaml")
    assert {fix["file"] for fix in fixes} == {"m.yaml"}
    assert {tuple(fix.values()) for fix in fixes} == {tuple(fixes[0].values())}
    assert applied(fixes[0], text) == RIGHT


def test_fixes_are_where_the_mistakes_are() -> None:
    Path("m.yaml").write_text(RIGHT.replace("to: tower", "to: towr"))
    (fault,) = faults_of("m.yaml")
    at = {"file": "m.yaml", "line": 12, "column": 20, "end_line": 12, "end_column": 24}
    assert fault["where"] == "m.yaml:12:20"
    assert fault["fix"] == {**at, "text": "tower"}


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("do: goto", "do: fly_away"),  # nothing like it
        ("done: finish", "finished: finish"),  # an outcome with no near one
        ("target: land", "target: l"),  # too far off
        ("target: land", "target: 3"),
        ("3 m and", "3 s and"),  # which of both is wrong?
        ("default: 2 m", "default: 20 m"),
    ],
)
def test_what_is_not_certain_has_no_fix(right: str, wrong: str) -> None:
    Path("m.yaml").write_text(RIGHT.replace(right, wrong))
    faults = faults_of("m.yaml")
    assert faults and [fault["fix"] for fault in faults] == [None] * len(faults)


def test_a_file_that_cannot_be_read_has_no_fix() -> None:
    assert [fault["fix"] for fault in faults_of("gone.yaml")] == [None]
    Path("m.yaml").write_bytes(b"mission: m\nstates: {a: {do: \xff}}\n")
    assert [fault["fix"] for fault in faults_of("m.yaml")] == [None]


def test_an_included_file_is_mended_where_it_lies() -> None:
    Path("m.yaml").write_text(
        "mission: m\nstates:\n  a: {include: parts/p.yaml, on: {done: f}}\n  f: {type: final}\n"
    )
    part = (
        "mission: p\nstates:\n  t: {do: takeoff, on: {done: l}}\n  l: {do: lannd, on: {done: f}}\n"
    )
    part += "  f: {type: final}\n"
    Path("parts").mkdir()
    Path("parts/p.yaml").write_text(part)
    (fix,) = [fault["fix"] for fault in faults_of("m.yaml") if fault["fix"]]
    assert fix["file"] == "parts/p.yaml"
    Path("parts/p.yaml").write_text(applied(fix, part))
    assert not [fault for fault in faults_of("m.yaml") if fault["severity"] == "error"]


@pytest.mark.parametrize("seed", range(40))
def test_whatever_is_mistyped_a_fix_mends_it(seed: int) -> None:
    """One letter is doubled, left out or exchanged; no fix may leave its fault or make another."""
    rng = random.Random(seed)
    text = rng.choice([RIGHT, *(path.read_text() for path in sorted(SHIPPED.glob("*.yaml")))])
    text = text.replace("parts/", f"{SHIPPED}/parts/")
    Path("m.yaml").write_text(text)
    before = {(fault["message"], fault["where"]) for fault in faults_of("m.yaml")}
    letters = [i for i, letter in enumerate(text) if letter.isalpha() and text[i - 1].isalpha()]
    place = rng.choice(letters)
    letter, last = text[place], text[place - 1]
    piece = rng.choice(["", letter * 2, letter + last])
    wrong = text[: place - 1] + ("" if len(piece) == 2 and piece[1] == last else last) + piece
    wrong += text[place + 1 :]
    Path("m.yaml").write_text(wrong)
    for fault in faults_of("m.yaml"):
        if fault["fix"] and (fault["message"], fault["where"]) not in before:
            Path("m.yaml").write_text(applied(fault["fix"], wrong))
            left = faults_of("m.yaml")
            told = fault["message"], fault["where"]
            assert told not in {(other["message"], other["where"]) for other in left}
            assert "repeated-key" not in {other["code"] for other in left}


def test_a_word_is_certain_only_where_no_other_is_as_near() -> None:
    assert certain("lannd", ["land", "hover"]) == "land"
    assert certain("rod", ["road", "rode"]) is None
    assert certain("arrived", ["failed", "done", "blocked"]) is None
    assert certain("x", []) is None


def test_a_correction_can_be_copied() -> None:
    hint: Any = copy.deepcopy(nearest("lannd", ["land"]))
    assert (hint, hint.wrong, hint.right) == ("did you mean 'land'?", "lannd", "land")
