"""The speed goals in one run, beside bare pybullet.

    python -m bench.goals [--json]

Shared machines change their speed by more than half from one minute to the next. So all figures
are CPU time, children included, and before each group stands what pybullet alone reaches at that
moment: six steps a mission period with a state read and a push given, nothing else. Divide by it to
compare two machines. The earlier commit draws its picture with matplotlib, which must be installed.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from statistics import median
from time import process_time
from typing import Any, NamedTuple

from bench.first_flight import engine_alone
from bench.machine import machine

BEFORE = "6f127c6"
"""The commit beside which the whole process of a flight is timed."""
FLIGHT = "drone-cli run first_flight"
GROUPS: Mapping[str, tuple[str, ...]] = {
    "compile": ("bench.engine", "--json"),
    "process": ("bench.before_after", BEFORE, "--only", FLIGHT, "--json"),
    "cameras": ("bench.cameras", "--json"),
}


class Figure(NamedTuple):
    """A measured figure and its goal."""

    what: str
    value: float
    unit: str
    goal: float
    at_most: bool
    """True where less is better."""

    @property
    def reached(self) -> bool:
        return self.value <= self.goal if self.at_most else self.value >= self.goal


def figures(found: Mapping[str, Any]) -> list[Figure]:
    """The figures with goals in what the groups of benchmarks printed."""
    compiled = found["compile"]["compile_ms"]
    pictures = found["cameras"]["fps"]["raster"]
    flights = found["cameras"]["realtime_factor"]
    noisy = flights["one, noise and distortion"]
    return [
        Figure("compile 100 plain states", compiled["100 plain"], "ms", 3, True),
        Figure("compile 100 busy states", compiled["100 busy"], "ms", 60, True),
        Figure(
            f"{FLIGHT}, picture included, of {BEFORE}'s time",
            *(median(found["process"]["ratios"][FLIGHT]), "×", 0.6, True),
        ),
        Figure("one camera, every frame read", flights["one camera"], "× real time", 20, False),
        Figure("the same with noise and distortion", noisy, "× real time", 15, False),
        Figure("raster front 320x240", pictures["front 320x240"], "pictures/s", 500, False),
        Figure("raster front 640x480", pictures["front 640x480"], "pictures/s", 250, False),
    ]


def main() -> None:
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    found, alone = {}, {}
    for group, arguments in GROUPS.items():
        alone[group] = median(engine_alone(clock=process_time) for _ in range(5))
        done = subprocess.run(
            [sys.executable, "-m", *arguments], check=True, capture_output=True, text=True
        )
        found[group] = json.loads(done.stdout)
    results = figures(found)
    if "--json" in sys.argv[1:]:
        told = [each._asdict() | {"reached": each.reached} for each in results]
        print(json.dumps({"machine": machine(), "pybullet": alone, "figures": told}, indent=2))
        return
    print(f"speed goals, CPU time of one core; {machine()}")
    for group, factor in alone.items():
        print(f"  pybullet alone before {group:10} {factor:.0f} × real time")
    for each in results:
        value = f"{each.value:.3g}" if each.value < 100 else f"{each.value:.0f}"
        goal = f"{'≤' if each.at_most else '≥'} {each.goal:g}{'' if each.reached else ', missed'}"
        print(f"  {each.what:62} {value} {each.unit}; goal {goal}")


if __name__ == "__main__":
    main()
