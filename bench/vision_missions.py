"""The shipped missions that see: how much faster than the clock they are with their recording.

    python -m bench.vision_missions [--json] [--seeds N]

CPU time of one core, from the first mission period to the last file, opening the world not counted;
every frame that was read and five annotated pictures a second are kept, videos are not made. For
each mission the median and the slowest of N seeds, with command noise 1.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

from bench.machine import machine
from runner import missions, prepare_fleet
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder

GOAL = 10.0
"""Times real time."""
MISSIONS = (
    "follow_road", "road_watch", "road_travel", "sweep_detect", "track_object", "land_on_pad",
    "land_on_moving_pad", "square", "tag_lights", "tag_follower", "tag_follower_braking",
    "roundel_follower", "tag_navigator",
)  # fmt: skip
FLEET = "cat_and_mouse"
"""Two vehicles, of which one sees: times real time of both."""


class _Stopwatch:
    """Takes the CPU time from the first mission period on."""

    def __init__(self) -> None:
        self.began = 0.0

    def show(self, pilot: object, records: object) -> None:
        self.began = self.began or process_time()


def plans(seed: int) -> Iterator[tuple[str, Plan]]:
    settings = {"noise": 1.0}
    for name in MISSIONS:
        prepared = prepare(missions.find(name))
        yield name, Plan.alone(prepared, seed=seed, settings=settings)
    together = prepare_fleet(missions.find(FLEET))
    flown = together.assignments
    yield FLEET, Plan(flown, seed=seed, settings=settings, fleet=together.fleet)


def times_real_time(plan: Plan) -> float:
    watch = _Stopwatch()
    with TemporaryDirectory() as folder:
        flown = fly(plan, lambda: Recorder(Path(folder)), [watch])
        elapsed = process_time() - watch.began
    ends = {name: vehicle.outcome for name, vehicle in flown.vehicles.items()}
    assert set(ends.values()) == {"done"}, (plan.name, plan.seed, ends)
    return flown.mission_time / elapsed


def main() -> None:
    arguments = sys.argv[1:]
    seeds = int(arguments[arguments.index("--seeds") + 1]) if "--seeds" in arguments else 3
    found: dict[str, list[float]] = {}
    for seed in range(seeds):
        for name, plan in plans(seed):
            found.setdefault(name, []).append(times_real_time(plan))
    if "--json" in arguments:
        print(json.dumps({"machine": machine(), "goal": GOAL, "times_real_time": found}, indent=2))
        return
    print(f"recorded flights that see, times real time, {seeds} seeds; {machine()}")
    for name, factors in found.items():
        missed = "" if median(factors) >= GOAL else ", missed"
        print(
            f"  {name:22} {median(factors):6.1f}  slowest {min(factors):6.1f}  ≥ {GOAL:g}{missed}"
        )


if __name__ == "__main__":
    main()
