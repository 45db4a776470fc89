"""This checkout beside an earlier commit: the same jobs, in turns, in one run.

    python -m bench.before_after COMMIT [--rounds 9] [--only JOB] [--json]

The commit is laid out in a temporary folder and run by this interpreter. All figures are CPU time,
children included; each round runs every job once on either side, in changing order. A ratio is the
median of the rounds' ratios, after / before: below 1 is faster now. The byte code of both is made
first, as for somebody who uses them twice.
"""

from __future__ import annotations

import argparse
import compileall
import io
import json
import os
import resource
import subprocess
import sys
import tarfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from bench.machine import machine

ROOT = Path(__file__).parents[1]
GOAL = 1.03
DRONE_CLI = "from cli.main import main; main()"
PROCESSES: Mapping[str, tuple[str, ...]] = {
    "drone-cli --help": ("-c", DRONE_CLI, "--help"),
    "drone-cli check first_flight": ("-c", DRONE_CLI, "check", "first_flight"),
    "drone-cli run first_flight": ("-c", DRONE_CLI, "run", "first_flight", "--runs-dir", "RUNS"),
    "drone-cli run beacon_route": ("-c", DRONE_CLI, "run", "beacon_route", "--runs-dir", "RUNS"),
}
"""Whole processes."""
LATENCY = ("local event", "crossing event", "internal event")
CAMERAS_ROUNDS = 3
"""Its pictures take half a minute."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.before_after")
    parser.add_argument("commit")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--only", choices=PROCESSES, help="time this whole process alone")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    with TemporaryDirectory() as folder:
        before = Path(folder) / "before"
        _lay_out(given.commit, before)
        ratios = _ratios(before, Path(folder) / "runs", given.rounds, given.only)
    if given.json:
        print(json.dumps({"machine": machine(), "goal": GOAL, "ratios": ratios}, indent=2))
        return
    print(f"after / before {given.commit}, CPU time, median of rounds; {machine()}")
    for job, found in ratios.items():
        spread = f"({min(found):.3f} … {max(found):.3f})"
        print(f"  {job:36} {median(found):.3f} {spread}; goal ≤ {GOAL}")


def _lay_out(commit: str, folder: Path) -> None:
    archive = subprocess.run(
        ["git", "archive", commit], cwd=ROOT, check=True, capture_output=True
    ).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as files:
        files.extractall(folder, filter="data")
    for place in (folder, ROOT):
        packages = (each.parent for each in place.glob("*/__init__.py"))
        for package in packages:
            compileall.compile_dir(package, quiet=2)


def _ratios(before: Path, runs: Path, rounds: int, only: str | None) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for number in range(rounds):
        all_jobs = (_processes, _latency, *((_cameras,) if number < CAMERAS_ROUNDS else ()))
        for sides in (partial(_processes, only=only),) if only else all_jobs:
            places = (before, ROOT) if number % 2 else (ROOT, before)
            figures = {place: sides(place, runs) for place in places}
            for job, seconds in figures[ROOT].items():
                found.setdefault(job, []).append(seconds / figures[before][job])
    return found


def _processes(place: Path, runs: Path, only: str | None = None) -> dict[str, float]:
    """CPU seconds of each command."""
    found = {}
    for job in (only,) if only else PROCESSES:
        arguments = PROCESSES[job]
        spent = _children()
        _run(place, tuple(str(runs) if word == "RUNS" else word for word in arguments))
        found[job] = _children() - spent
    return found


def _latency(place: Path, runs: Path) -> dict[str, float]:
    """Microseconds of each kind of event, by the bench of that checkout."""
    told = _run(place, ("-m", "bench.latency", "--json", "--alone"))
    (microseconds,) = json.loads(told)["latency_us"].values()
    return dict(zip(LATENCY, microseconds, strict=True))


def _cameras(place: Path, runs: Path) -> dict[str, float]:
    """Seconds for a picture of `raster`, and for a second of flight, by that checkout's bench."""
    told = json.loads(_run(place, ("-m", "bench.cameras", "--json")))
    found = {f"raster, {label}": 1 / rate for label, rate in told["fps"]["raster"].items()}
    return found | {f"flight, {job}": 1 / rate for job, rate in told["realtime_factor"].items()}


def _run(place: Path, arguments: tuple[str, ...]) -> str:
    """Run Python in a checkout, and return its output."""
    environment = {**os.environ, "PYTHONPATH": str(place)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
