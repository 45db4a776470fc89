"""Ctrl-C, SIGTERM, closed pipes and terminals, on a real process."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow
COMMAND = [sys.executable, "-m", "tests.cli.drone_cli"]
ROOT = Path(__file__).parents[2]
LONG = """\
mission: long
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: stay}}
  stay: {do: hover, after: {60 s: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
OWN_WAY = LONG.replace("{60 s: down}", "{60 s: down}, on: {operator.abort: down}").replace(
    "long", "own_way"
)


@contextmanager
def flying(
    mission: str, tmp_path: Path, *options: str, file: str = "m.yaml"
) -> Iterator[subprocess.Popen[str]]:
    """drone-cli in flight: a state `stay` has been entered."""
    (tmp_path / "m.yaml").write_text(mission)
    process = subprocess.Popen(
        [*COMMAND, "run", file, "--speed", "4", *options],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    for line in process.stdout:
        if "→ stay" in line:
            break
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def ended(process: subprocess.Popen[str]) -> tuple[str, str]:
    out, err = process.communicate(timeout=30)
    assert "Traceback" not in err
    return out, err


def run_folder(tmp_path: Path) -> Path:
    (folder,) = (tmp_path / "runs").iterdir()
    return folder


def kinds(tmp_path: Path) -> list[dict[str, object]]:
    lines = (run_folder(tmp_path) / "events.jsonl").read_text().splitlines()
    return [json.loads(line) for line in lines[1:]]


def landed(tmp_path: Path, telemetry: str = "telemetry.csv") -> bool:
    last = (run_folder(tmp_path) / telemetry).read_text().splitlines()[-1].split(",")
    return last[-2] == "landed" and abs(float(last[4])) < 0.05


def test_ctrl_c_once_lands_where_the_mission_says_nothing(tmp_path: Path) -> None:
    with flying(LONG, tmp_path) as process:
        process.send_signal(signal.SIGINT)
        out, _ = ended(process)
    assert process.returncode == 130
    assert "nobody handles operator.abort" in out
    assert landed(tmp_path)
    summary = json.loads((run_folder(tmp_path) / "summary.json").read_text())
    assert summary["outcome"] == "aborted"
    assert summary["success"] is False


def test_ctrl_c_once_is_the_missions_to_handle(tmp_path: Path) -> None:
    with flying(OWN_WAY, tmp_path) as process:
        process.send_signal(signal.SIGINT)
        out, _ = ended(process)
    assert process.returncode == 130
    assert "→ down" in out
    assert landed(tmp_path)


def test_ctrl_c_lands_all_vehicles_of_a_fleet(tmp_path: Path) -> None:
    fleet = "fleet: f\nvehicles: {cat: {mission: m.yaml}, dog: {mission: m.yaml}, lamp: {}}\n"
    (tmp_path / "f.yaml").write_text(fleet)
    with flying(LONG, tmp_path, file="f.yaml") as process:
        process.send_signal(signal.SIGINT)
        out, _ = ended(process)
    assert process.returncode == 130
    for name in ("cat", "dog"):
        assert re.search(rf" {name} +nobody handles operator.abort: landing\n", out)
    assert all(landed(tmp_path, f"telemetry/{name}.csv") for name in ("cat", "dog", "lamp"))
    summary = json.loads((run_folder(tmp_path) / "summary.json").read_text())
    outcomes = {name: flown["outcome"] for name, flown in summary["vehicles"].items()}
    assert outcomes == dict.fromkeys(("cat", "dog", "lamp"), "aborted")


def test_ctrl_c_twice_lands_past_the_mission(tmp_path: Path) -> None:
    stubborn = LONG.replace("{60 s: down}", "{60 s: down}, on: {operator.abort: {}}")
    with flying(stubborn, tmp_path) as process:
        process.send_signal(signal.SIGINT)
        time.sleep(0.3)
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        out, _ = ended(process)
    assert process.returncode == 130
    assert "landing past the mission" in out
    assert landed(tmp_path)


def test_ctrl_c_thrice_stops_the_program(tmp_path: Path) -> None:
    with flying(LONG, tmp_path, "--runs-dir", "runs") as process:
        for _ in range(3):
            process.send_signal(signal.SIGINT)
            time.sleep(0.1)
        _, err = ended(process)
    assert process.returncode == 130
    assert "left to its own failsafe" in err
    assert not landed(tmp_path)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_sigterm_and_hangup_land_at_once(number: signal.Signals, tmp_path: Path) -> None:
    with flying(OWN_WAY, tmp_path) as process:
        process.send_signal(number)
        out, _ = ended(process)
    assert process.returncode == 130
    assert "landing past the mission" in out
    assert "→ down" not in out
    assert landed(tmp_path)


def first_line_of(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """A command whose reader goes away after one line."""
    return subprocess.run(
        f"{' '.join(COMMAND)} {command} | head -1",
        shell=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )


def test_a_reader_that_goes_away_ends_it_quietly(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(LONG)
    done = first_line_of("run m.yaml", tmp_path)
    assert "→ up" in done.stdout
    assert done.stderr == ""
    assert landed(tmp_path)


@pytest.mark.parametrize("command", ["behaviors", "missions", "behaviors goto", "--help"])
def test_lists_end_quietly_too(command: str, tmp_path: Path) -> None:
    done = first_line_of(command, tmp_path)
    assert done.stderr == ""
    assert done.stdout.count("\n") == 1


def test_a_closed_terminal_lands_and_ends(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(LONG)
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(tmp_path)
        os.environ.update(PYTHONPATH=str(ROOT), TERM="xterm", COLUMNS="90", LINES="30")
        os.execv(sys.executable, [*COMMAND, "run", "m.yaml", "--speed", "4"])
    seen = b""
    while b"stay" not in seen or b"\xe2\x96\xb6 stay" not in seen.replace(b"\x1b[1;32m", b""):
        seen += os.read(terminal, 65536)
    os.close(terminal)
    for _ in range(200):
        ended_, status = os.waitpid(child, os.WNOHANG)
        if ended_:
            break
        time.sleep(0.1)
    assert ended_, "still running"
    assert os.WEXITSTATUS(status) == 130
    assert landed(tmp_path)
