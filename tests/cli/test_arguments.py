"""Arguments that say something else than their writer meant: each is told, none is passed over."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cli.look import hidden_by
from cli.view import show_summary
from tests.cli.run_cli import run_cli
from worlds import find_world


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("nofile.yaml", "`drone-cli missions` lists those there are"),
        ("missions/hopp.yaml", "did you mean 'missions/hop.yaml'?"),
        ("firstflight.yaml", "did you mean 'first_flight'?"),
    ],
)
def test_endings_and_folders_make_no_names_similar(name: str, hint: str) -> None:
    Path("missions").mkdir()
    for file in ("46_noinit.yaml", "missions/hop.yaml", "missions/beacons.yaml"):
        Path(file).write_text("mission: m\nstates: {a: {type: final}}\n")
    result = run_cli("run", name)
    assert result.code == 2
    assert (
        result.err == f"{name}: error: there is no file '{name}' [no-such-file]\n  hint: {hint}\n"
    )


@pytest.mark.parametrize(
    ("files", "mission", "hint"),
    [
        (["noise.py"], "mission: m\nuses: [helpers.py]\nstates: {a: {}}\n", "known: noise.py"),
        (["helper.py"], "mission: m\nuses: [helpers.py]\nstates: {a: {}}\n", "'helper.py'?"),
        (["beacons.yaml"], "mission: m\nstates: {a: {include: circle.yaml}}\n", "known: "),
        (["circles.yaml"], "mission: m\nstates: {a: {include: circle.yaml}}\n", "'circles.yaml'?"),
    ],
)
def test_so_it_is_where_missions_name_files(
    files: list[str], mission: str, hint: str, write: Callable[[str, str], str]
) -> None:
    for file in files:
        write(file, "")
    write("m.yaml", mission)
    assert hint in run_cli("check", "m.yaml").err


@pytest.mark.parametrize("name", ["gen.py", "path.csv", "events.jsonl", "flight.png", "notes.md"])
def test_what_is_no_mission_is_not_read_as_one(name: str, write: Callable[[str, str], str]) -> None:
    write(name, "x: [")
    for command in ("run", "check", "show", "missions"):
        result = run_cli(command, name)
        assert result.code == 2
        assert f"{name}: error: '{name}' is no mission" in result.err
        assert ("under `uses`" in result.err) == (name == "gen.py")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["-p", "height=1m", "-p", "height=2m"], "'height' is set twice"),
        (["-p", "height=1m", "--parameter", " height=1m"], "'height' is set twice"),
        (["--limit", "max_speed=1m/s", "--limit", "max_speed=2m/s"], "'max_speed' is set twice"),
        (["--limit", "indoor", "--limit", "outdoor"], "a profile is set twice"),
        (["--camera", "left:off"], "there is no camera 'left' to switch off"),
        (["--camera", "frnt:off"], "did you mean 'front'?"),
    ],
)
def test_a_flight_that_was_not_meant_does_not_begin(
    arguments: list[str], told: str, hop: str
) -> None:
    result = run_cli("run", hop, *arguments)
    assert (result.code, result.out) == (2, "")
    assert told in result.err
    assert not list(Path("runs").glob("*"))


@pytest.mark.parametrize(
    "option", [["--camera", "top"], ["--at", "0,0,3"], ["--renderer", "raster"], ["--shadows"]]
)
def test_how_a_picture_looks_needs_a_picture(option: list[str]) -> None:
    for more in ([], ["--json"]):
        result = run_cli("worlds", "yard", *option, *more)
        assert (result.code, result.out) == (2, "")
        assert f"{option[0]} is for a picture: --render FILE" in result.err


def test_a_camera_inside_a_thing_is_told_and_the_picture_drawn() -> None:
    result = run_cli("worlds", "yard", "--at", "6,2,1", "--render", "in.png")
    assert result.code == 0
    assert result.err.startswith("--at: warning: the camera is inside 'shed' [inside-thing]\n")
    assert Path("in.png").stat().st_size > 0
    assert run_cli("worlds", "yard", "--at", "6,2,2.6", "--render", "over.png").err == ""


def test_inside_is_measured_in_the_frame_of_a_thing(write: Callable[[str, str], str]) -> None:
    plank = "{at: [0, 0], size: [10, 1, 2], heading: 90 deg}"
    text = f"world: w\nstart: {{at: [9, 9]}}\nboxes: {{plank: {plank}}}\n"
    world = find_world(write("w.yaml", text))

    def told(x: float, y: float, z: float) -> list[str]:
        return [fault.message for fault in hidden_by(world, (x, y, z, 0.0))]

    assert told(0, 4, 1) == ["the camera is inside 'plank'"]
    assert told(4, 0, 1) == told(0, 4, 2.1) == told(0.6, 4, 1) == []
    forest = find_world("forest:3")
    tree = next(thing for thing in forest.things if thing.kind == "tree")
    assert list(hidden_by(forest, (tree.at.x, tree.at.y, tree.at.z + 0.5, 0.0)))


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("run", ["--backend mavlink|sim", "--speed FACTOR|max", "--call-limit TIME|none"]),
        ("worlds", ["--camera front|down|top", "--at x,y,z[,yaw]"]),
        ("show", ["--format text|mermaid|dot|svg|scxml"]),
    ],
)
def test_the_help_shows_small_what_is_typed_small(command: str, words: list[str]) -> None:
    text = " ".join(run_cli(command, "--help").out.split())
    assert [word for word in words if word not in text] == []


@pytest.mark.parametrize(
    ("wall", "factor", "shown"),
    [
        (9.4888, 2.002, "19.0 s flown in 9.5 s (2 × real time), 20.0 m, up to 3.0 m"),
        (0.0657, 289.21, "19.0 s flown in 0.066 s (289 × real time), 20.0 m, up to 3.0 m"),
        (0.2, 95.0, "19.0 s flown in 0.2 s (95 × real time), 20.0 m, up to 3.0 m"),
        (61.26, 0.31, "19.0 s flown in 61 s (0.31 × real time), 20.0 m, up to 3.0 m"),
    ],
)
def test_figures_have_as_many_digits_as_mean_something(
    wall: float, factor: float, shown: str, capsys: pytest.CaptureFixture[str]
) -> None:
    times = {"mission_time_s": 19.0, "wall_time_s": wall, "realtime_factor": factor}
    flown = {"distance_m": 20.03, "max_altitude_m": 2.97, "battery_left": 0.973}
    end = {"success": True, "left_ground": True, "reason": "", "outcome": "done", "mission": "hop"}
    more = {"collisions": {}, "output": {}, "run_folder": ""}
    show_summary({**times, **flown, **end, **more})
    assert capsys.readouterr().out.splitlines()[1] == f"  {shown}, battery 97%"
