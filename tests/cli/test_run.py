from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from hal import Options, Session
from hal.backends import not_heard
from runner.telemetry import COLUMNS
from tests.cli.run_cli import WALL, run_cli

Write = Callable[[str, str], str]
pytestmark = pytest.mark.usefixtures("undrawn")


def only_run() -> Path:
    (folder,) = Path("runs").iterdir()
    return folder


def events(folder: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (folder / "events.jsonl").read_text("utf-8").splitlines()]


def test_a_run_ends_with_a_summary_and_last_its_folder(hop: str) -> None:
    result = run_cli("run", hop)
    assert result.code == 0
    assert result.err == ""
    assert "✔ hop ended in 'done'" in result.out
    assert result.out.splitlines()[-1] == f"run folder: {only_run()}"


def test_plain_lines_tell_the_states(hop: str) -> None:
    lines = run_cli("run", hop).out.splitlines()
    told = [line.partition("→ ")[2].partition("  ")[0] for line in lines if "→" in line]
    assert told == ["takeoff", "land (done)", "finish (done)"]


def test_the_run_folder_holds_what_was_flown(hop: str) -> None:
    run_cli("run", hop, "--seed", "7", "-p", "height=2m")
    folder = only_run()
    assert (folder / "hop.yaml").read_text() == Path(hop).read_text()
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["mission"] == "hop"
    assert summary["outcome"] == "done"
    assert summary["success"] is True
    assert summary["seed"] == 7
    assert summary["parameters"] == {"height": 2.0}
    assert summary["engine"].split()[0] in ("pybullet", "mujoco")
    assert summary["versions"]["python"].startswith("3.")
    assert summary["mission_time_s"] > 2
    assert summary["realtime_factor"] > 1
    assert 1.8 < summary["max_altitude_m"] < 2.2
    assert summary["left_ground"] is True


def test_a_flight_that_never_left_the_ground_is_not_praised(write: Write) -> None:
    write("stay.yaml", "states: {a: {after: {1 s: b}}, b: {type: final}}\n")
    result = run_cli("run", "stay.yaml")
    assert result.code == 0
    assert "✔" not in result.out
    assert "– stay ended in 'done', never left the ground" in result.out
    assert json.loads((only_run() / "summary.json").read_text())["left_ground"] is False


def test_the_run_folder_holds_the_files_of_a_document() -> None:
    Path("inside").mkdir()
    Path("inside/d.json").write_text('{"n": null}')
    Path("c.scxml").write_text(
        '<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0"><datamodel>'
        '<data id="d" src="inside/d.json"/></datamodel>'
        '<state id="s"><transition target="f"/></state>'
        '<final id="f"><donedata><content expr="d"/></donedata></final></scxml>'
    )
    assert run_cli("run", "c.scxml").code == 0
    folder = only_run()
    assert (folder / "inside" / "d.json").read_text() == '{"n": null}'
    output = json.loads((folder / "summary.json").read_text())["output"]
    assert output == {"<content>": {"n": None}}


def test_the_log_numbers_its_lines_and_says_what_happened(hop: str) -> None:
    run_cli("run", hop)
    header, *lines = events(only_run())
    assert header["format"] == "vencejo.events"
    assert header["mission"] == "hop"
    assert header["seed"] == 0
    assert [line["seq"] for line in lines] == list(range(len(lines)))
    entered = [line["state"] for line in lines if line["kind"] == "enter"]
    assert entered == ["", "takeoff", "land", "finish"]
    assert lines[-1]["kind"] == "outcome"
    assert lines[-1]["outcome"] == "done"
    assert all(line["vehicle"] == "drone" for line in lines)


