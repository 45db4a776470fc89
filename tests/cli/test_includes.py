"""Missions of several files, and fleets, on the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

from tests.cli.run_cli import run_cli

Write = Callable[[str, str], str]
MISSION = """\
states:
  up: {do: takeoff, with: {altitude: 1 m}, on: {done: wait}}
  wait: {include: parts/wait.yaml, with: {pause: 1 s}, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
WAIT = """\
uses: [hello.py]
parameters: {pause: {type: time}}
states: {a: {entry: {call: {hello: {name: you}}}, after: {pause: b}}, b: {type: final}}
"""
HELLO = "from behaviors import action\n\n@action\ndef hello(name: str) -> None: ...\n"
FLEET = "fleet: two\nvehicles: {a: {mission: m.yaml}, b: {mission: m.yaml}}\nuntil: time > 9 s\n"


def written(write: Write, tmp_path: Path) -> str:
    (tmp_path / "parts").mkdir(exist_ok=True)
    write("parts/wait.yaml", WAIT)
    write("parts/hello.py", HELLO)
    return write("m.yaml", MISSION)


def test_a_mission_of_several_files_flies_and_is_kept_whole(
    write: Write, tmp_path: Path, undrawn: None
) -> None:
    path = written(write, tmp_path)
    result = run_cli("run", path, "--json")
    assert result.code == 0
    folder = Path(json.loads(result.out)["run_folder"])
    for name, text in (("m.yaml", MISSION), ("parts/wait.yaml", WAIT), ("parts/hello.py", HELLO)):
        assert (folder / name).read_text() == text
    header, *lines = map(json.loads, (folder / "events.jsonl").read_text().splitlines())
    assert header["files_sha256"] == {
        "parts/wait.yaml": sha256(WAIT.encode()).hexdigest(),
        "parts/hello.py": sha256(HELLO.encode()).hexdigest(),
    }
    assert [line["with"] for line in lines if line["kind"] == "call"] == [{"name": "you"}]
    assert [line["state"] for line in lines if line["kind"] == "enter"] == [
        "", "up", "wait", "wait:wait", "wait.a", "wait.b", "down", "over",
    ]  # fmt: skip


def test_faults_of_an_included_file_have_its_place(write: Write, tmp_path: Path) -> None:
    path = written(write, tmp_path)
    write("parts/wait.yaml", WAIT.replace("after: {pause", "after: {pose"))
    result = run_cli("check", path)
    assert result.code == 2
    assert "parts/wait.yaml:3:59: error: the name 'pose' is unknown" in result.err


def test_a_fleet_tells_the_faults_of_its_missions_once(write: Write, tmp_path: Path) -> None:
    written(write, tmp_path)
    write("m.yaml", MISSION.replace("done: over", "done: ower"))
    result = run_cli("check", write("two.yaml", FLEET))
    assert result.code == 2
    assert result.err.count("unknown-target") == 1
