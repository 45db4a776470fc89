"""The referee: how long one vehicle is near another, and how often it loses it."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import pytest

from runner import prepare_fleet, read_run
from runner.missions import find
from runner.referee import (
    Contest,
    Referee,
    Verdict,
    contest_fields,
    contest_of,
    verdict_fields,
    verdict_of,
)
from runner.testing import fly_fleet
from tests.cli.run_cli import run_cli
from vencejo.geometry import Point

HERE = Point(0.0, 0.0, 2.0)
HOLD = """\
mission: hold
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: stay}}
  stay: {do: hover, after: {4 s: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
AWAY = """\
mission: away
events: {target.lost: {}}
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: lose}}
  lose:
    entry: {raise: target.lost}
    do: hover
    on: {target.lost: {actions: {log: lost it}}}
    after: {1 s: go}
  go: {do: goto, with: {to: [-4, 0, 2], speed: 2 m/s}, on: {done: down, blocked: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
FLEET = """\
fleet: apart
referee: {between: [cat, mouse], near: 3 m}
vehicles:
  cat: {mission: away.yaml, start: {at: [0, 0]}}
  mouse: {mission: hold.yaml, start: {at: [2, 0]}}
"""


def test_it_counts_while_both_are_in_the_air() -> None:
    referee = Referee(Contest(("cat", "mouse"), 3.0))
    assert referee.verdict() == Verdict(referee.contest)
    for far, flying in ((1.0, False), (2.0, True), (3.0, True), (4.0, True), (9.0, False)):
        referee.update([HERE, HERE.plus((far, 0.0, 0.0))], flying, 0.5)
    referee.hear([("event", {"name": "target.lost"}), ("event", {"name": "target.found"})])
    referee.hear([("enter", {"state": "target.lost"}), ("event", {"name": "target.lost"})])
    assert referee.verdict() == Verdict(referee.contest, 1.5, 1.0, 3.0, 2)


def test_a_verdict_is_read_as_it_was_written() -> None:
    verdict = Verdict(Contest(("cat", "mouse"), 3.5), 10.25, 7.5, 3.125, 2)
    assert verdict_of(json.loads(json.dumps(verdict_fields(verdict)))) == verdict
    assert contest_of(json.loads(json.dumps(contest_fields(verdict.contest)))) == verdict.contest


@pytest.fixture
def fleet(tmp_path: Path) -> Path:
    for name, text in (("hold", HOLD), ("away", AWAY), ("apart", FLEET)):
        (tmp_path / f"{name}.yaml").write_text(text)
    return tmp_path / "apart.yaml"


def test_a_fleets_run_tells_what_its_referee_saw_and_draws_it(fleet: Path) -> None:
    runs = str(fleet.parent / "runs")
    ran = run_cli("run", str(fleet), "--runs-dir", runs)
    assert ran.code == 0
    assert "referee: cat within 3 m of mouse for " in ran.out
    assert "lost it 1 time" in ran.out
    (folder,) = (fleet.parent / "runs").iterdir()
    run = read_run(folder)
    assert run.header.settings is not None and run.summary is not None
    assert run.header.settings.referee == Contest(("cat", "mouse"), 3.0)
    verdict = run.summary.verdict
    assert verdict is not None and verdict.losses == 1
    assert 3 < verdict.time_near < 5 < verdict.time < 9
    assert 2.2 < verdict.mean_distance < 4.5
    picture = cv2.imread(str(folder / "flight.png"))
    shaded = (picture == (222, 240, 222)[::-1]).all(axis=2)
    assert shaded.sum() > 10_000
    again = run_cli("run", "--again", str(folder), "--runs-dir", runs)
    assert again.code == 0
    first, second = sorted((fleet.parent / "runs").iterdir())
    assert (first / "events.jsonl").read_bytes() == (second / "events.jsonl").read_bytes()


def test_from_python(fleet: Path) -> None:
    verdict = fly_fleet(fleet).summary.verdict
    assert verdict is not None and verdict.contest.between == ("cat", "mouse")


@pytest.mark.parametrize(
    ("referee", "code"),
    [
        ("{between: [cat, dog]}", "unknown-vehicle"),
        ("{between: [cat, cat]}", "wrong-type"),
        ("{between: [cat]}", "wrong-type"),
        ("{between: cat}", "wrong-type"),
        ("{near: 3 m}", "missing-key"),
        ("{between: [cat, mouse], near: 3 s}", "wrong-dimension"),
        ("{between: [cat, mouse], nearer: 3 m}", "unknown-key"),
        ("cat", "wrong-type"),
    ],
)
def test_what_is_wrong_with_a_referee_is_told_with_its_place(
    fleet: Path, referee: str, code: str
) -> None:
    fleet.write_text(FLEET.replace("{between: [cat, mouse], near: 3 m}", referee))
    (fault,) = prepare_fleet(find(str(fleet))).faults
    assert (fault.code, fault.severity) == (code, "error")
    assert fault.where is not None and fault.where.line == 2
