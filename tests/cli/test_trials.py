"""check --fly: trial flights in the simulator, and what is told of them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from runner.testing import fly_mission
from tests.cli.run_cli import run_cli

HOP = """
mission: hop
world: yard
states:
  up: {do: takeoff, with: {altitude: 1 m}, on: {done: over}}
  over: {do: goto, with: {to: [3, 2, 1]}, on: {done: down, blocked: late}}
  down: {do: land, on: {done: finish}}
  late: {do: land, on: {done: stuck}}
  finish: {type: final}
  stuck: {type: final, outcome: stuck}
"""


@pytest.fixture
def hop(tmp_path: Path) -> Path:
    path = tmp_path / "hop.yaml"
    path.write_text(HOP)
    return path


def flown(*arguments: str) -> tuple[int, dict[str, Any]]:
    result = run_cli("check", *arguments, "--json")
    (report,) = json.loads(result.out)
    return result.code, report


def test_what_was_measured_of_all_flights_is_told(hop: Path) -> None:
    result = run_cli("check", str(hop), "--fly", "3", "--noise", "1")
    verdict, *lines = result.out.splitlines()
    assert result.code == 0 and verdict == f"{hop}: may fly, 6 states"
    assert lines[0] == "  flown with seeds 0 to 2: 3 done"
    for word in ("time", "battery", "highest", "clearance"):
        assert any(line.split()[0] == word for line in lines)
    assert any(re.search(r"over: [12]\.", line) and "m from 'shed' (seed" in line for line in lines)
    assert lines[-1] == "    not reached late, stuck"


def test_json_has_each_flight_with_its_seed_and_the_least_of_all(hop: Path) -> None:
    code, report = flown(str(hop), "--fly", "2", "--noise", "1")
    assert code == 0 and report["never_reached"] == ["late", "stuck"]
    one, two = report["flights"]
    assert [one["seed"], two["seed"]] == [0, 1] and one["outcome"] == two["outcome"] == "done"
    assert one["mission_time_s"] > 5 and 0.9 < one["battery_left"] < 1 and one["distance_m"] > 4
    assert one["clearance_m"] != two["clearance_m"], "noise makes them differ"
    least = report["clearance"]["over"]
    assert least["thing"] == "shed"
    assert least["distance_m"] == min(each["clearance_m"]["over"] for each in (one, two))
    # The shed's near side is 2 m from the end.
    assert least["distance_m"] == pytest.approx(2.0, abs=0.2)


def test_the_same_seed_is_the_same_flight(hop: Path) -> None:
    _, report = flown(str(hop), "--fly", "2", "--noise", "1")
    alone = fly_mission(hop, seed=1, noise=1.0)
    flight = report["flights"][1]
    assert flight["mission_time_s"] == alone.time
    assert flight["max_altitude_m"] == round(alone.highest, 2)


def test_a_flight_that_does_not_end_in_done_is_exit_code_1(hop: Path) -> None:
    hop.write_text(HOP.replace("to: [3, 2, 1]", "to: [3, 2, 1], timeout: 1 s"))
    code, report = flown(str(hop), "--fly", "1")
    assert code == 1 and report["flights"][0]["outcome"] == "stuck"
    assert "seed 0 ended in stuck" in run_cli("check", str(hop), "--fly", "1").out


def test_a_mission_with_errors_is_not_flown(hop: Path) -> None:
    hop.write_text(HOP.replace("do: land, on: {done: finish}", "do: lannd, on: {done: finish}"))
    code, report = flown(str(hop), "--fly", "1")
    assert code == 2 and "flights" not in report


def test_limits_of_the_command_line_hold_in_trial_flights(hop: Path) -> None:
    code, report = flown(str(hop), "--fly", "1", "--limit", "max_altitude=50cm")
    assert code == 1 and report["flights"][0]["max_altitude_m"] < 0.6
    assert [fault["code"] for fault in report["faults"]] == ["beyond-limits"]


def test_things_that_move_are_measured_where_they_are(tmp_path: Path) -> None:
    (tmp_path / "w.yaml").write_text(
        "world: w\nspheres:\n"
        "  ball: {radius: 0.5, moves: {through: [[4, 0, 1], [4, 6, 1]], speed: 1}}\n"
    )
    (tmp_path / "m.yaml").write_text(
        "mission: m\nworld: w.yaml\nstates:\n"
        "  up: {do: takeoff, with: {altitude: 1.5 m}, on: {done: wait}}\n"
        "  wait: {do: hover, after: {12 s: down}}\n"
        "  down: {do: land, on: {done: end}}\n  end: {type: final}\n"
    )
    code, report = flown(str(tmp_path / "m.yaml"), "--fly", "1")
    assert code == 0
    # It comes back to [4, 0, 1] after 12 s: 0.5 m lower, 4 m away, 0.5 m thick.
    assert report["clearance"]["wait"]["distance_m"] == pytest.approx(16.25**0.5 - 0.5, abs=0.1)


def test_flying_needs_the_mission_s_code(hop: Path) -> None:
    result = run_cli("check", str(hop), "--fly", "1", "--no-code")
    assert result.code == 2 and "leave --no-code out" in result.err
