"""`drone-cli run --again`: a run repeated from its folder, to the last byte of its log."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tests.cli.run_cli import Result, run_cli

Write = Callable[[str, str], str]
pytestmark = pytest.mark.usefixtures("undrawn")

MISSION = """\
mission: all_of_it
uses: [code/jitter.py]
world: ../worlds/here.yaml
parameters:
  height: 1 m
  side: {type: point, default: [1 m, 0.5 m]}
  corners: {type: [point], default: [[1, 0, 1], [0, 0, 1]]}
  word: so
states:
  up: {do: takeoff, with: {altitude: $height}, on: {done: go}}
  go:
    do: jitter
    on: {done: over_there}
  over_there: {include: parts/there.yaml, with: {to: $side}, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
THERE = """\
parameters: {to: {type: point}}
states:
  fly: {do: goto, with: {to: $to}, on: {done: there, blocked: there}}
  there: {type: final}
"""
CODE = """\
from behaviors import Behavior
from hal import Velocity


class Jitter(Behavior):
    '''Fly about by chance, and look.'''

    outcomes = {"done": None}
    requires = ("camera.front", "velocity")
    controls = ("motion",)

    def start(self, flight, progress=None):
        self.left = 20

    def step(self, flight):
        self.left -= 1
        flight.camera("front").latest()
        flight.command(Velocity(flight.rng.uniform(-1, 1), 0.0, 0.0))
        return None if self.left else "done"
"""
WORLD = """\
world: here
ground: {texture: ../images/grass.png}
"""


def only(folder: str) -> Path:
    (found,) = Path(folder).iterdir()
    return found


def again(folder: Path, *more: str) -> Result:
    return run_cli("run", "--again", str(folder), "--runs-dir", "again", *more)


def header(folder: Path) -> dict[str, Any]:
    with (folder / "events.jsonl").open(encoding="utf-8") as file:
        found: dict[str, Any] = json.loads(file.readline())
    return found


def assert_the_same(folder: Path, other: Path) -> None:
    names = ["events.jsonl", "telemetry.csv"]
    names += [p.relative_to(folder).as_posix() for p in folder.glob("frames*/**/*") if p.is_file()]
    for name in names:
        assert (other / name).read_bytes() == (folder / name).read_bytes(), name
    first, second = (json.loads((run / "summary.json").read_text()) for run in (folder, other))
    for fields in (first, second):
        for own in ("wall_time_s", "realtime_factor", "run_folder"):
            del fields[own]
    assert first == second
    assert first["settings"] == header(folder)["settings"]


def test_a_run_with_all_its_settings_is_repeated_to_the_last_byte(write: Write) -> None:
    for folder in ("missions/code", "missions/parts", "worlds", "images"):
        Path(folder).mkdir(parents=True)
    write("missions/all.yaml", MISSION)
    write("missions/parts/there.yaml", THERE)
    write("missions/code/jitter.py", CODE)
    write("worlds/here.yaml", WORLD)
    write("cams.yaml", "front: {width: 64, height: 48, noise: 3}\nback: {pan: 180 deg}")
    cv2.imwrite("images/grass.png", np.full((8, 8, 3), 90, np.uint8))
    given = ("--seed", "5", "--noise", "1", "--cameras", "cams.yaml", "--camera", "ventral:off")
    limits = ("--limit", "indoor", "--limit", "max_speed=80cm/s", "--shadows", "--call-limit", "9s")
    wind = ("--wind", "2m/s@270deg,turbulence=light")
    values = ("-p", "side=[2, 1]", "-p", "word=$x: y", "-p", "height=1.2m")
    result = run_cli("run", "missions/all.yaml", *given, *limits, *wind, *values)
    assert result.code == 0, result.err
    folder = only("runs")
    settings = header(folder)["settings"]
    assert {name: settings[name] for name in ("seed", "backend", "noise", "shadows")} == {
        **{"seed": 5, "backend": "sim", "noise": 1.0},
        "shadows": True,
    }
    assert (settings["profile"], settings["limits"]) == ("indoor", {"max_speed": 0.8})
    assert (settings["call_limit"], settings["renderer"]) == (9.0, "raster")
    assert settings["cameras"]["ventral"] is None
    assert settings["wind"] == wind[1]
    assert settings["cameras"]["back"] == {"pan": pytest.approx(pi)}
    assert settings["parameters"]["word"] == "$x: y"
    assert set(settings["parameters"]) == {"height", "side", "corners", "word"}
    assert set(settings["files"]) == {
        *("all.yaml", "parts/there.yaml", "code/jitter.py", "cams.yaml"),
        *("worlds/here.yaml", "images/grass.png"),
    }
    assert (settings["world"], settings["camera_file"]) == ("worlds/here.yaml", "cams.yaml")
    # Nothing but the run folder is left of it.
    for name in ("missions", "worlds", "images"):
        shutil.rmtree(name)
    Path("cams.yaml").unlink()
    assert again(folder).code == 0
    assert_the_same(folder, only("again"))


def test_what_went_wrong_is_told_without_the_folder_of_the_mission(write: Write) -> None:
    Path("deep").mkdir()
    states = "{a: {entry: [log: '${1 / n}'], after: {1 s: b}}, b: {type: final}}"
    write("deep/m.yaml", f"data: {{n: 0}}\nstates: {states}\n")
    assert run_cli("run", "deep/m.yaml").code == 1
    folder = only("runs")
    assert "deep" not in (folder / "events.jsonl").read_text()
    assert '"where":"m.yaml:2:' in (folder / "events.jsonl").read_text()
    again(folder)
    assert_the_same(folder, only("again"))


def test_a_generated_world_is_repeated_from_its_copy(hop: str) -> None:
    assert run_cli("run", hop, "--world", "roads:17").code == 0
    folder = only("runs")
    assert again(folder).code == 0
    assert_the_same(folder, only("again"))


def test_a_repeated_run_can_be_repeated(hop: str) -> None:
    run_cli("run", hop, "-p", "height=2 m")
    first = only("runs")
    again(first)
    second = only("again")
    assert run_cli("run", "--again", str(second), "--runs-dir", "third", "--json").code == 0
    assert_the_same(first, only("third"))


def test_files_of_one_name_are_both_kept(hop: str, write: Write) -> None:
    """A mission, a world and a camera file may be called the same."""
    Path("a").mkdir()
    Path("b").mkdir()
    write("a/hop.yaml", "world: empty\ndescription: A world called as the mission.")
    write("b/hop.yaml", "front: {width: 64, height: 48}")
    assert run_cli("run", hop, "--world", "a/hop.yaml", "--cameras", "b/hop.yaml").code == 0
    folder = only("runs")
    settings = header(folder)["settings"]
    for name, origin in (("mission", hop), ("world", "a/hop.yaml"), ("camera_file", "b/hop.yaml")):
        assert (folder / settings[name]).read_text() == Path(origin).read_text()
    assert again(folder).code == 0
    assert_the_same(folder, only("again"))


def test_a_file_called_as_one_of_the_run_is_kept_beside_it() -> None:
    Path("summary.json").write_text('{"n": 1}')
    Path("c.scxml").write_text(
        '<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0"><datamodel>'
        '<data id="d" src="summary.json"/></datamodel>'
        '<state id="s"><transition target="f"/></state><final id="f"/></scxml>'
    )
    assert run_cli("run", "c.scxml").code == 0
    folder = only("runs")
    assert header(folder)["settings"]["mission"] == "drone/c.scxml"
    assert (folder / "drone" / "summary.json").read_text() == '{"n": 1}'
    assert again(folder).code == 0
    assert_the_same(folder, only("again"))


@pytest.mark.parametrize("name", ["hop.yaml", "empty.yaml"])
@pytest.mark.parametrize("change", ["changed", "gone"])
def test_a_copy_that_is_not_as_flown_is_refused(name: str, change: str, hop: str) -> None:
    run_cli("run", hop)
    copy = only("runs") / name
    if change == "changed":
        copy.write_text(copy.read_text() + "\n")
    else:
        copy.unlink()
    result = again(only("runs"))
    assert result.code == 2
    assert result.err.startswith(f"{copy}: error: this copy ")
    assert "[changed-copy]" in result.err
    assert not Path("again").exists()


def test_a_run_without_settings_is_refused(hop: str) -> None:
    run_cli("run", hop)
    events = only("runs") / "events.jsonl"
    first, *lines = events.read_text().splitlines(keepends=True)
    fields = json.loads(first)
    del fields["settings"]
    events.write_text(json.dumps(fields) + "\n" + "".join(lines))
    result = again(only("runs"))
    assert result.code == 2
    assert "[no-settings]" in result.err


def test_another_release_is_a_warning(hop: str) -> None:
    run_cli("run", hop)
    events = only("runs") / "events.jsonl"
    events.write_text(events.read_text().replace('"vencejo":"', '"vencejo":"0.', 1))
    result = again(only("runs"))
    assert result.code == 0
    assert "warning: this run was flown by vencejo 0." in result.err


@pytest.mark.parametrize(
    ("more", "left_out"),
    [
        (["hop.yaml"], "MISSION"),
        (["--seed", "0"], "--seed"),
        (["-p", "height=1m"], "--parameter"),
        (["--world", "yard"], "--world"),
        (["--camera", "front:off"], "--camera"),
    ],
)
def test_settings_beside_again_are_refused(more: list[str], left_out: str, hop: str) -> None:
    run_cli("run", hop)
    result = again(only("runs"), *more)
    assert result.code == 2
    assert f"leave out {left_out}" in result.err


PATH = """\
mission: along
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: first}}
  first:
    do: follow_path
    with: {shape: file, file: paths/short.csv}
    on: {done: second, blocked: down}
  second: {include: parts/back.yaml, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
BACK = """\
states:
  fly:
    do: follow_path
    with: {shape: file, file: back.csv}
    on: {done: there, blocked: there}
  there: {type: final}
"""


def test_a_run_with_files_of_paths_is_repeated_by_their_copies(write: Write) -> None:
    for folder in ("missions/paths", "missions/parts"):
        Path(folder).mkdir(parents=True)
    write("missions/along.yaml", PATH)
    write("missions/parts/back.yaml", BACK)
    write("missions/paths/short.csv", "t,x,y,z,yaw\n0,0,0,2,0\n2,2,0,2,1\n4,3,1,2,2\n")
    write("missions/parts/back.csv", "x,y,z\n3,1,2\n0,0,2\n")
    result = run_cli("run", "missions/along.yaml")
    assert result.code == 0, result.err
    folder = only("runs")
    kept = {"along.yaml", "parts/back.yaml", "parts/back.csv", "paths/short.csv"}
    assert kept <= set(header(folder)["settings"]["files"])
    shutil.rmtree("missions")
    assert again(folder).code == 0
    assert_the_same(folder, only("again"))
    (folder / "paths/short.csv").write_text("x,y,z\n0,0,2\n1,0,2\n")
    assert "short.csv: error: this copy is not as it was flown" in again(folder).err


def test_neither_mission_nor_folder_is_an_error() -> None:
    assert run_cli("run").code == 2
    assert "[no-run]" in run_cli("run", "--again", "nothing_there").err
