"""The tag missions: how near they come to where they should be.

    python -m bench.tag_programs [--json] [--seeds N]

With command noise (`--noise 1`); truth is the simulator's. Followers have a table of their own,
`bench.followers`.

- *square*: how far from its start it lands, and the same for the timed square as printed;
- *tag_navigator*: how far from above each roundel it leaves it, and the time from one to the
  next;
- *roundel_follower*: how far it is from above the roundel, every period from the fifth second on.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from math import sqrt
from pathlib import Path
from statistics import median

from bench.machine import machine
from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import horizontal_distance
from worlds import find_world
from worlds.motion import pose_at

SEEDS = 5
TIMED = Path(__file__).parents[1] / "tests" / "fsm" / "lrp" / "square.yaml"


def closure(mission: str | Path, seed: int) -> list[float]:
    """How far from its start a mission lands, metres."""
    flight = fly_mission(mission, noise=1.0, seed=seed)
    return [horizontal_distance(flight.end, flight.track[0][1])]


def left(flight: MissionFlight, state: str) -> list[float]:
    """When it left a state, seconds."""
    return [time for time, kind, f in flight.records if kind == "exit" and f["state"] == state]


def navigated(seed: int) -> tuple[list[float], list[float]]:
    """How far from above each roundel it was when it left it, metres, and the times between."""
    world = find_world("roundel_ring")
    roundels = [thing.at for thing in world.things if thing.kind == "roundel"]
    flight = fly_mission("tag_navigator", noise=1.0, seed=seed)
    places, times = dict(flight.track), left(flight, "navigate.center")
    start = world.starts[0].at
    off = [
        horizontal_distance(places[time].plus(start), roundels[k % len(roundels)])
        for k, time in enumerate(times)
    ]
    return off, [b - a for a, b in pairwise(times)]


def above(seed: int) -> list[float]:
    """How far from above the pulled roundel it was in each period, metres."""
    world = find_world("roundel_walk")
    (roundel,), start = world.things, world.starts[0].at
    flight = fly_mission("roundel_follower", noise=1.0, seed=seed)
    (landing,) = left(flight, "follow")
    return [
        horizontal_distance(pose_at(roundel, time)[0], at.plus(start))
        for time, at in flight.track
        if 5 < time < landing
    ]


def rms(values: Sequence[float]) -> float:
    return sqrt(sum(value * value for value in values) / len(values))


def row(
    runs: Sequence[Sequence[float]], of: Callable[[Sequence[float]], float]
) -> Mapping[str, float]:
    """The median over the seeds of a figure of each run, and the worst single value."""
    return {"median": median(map(of, runs)), "worst": max(max(run) for run in runs)}


def main(arguments: Sequence[str]) -> None:
    given = "--seeds" in arguments
    seeds = range(int(arguments[arguments.index("--seeds") + 1]) if given else SEEDS)
    navigations = [navigated(seed) for seed in seeds]
    found = {
        "square: from its start, m": row([closure("square", seed) for seed in seeds], median),
        "timed square as printed: from its start, m": row(
            [closure(TIMED, seed) for seed in seeds], median
        ),
        "tag_navigator: from above a roundel, m": row([off for off, _ in navigations], median),
        "tag_navigator: from one to the next, s": row([times for _, times in navigations], median),
        "roundel_follower: from above it, RMS and largest, m": row(
            [above(seed) for seed in seeds], rms
        ),
    }
    if "--json" in arguments:
        print(json.dumps({"machine": machine(), "seeds": len(seeds), **found}, indent=2))
        return
    print(f"tag missions, {len(seeds)} seeds with command noise")
    for name, figures in found.items():
        print(f"{name:56}{figures['median']:10.3f}{figures['worst']:10.3f}")


if __name__ == "__main__":
    main(sys.argv[1:])
