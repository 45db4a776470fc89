"""Fleets: what a vehicle's mission period takes, by the number of vehicles.

    python -m bench.fleets [--json]

Every vehicle flies there and back between two points, 4 m from the next, and is recorded. The time
is this process's CPU time from the opening of the backend to the last byte of the run folder,
divided by the periods of all vehicles; the median of several flights of each number, in turn.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

from bench.machine import machine
from hal.vehicle import PERIODS_PER_SECOND
from runner import Assignment, Plan, Prepared, Recorder, fly, missions, prepare
from vencejo.geometry import Point
from worlds import Start

NUMBERS = (1, 2, 5, 10, 20)
RUNS = 5
GOAL = 1.5
"""The dearest number by the cheapest."""
APART = 4.0
MISSION = """\
mission: there_and_back
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: go}}
  go:
    do: route
    with: {points: "${[[3 * mod(k, 2), 0, 2] for k in [1, 2, 3, 4, 5, 6, 7, 8]]}"}
    on: {done: down, blocked: down}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""


def plan(prepared: Prepared, count: int) -> Plan:
    starts = [Start(Point(0.0, APART * number, 0.0), 0.0) for number in range(count)]
    return Plan({f"v{n}": Assignment(prepared, start=start) for n, start in enumerate(starts)})


def time_of_a_period(planned: Plan) -> float:
    """CPU seconds per vehicle and mission period of one flight."""
    with TemporaryDirectory() as folder:
        began = process_time()
        flown = fly(planned, lambda: Recorder(Path(folder)))
        elapsed = process_time() - began
    seconds = sum(vehicle.mission_time for vehicle in flown.vehicles.values())
    return elapsed / (seconds * PERIODS_PER_SECOND)


def measured() -> dict[int, list[float]]:
    """Times of a period of several flights, by the number of vehicles."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "mission.yaml"
        file.write_text(MISSION)
        prepared = prepare(missions.find(str(file)))
        plans = {count: plan(prepared, count) for count in NUMBERS}
        time_of_a_period(plans[1])  # what is imported and asked once
        times: dict[int, list[float]] = {count: [] for count in NUMBERS}
        for _ in range(RUNS):
            for count, planned in plans.items():
                times[count].append(time_of_a_period(planned))
    return times


def main() -> None:
    times = measured()
    medians = {count: 1e6 * median(each) for count, each in times.items()}
    spread = max(medians.values()) / min(medians.values())
    results = {
        "machine": machine(),
        "microseconds": medians,
        "dearest_by_cheapest": spread,
        "goal": GOAL,
    }
    if "--json" in sys.argv[1:]:
        print(json.dumps(results, indent=2))
        return
    print(f"fleets, CPU time of a vehicle's mission period; {machine()}")
    for count, time in medians.items():
        print(f"  {count:2} vehicle{'s'[: count > 1]:1}  {time:6.0f} µs")
    print(f"  dearest by cheapest  {spread:.2f}; goal ≤ {GOAL}")


if __name__ == "__main__":
    main()
