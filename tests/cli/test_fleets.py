"""Fleets on the command line: run, check, show, missions, and again."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from runner.missions import SHIPPED
from tests.cli.conftest import MISSION
from tests.cli.run_cli import run_cli

Write = Callable[[str, str], str]
FLEET = """\
fleet: pair
description: Two of them.
vehicles:
  cat: {mission: parts/hop.yaml, with: {height: 2 m}}
  mouse: {mission: parts/hop.yaml, start: {at: [0, 5], heading: 90 deg}, color: red}
  lamp: {}
"""


@pytest.fixture
def pair(write: Write, tmp_path: Path, undrawn: None) -> str:
    (tmp_path / "parts").mkdir()
    write("parts/hop.yaml", MISSION)
    return write("pair.yaml", FLEET)


def only_run() -> Path:
    (folder,) = Path("runs").iterdir()
    return folder


def test_a_fleet_flies_and_is_kept_whole(pair: str) -> None:
    result = run_cli("run", pair, "-p", "mouse.height=3m", "--noise", "1")
    assert (result.code, result.err) == (0, "")
    folder = only_run()
    assert folder.name.endswith("-pair")
    assert {path.relative_to(folder).as_posix() for path in folder.rglob("*.*")} == {
        *("pair.yaml", "parts/hop.yaml", "empty.yaml", "events.jsonl", "summary.json"),
        *(f"telemetry/{name}.csv" for name in ("cat", "mouse", "lamp")),
    }
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["fleet"], summary["success"], summary["exit_code"]) == ("pair", True, 0)
    assert {name: flown["mission"] for name, flown in summary["vehicles"].items()} == {
        "cat": "hop",
        "mouse": "hop",
        "lamp": None,
    }
    pairs = {tuple(pair["vehicles"]): pair["distance_m"] for pair in summary["separation"]}
    assert pairs["cat", "mouse"] == pytest.approx(5.0, abs=0.2)
    assert pairs["mouse", "lamp"] == pytest.approx(5.4, abs=0.2)
    lines = result.out.splitlines()
    assert "0:00.0  cat    → takeoff" in lines[0] and "mouse  → takeoff" in lines[1]
    end = lines.index("✔ pair ended")
    assert lines[end + 2].startswith("  nearest: cat and lamp, ")
    assert lines[end + 3 : -1 : 2] == [
        "  ✔ cat (hop) ended in 'done'",
        "  ✔ mouse (hop) ended in 'done'",
        "  – lamp stood",
    ]

    again = run_cli("run", "--again", str(folder), "--runs-dir", "again", "--json")
    assert again.code == 0, again.err
    (repeated,) = Path("again").iterdir()
    for name in ("events.jsonl", "telemetry/cat.csv", "telemetry/mouse.csv", "telemetry/lamp.csv"):
        assert (repeated / name).read_bytes() == (folder / name).read_bytes()


def test_events_of_all_stand_in_one_log_in_their_order(pair: str) -> None:
    assert run_cli("run", pair, "--json").code == 0
    _, *lines = map(json.loads, (only_run() / "events.jsonl").read_text().splitlines())
    assert [line["seq"] for line in lines] == list(range(len(lines)))
    order = ["cat", "mouse", "lamp"]
    moments = [(line["t"], order.index(line["vehicle"])) for line in lines]
    assert moments == sorted(moments)
    ends = {line["vehicle"]: line["outcome"] for line in lines if line["kind"] == "outcome"}
    assert ends == {"cat": "done", "mouse": "done", "lamp": "done"}


def test_until_is_the_reason_of_all(pair: str, write: Write) -> None:
    write("pair.yaml", f"{FLEET}until: cat.vehicle.altitude > 1 m\n")
    result = run_cli("run", pair)
    assert result.code == 0
    assert "✔ pair ended: until cat.vehicle.altitude > 1 m" in result.out
    assert "  ✔ cat (hop) ended in 'done'\n" in result.out
    again = run_cli("run", "--again", str(only_run()), "--json")
    assert again.code == 0 and json.loads(again.out)["ended_by_until"] is True


@pytest.mark.parametrize(
    ("arguments", "message", "hint"),
    [
        (["-p", "height=3m"], "which vehicle's parameter 'height' is", "-p cat.height=3m"),
        (["-p", "dog.height=3m"], "the fleet has no vehicle 'dog'", "known"),
        (["-p", "cat.hight=3m"], "hop has no parameter 'hight'", "did you mean 'height'?"),
        (["-p", "cat.height=3s"], "-p cat.height: error: height=3s", "2 m"),
        (["-p", "cat.height=9m"], "height=9m", ""),
        (["--post", "1s:dog:battery.low"], "there is no vehicle 'dog'", ""),
        (["--post", "1s:lamp:battery.low"], "there is no vehicle 'lamp'", ""),
        (["--post", "1s:cat:battery.lo"], "knows no event 'battery.lo'", "battery.low"),
    ],
)
def test_what_is_asked_of_no_vehicle_is_refused(
    pair: str, arguments: list[str], message: str, hint: str
) -> None:
    result = run_cli("run", pair, *arguments)
    assert result.code == 2
    assert message in result.err and hint in result.err
    assert not Path("runs").exists()


def test_mistakes_are_told_with_their_places(pair: str, write: Write) -> None:
    write("parts/hop.yaml", MISSION.replace("done: land", "done: lnad"))
    write("pair.yaml", FLEET.replace("color: red", "color: rde"))
    for command in ("run", "check", "show"):
        result = run_cli(command, pair)
        assert result.code == 2
        assert result.err.count("[unknown-target]") == 1
        assert "pair.yaml:5:81: error: no colour is called 'rde' [unknown-color]" in result.err


def test_check_looks_at_each_vehicle_from_its_own_start(pair: str, write: Write) -> None:
    assert run_cli("check", pair).out == "pair.yaml: the fleet may fly, 6 states\n"
    result = run_cli("check", pair, "--limit", "max_altitude=1.5m", "--json")
    (report,) = json.loads(result.out)
    assert (report["fleet"], report["errors"], report["unknown"]) == (True, 0, [])
    assert {fault["code"] for fault in report["faults"]} == {"beyond-limits"}
    write(
        "parts/hop.yaml",
        MISSION.replace("{do: land,", "{do: goto, with: {to: [2, 0, 1]},").replace(
            "{done: finish}", "{done: down, blocked: down}"
        )
        + "  down: {do: land, on: {done: finish}}\n",
    )
    write("hut.yaml", "world: hut\nboxes: {hut: {at: [2, 5], size: [1, 1, 3]}}\n")
    result = run_cli("check", pair, "--world", "hut.yaml")
    assert result.code == 0
    leads_into = "warning: mouse: the leg from [0, 0, 1] to [2, 0, 1] leads into the box 'hut'"
    assert result.err.count("warning") == 1 and leads_into in result.err
    assert leads_into in run_cli("run", pair, "--world", "hut.yaml").err


def test_trial_flights_are_told_by_vehicle(pair: str) -> None:
    result = run_cli("check", pair, "--fly", "2", "--noise", "1")
    assert result.code == 0
    for words in ("  cat\n  flown with seeds 0 to 1: 2 done", "  mouse\n  flown", "  nearest "):
        assert words in result.out
    (report,) = json.loads(run_cli("check", pair, "--fly", "1", "--json").out)
    assert list(report["vehicles"]) == ["cat", "mouse"]
    assert [flight["outcome"] for flight in report["vehicles"]["cat"]["flights"]] == ["done"]
    assert report["nearest"]["vehicles"] == ["cat", "lamp"]
    assert report["nearest"]["seed"] == 0


def test_show_shows_the_mission_of_each_vehicle(pair: str) -> None:
    both = run_cli("show", pair)
    assert both.code == 0
    one = run_cli("show", "parts/hop.yaml").out
    assert both.out == f"cat\n{one}\nmouse\n{one}"
    assert run_cli("show", pair, "--vehicle", "mouse").out == one
    svg = run_cli("show", pair, "--vehicle", "mouse", "--format", "svg")
    assert (svg.code, svg.out) == (0, run_cli("show", "parts/hop.yaml", "--format", "svg").out)
    for arguments, hint in (
        (["--format", "svg"], "--vehicle cat"),
        (["--vehicle", "moose"], "did you mean 'mouse'?"),
        (["--vehicle", "lamp"], "cat"),
    ):
        refused = run_cli("show", pair, *arguments)
        assert refused.code == 2 and hint in refused.err


def test_missions_tells_of_a_fleet(pair: str) -> None:
    told = run_cli("missions", pair)
    assert told.code == 0
    for line in ("pair: Two of them.", "  cat    hop", "  lamp   stands", "cat.height"):
        assert line in told.out
    facts = json.loads(run_cli("missions", pair, "--json").out)
    assert facts["fleet"] == "pair"
    assert facts["vehicles"]["cat"]["parameters"]["height"]["default"] == 1.0


def test_a_fleet_is_copied_with_its_missions(undrawn: None) -> None:
    copied = run_cli("missions", "handover", "--copy")
    assert copied.out == (
        "copied to missions/handover.yaml; `drone-cli run handover` now flies your copy\n"
    )
    names = {path.relative_to("missions").as_posix() for path in Path("missions").rglob("*.yaml")}
    assert names == {
        "handover.yaml",
        *(f"parts/{name}.yaml" for name in ("sentry", "relief", "watch_round")),
    }
    for name in names:
        assert (Path("missions") / name).read_bytes() == (SHIPPED / name).read_bytes()
    assert run_cli("run", "handover", "-p", "sentry.tired=99%").code == 0
    assert (only_run() / "parts/watch_round.yaml").exists()
    assert run_cli("missions", "handover", "--copy").code == 2
