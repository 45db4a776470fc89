"""CPU time of the safety proof by the size of the mission, and of the whole check of nasty ones.

Goals: 2 s of CPU and 200 MB, whatever the file.

python -m bench.safety [--json]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

from behaviors import drone_vocabulary
from bench.machine import machine
from fsm import Graph, compile_mission, prove, read_mission_text
from tests.fsm.nasty_missions import NASTY, check_usage

GOAL = 2.0
RUNS = 5
LAND = "  land: {do: land, on: {done: end}}\n  end: {type: final}\n"
LEG = "do: goto, with: {to: home}"


def line(states: int) -> str:
    """A mission of ``states`` states: a sequence of legs, each with its own handlers."""
    text = "states:\n"
    for leg in range(states - 2):
        after = f"s{leg + 1}" if leg < states - 3 else "land"
        text += f"  s{leg}: {{{LEG}, on: {{done: {after}, blocked: land, link.lost: land}}}}\n"
    return text + LAND


def regions(states: int, count: int) -> str:
    """A mission of parallel regions with equal shares of the states, all handling the link."""
    share = (states - 3 - count) // count
    text = "states:\n  fly:\n    type: parallel\n    on: {blocked: land}\n    states:\n"
    for region in range(count):
        do = "" if region else LEG
        text += f"      r{region}:\n        states:\n"
        for leg in range(share):
            after = f"s{leg + 1}" if leg < share - 1 else "land"
            outcome = f"done: {after}, " if do else ""
            begin = f"{do}, " if do else f"after: {{5 s: {after}}}, "
            text += f"          s{leg}: {{{begin}on: {{{outcome}link.lost: land}}}}\n"
    return text + LAND


CASES = {
    "a line of 200 states": (line(200), []),
    "two regions, 200 states": (regions(200, 2), []),
    "three regions, 60 states": (regions(60, 3), []),
    "three regions, 120 states": (regions(120, 3), ["not-proven"]),
    "three regions, 200 states": (regions(200, 3), ["not-proven"]),
}
"""Name → mission and the codes of its warnings."""


def seconds(graph: Graph, codes: list[str]) -> list[float]:
    times = []
    for _ in range(RUNS):
        began = process_time()
        found = prove(graph)
        times.append(process_time() - began)
        assert [fault.code for fault in found] == codes
    return times


def main() -> None:
    vocabulary = drone_vocabulary()
    results = {
        name: seconds(compile_mission(read_mission_text(text), vocabulary), codes)
        for name, (text, codes) in CASES.items()
    }
    with TemporaryDirectory() as folder:
        used = {name: check_usage(text, Path(folder) / "m.yaml") for name, text in NASTY.items()}
    most_seconds, megabytes = (max(figures) for figures in zip(*used.values(), strict=True))
    if "--json" in sys.argv[1:]:
        figures = {name: {"median_s": median(t), "max_s": max(t)} for name, t in results.items()}
        figures["whole check"] = {"max_s": most_seconds, "max_mb": megabytes}
        print(json.dumps({"machine": machine(), "goal_s": GOAL, **figures}, indent=2))
        return
    print(f"safety proof, CPU time, {RUNS} runs; goal ≤ {GOAL} s; {machine()}")
    for name, times in results.items():
        print(f"  {name:26} median {median(times):.3f} s, max {max(times):.3f} s")
    print(
        f"  whole check of {len(NASTY)} nasty ones at most {most_seconds:.2f} s, {megabytes:.0f} MB"
    )


if __name__ == "__main__":
    main()
