"""Start-up: whole processes, from the shell's call to their end.

python -m bench.startup [--json]
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from bench.machine import machine

GOALS = {"--help": 0.4, "check first_flight": 0.6, "run first_flight": None}
RUNS = 9


def seconds(arguments: str) -> list[float]:
    """Wall times of a command, one warm-up apart; byte code may be kept, as for users."""
    command = [str(Path(sys.executable).parent / "drone-cli"), *arguments.split()]
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    times = []
    with TemporaryDirectory() as folder:
        for _ in range(RUNS + 1):
            began = perf_counter()
            subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)
            times.append(perf_counter() - began)
    return times[1:]


def main() -> None:
    results = {arguments: seconds(arguments) for arguments in GOALS}
    if "--json" in sys.argv[1:]:
        figures = {
            name: {"median_s": median(times), "min_s": min(times), "max_s": max(times)}
            for name, times in results.items()
        }
        print(json.dumps({"machine": machine(), "goals_s": GOALS, **figures}, indent=2))
        return
    print(f"start-up, whole process, {RUNS} runs after a warm-up; {machine()}")
    for name, times in results.items():
        goal = f"; goal ≤ {GOALS[name]} s" if GOALS[name] else " (with its picture)"
        spread = f"{min(times):.2f} … {max(times):.2f}"
        print(f"  drone-cli {name:20} median {median(times):.2f} s, {spread}{goal}")


if __name__ == "__main__":
    main()