def test_telemetry_has_a_row_for_every_period(hop: str) -> None:
    run_cli("run", hop)
    with (only_run() / "telemetry.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == COLUMNS.split(",")
    times = [float(row["t"]) for row in rows]
    assert times == pytest.approx([0.025 * n for n in range(1, len(rows) + 1)])
    assert rows[0]["state"] == "takeoff"
    assert max(float(row["z"]) for row in rows) == pytest.approx(1.0, abs=0.1)
    assert abs(float(rows[-1]["z"])) < 0.01


def test_json_prints_the_summary_and_nothing_else(hop: str) -> None:
    result = run_cli("run", hop, "--json")
    summary = json.loads(result.out)
    assert summary == json.loads((only_run() / "summary.json").read_text())


def test_another_outcome_is_exit_code_1(write: Write) -> None:
    mission = write("other.yaml", "states: {over: {type: final, outcome: given_up}}")
    result = run_cli("run", mission)
    assert result.code == 1
    assert "✘ other ended in 'given_up'" in result.out


def test_an_unhandled_failure_lands_and_says_why(write: Write) -> None:
    mission = write(
        "far.yaml",
        """
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: go}}
  go: {do: goto, with: {to: "${nowhere[3]}"}, on: {done: down, blocked: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
data: {nowhere: []}
""",
    )
    result = run_cli("run", mission, "--json")
    summary = json.loads(result.out)
    assert result.code == 1
    assert summary["outcome"] == "failed"
    assert "a list of 0 has no element 3" in summary["reason"]
    rows = (only_run() / "telemetry.csv").read_text().splitlines()
    assert rows[-1].split(",")[-2] == "landed"


def test_a_mission_that_ends_in_the_air_is_landed_by_the_host(write: Write) -> None:
    mission = write(
        "air.yaml",
        "states: {up: {do: takeoff, on: {done: over}}, over: {type: final}}",
    )
    result = run_cli("run", mission)
    assert result.code == 0
    assert "landing past the mission" in result.out
    last = (only_run() / "telemetry.csv").read_text().splitlines()[-1]
    assert last.split(",")[-2] == "landed"


def test_two_runs_of_one_second_get_two_folders(hop: str) -> None:
    run_cli("run", hop)
    run_cli("run", hop)
    assert len(list(Path("runs").iterdir())) == 2


def test_runs_dir_puts_them_elsewhere(hop: str) -> None:
    run_cli("run", hop, "--runs-dir", "a/b")
    assert len(list(Path("a/b").iterdir())) == 1


def test_equal_runs_give_equal_bytes(hop: str) -> None:
    first = [run_cli("run", hop, "--noise", "1", "--runs-dir", name, "--json") for name in "ab"]
    assert [result.code for result in first] == [0, 0]
    for name in ("events.jsonl", "telemetry.csv"):
        a, b = (next(Path(folder).iterdir()) / name for folder in "ab")
        assert a.read_bytes() == b.read_bytes()


def test_another_seed_draws_other_noise(hop: str) -> None:
    for seed in ("1", "2"):
        run_cli("run", hop, "--noise", "1", "--seed", seed, "--runs-dir", seed)
    a, b = (next(Path(seed).iterdir()) / "telemetry.csv" for seed in "12")
    assert a.read_bytes() != b.read_bytes()


def test_a_mission_in_the_missions_folder_is_run_by_name(hop: str) -> None:
    Path("missions").mkdir()
    Path(hop).rename("missions/hop.yaml")
    assert run_cli("run", "hop").code == 0


def test_a_world_of_ones_own_lies_beside_the_mission(write: Write) -> None:
    Path("deep").mkdir()
    write("deep/field.yaml", "world: field\nplaces: {tree: [2, 0, 1]}")
    write(
        "deep/go.yaml",
        """
world: field.yaml
states:
  up: {do: takeoff, on: {done: go}}
  go: {do: goto, with: {to: tree}, on: {done: down, blocked: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
""",
    )
    assert run_cli("run", "deep/go.yaml").code == 0
    header = events(only_run())[0]
    assert header["world"] == "field"


@pytest.mark.parametrize(
    ("limits", "refusal"),
    [
        (["max_altitude=80cm"], "takeoff refused: 1 m is above the limit of 0.8 m"),
        (["indoor", "max_altitude=80cm"], "takeoff refused: 1 m is above the limit of 0.8 m"),
        (["max_altitude=2m", "max_speed=1m/s"], None),
        (["indoor"], None),
    ],
)
def test_limits_hold_above_home(hop: str, limits: list[str], refusal: str | None) -> None:
    options = [word for limit in limits for word in ("--limit", limit)]
    result = run_cli("run", hop, *options, "--json")
    reason = json.loads(result.out)["reason"]
    assert result.code == (1 if refusal else 0)
    assert reason == (f"nothing handled failed: {refusal}" if refusal else None)


def test_the_address_reaches_the_backend(hop: str, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[Options] = []

    def opened(name: str, options: Options) -> Session:
        told.append(options)
        raise not_heard("drone", options)

    monkeypatch.setattr("runner.loop.open_backend", opened)
    result = run_cli("run", hop, "--connect", "udpin:127.0.0.1:14540")
    assert result.code == 3
    assert "nothing was heard of 'drone' at 'udpin:127.0.0.1:14540' within 10 s" in result.err
    assert [options.address for options in told] == ["udpin:127.0.0.1:14540"]
    assert not Path("runs").exists()


def test_mavlink_is_not_there_yet(hop: str) -> None:
    result = run_cli("run", hop, "--backend", "mavlink")
    assert result.code == 2  # nothing was to be had, nothing has failed
    assert "not there yet" in result.err
    assert not Path("runs").exists()


BAD_ARGUMENTS = {
    "mistyped command": (["rnu", "hop.yaml"], "did you mean 'run'?"),
    "mistyped option": (["run", "hop.yaml", "--sped", "2"], "did you mean '--speed'?"),
    "bad backend": (["run", "hop.yaml", "--backend", "mavlnik"], "did you mean 'mavlink'?"),
    "bad speed": (["run", "hop.yaml", "--speed", "fast"], "--speed 2"),
    "zero speed": (["run", "hop.yaml", "--speed", "0"], "neither a factor above 0 nor max"),
    "unknown parameter": (["run", "hop.yaml", "-p", "heigth=2m"], "did you mean 'height'?"),
    "not an assignment": (["run", "hop.yaml", "-p", "height"], "'height' is not name=value"),
    "out of range": (["run", "hop.yaml", "-p", "height=50m"], "allowed is 0.5 m … 5 m"),
    "wrong dimension": (["run", "hop.yaml", "-p", "height=5s"], "'5s' is a time, but a length"),
    "bad unit": (["run", "hop.yaml", "-p", "height=5 mtr"], "'mtr' is no unit"),
    "unknown mission": (["run", "frist_flight"], "did you mean 'first_flight'?"),
    "missing file": (["run", "hpo.yaml"], "did you mean 'hop.yaml'?"),
    "a folder": (["run", "."], "is a folder"),
    "unknown world": (["run", "hop.yaml", "--world", "yrad"], "did you mean 'yard'?"),
    "mistyped profile": (["run", "hop.yaml", "--limit", "indor"], "did you mean 'indoor'?"),
    "mistyped limit": (["run", "hop.yaml", "--limit", "max_sped=1"], "did you mean 'max_speed'?"),
    "bad limit": (["run", "hop.yaml", "--limit", "max_tilt=3m"], "'3m' is a length, but an angle"),
    "no limit": (["run", "hop.yaml", "--limit", "max_speed=0"], "must be a number above 0"),
    "limits that contradict": (
        ["run", "hop.yaml", "--limit", "max_altitude=1m", "--limit", "min_altitude=2m"],
        "must be below",
    ),
    "no address": (["run", "hop.yaml", "--connect", "udpin:127.0.0.1:14540"], "has no address"),
    "no seed": (["run", "hop.yaml", "--seed", "x"], "'x' is not a valid integer"),
}


@pytest.mark.parametrize("case", BAD_ARGUMENTS)
def test_bad_arguments_are_explained_and_nothing_flies(case: str, hop: str) -> None:
    arguments, expected = BAD_ARGUMENTS[case]
    result = run_cli(*arguments)
    assert result.code == 2, result.err
    assert expected in result.err
    assert "Traceback" not in result.err
    assert result.out == ""
    assert not Path("runs").exists()


RED, PLAIN = "\x1b[31m", "\x1b[0m"


def test_plain_lines_tell_why_and_what_it_ran_into(write: Write) -> None:
    result = run_cli("run", write("wall.yaml", WALL))
    assert result.code == 1
    assert "\x1b" not in result.out
    lines = [line[10:] for line in result.out.splitlines()]
    collision = lines.index("  collision with shed")
    assert lines[collision - 1].startswith("→ shed (done)  goto, altitude 1.0 m, battery ")
    assert lines[collision + 1].startswith(
        "→ home (blocked: came no nearer for 15 s)  goto, altitude 1.0 m, battery "
    )
    assert "  collided with shed" in result.out.splitlines()
    assert json.loads((only_run() / "summary.json").read_text())["collisions"] == {"shed": 1}


@pytest.mark.parametrize(
    ("environment", "red"),
    [({"FORCE_COLOR": "1"}, True), ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, False), ({}, False)],
)
def test_collisions_are_red_where_colours_are_wanted(
    write: Write, monkeypatch: pytest.MonkeyPatch, environment: dict[str, str], red: bool
) -> None:
    for name in ("FORCE_COLOR", "NO_COLOR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in {"TERM": "xterm", **environment}.items():
        monkeypatch.setenv(name, value)
    lines = run_cli("run", write("wall.yaml", WALL)).out.splitlines()
    told = [line for line in lines if "collision with" in line or "collided with" in line]
    assert len(told) == 2
    assert [line.startswith(RED) and line.endswith(PLAIN) for line in told] == [red, red]
    assert not any("\x1b" in line for line in lines if line not in told)
