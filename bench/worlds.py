"""The cost of worlds: flights among boxes, rays, loading. One table, or JSON with ``--json``.

    python -m bench.worlds [--json]

Times are of this process's CPU, since the machine is shared; kinds of runs take turns.
"""

from __future__ import annotations

import json
import sys
from math import cos, pi, sin
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

from bench.machine import machine
from fsm import parse_parameters
from hal.sim.bullet import Bullet
from hal.sim.obstacle_heights import ObstacleHeightGrid
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from vencejo.seeds import generator
from worlds import load_world

ROUNDS = 9
LANE = 8.0
"""Spacing of the grid of boxes, metres, which leaves lanes for the vehicle."""
MISSION = """\
mission: lanes
states:
  up: {do: takeoff, with: {altitude: 1.5 m}, on: {done: round, failed: land}}
  round:
    do: route
    with: {points: [[24, 0, 1.5], [24, 24, 1.5], [-24, 24, 1.5], [-24, 0, 1.5], [0, 0, 1.5]]}
    on: {done: land, blocked: land, failed: land}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


def boxes(count: int) -> str:
    """A world with boxes beside the lanes, the nearest first."""
    random = generator(0, "bench", "boxes")
    grid = [(x + 0.5, y + 0.5) for x in range(-6, 6) for y in range(-6, 6)]
    grid.sort(key=lambda cell: cell[0] ** 2 + cell[1] ** 2)
    text = f"world: boxes_{count}\nground: {{size: 200 m}}\n" + ("boxes:\n" if count else "")
    for number, (x, y) in enumerate(grid[:count]):
        height = random.uniform(2, 4)
        turn = random.uniform(0, pi)
        text += (
            f"  b{number}: {{at: [{LANE * x:.2f}, {LANE * y:.2f}],"
            f" size: [1.5, 1, {height:.2f}], heading: {turn:.2f}}}\n"
        )
    return text


def flights(folder: Path) -> dict[str, float]:
    """Realtime factors of a whole recorded mission among no, 20 and 100 boxes."""
    (folder / "lanes.yaml").write_text(MISSION)
    plans = {}
    for count in (0, 20, 100):
        file = folder / f"boxes_{count}.yaml"
        file.write_text(boxes(count))
        prepared = prepare(missions.find(str(folder / "lanes.yaml")), str(file))
        plans[count] = Plan.alone(prepared, parse_parameters(prepared.graph, {}))
    factors: dict[int, list[float]] = {count: [] for count in plans}
    for number in range(ROUNDS):
        for count, plan in plans.items():
            runs = folder / f"{number}_{count}"
            runs.mkdir()
            begin = process_time()
            flown = fly(plan, lambda runs=runs: Recorder(runs))  # type: ignore[misc]
            factors[count].append(flown.mission_time / (process_time() - begin))
            assert flown.alone.outcome == "done", flown.alone.reason
    middle = {count: median(values) for count, values in factors.items()}
    return {
        "no boxes, times real time": middle[0],
        "20 boxes, times real time": middle[20],
        "100 boxes, times real time": middle[100],
        "100 boxes over none, time": median(
            none / many for none, many in zip(factors[0], factors[100], strict=True)
        ),
    }


def rays(folder: Path, reach: float) -> float:
    """Batches per second of 64 horizontal rays of ``reach`` metres among 100 boxes."""
    physics = Bullet()
    physics.add_things(load_world(folder / "boxes_100.yaml").things)
    ends = [(reach * cos(k * pi / 32), reach * sin(k * pi / 32), 1.5) for k in range(64)]
    starts = [(0.0, 0.0, 1.5)] * 64
    times = []
    for _ in range(ROUNDS):
        begin = process_time()
        for _ in range(300):
            physics.rays(starts, ends)
        times.append((process_time() - begin) / 300)
    physics.close()
    return 1 / median(times)


def large(random: Random) -> str:
    """A world of 200 x 200 m with 400 things and ten roads."""
    lines = ["world: large", "ground: {size: 200 m}", "start: {at: [0, 0, 90]}"]
    for kind, keys in (
        ("boxes", "size: [1, 2, 3], heading: 0.5"),
        ("houses", "heading: 0.3"),
        ("people", "lying: true"),
        ("trees", "height: 6"),
        ("markers", "id: 3, size: 0.5"),
    ):
        lines.append(f"{kind}:")
        for number in range(80):
            x, y = random.uniform(-95, 95), random.uniform(-95, 95)
            lines.append(f"  {kind}_{number}: {{at: [{x:.1f}, {y:.1f}], {keys}}}")
    lines.append("roads:")
    for number in range(10):
        through = [[x, round(random.uniform(-95, 95), 1)] for x in range(-95, 96, 19)]
        lines.append(f"  road_{number}: {{through: {through}, smooth: true, edges: white}}")
    return "\n".join(lines) + "\n"


def loading(folder: Path) -> dict[str, float]:
    """Time to read the large world, and to build it in the engine, milliseconds."""
    file = folder / "large.yaml"
    file.write_text(large(generator(0, "bench", "large")))
    reading, building = [], []
    for _ in range(ROUNDS):
        begin = perf_counter()
        world = load_world(file)
        between = perf_counter()
        physics = Bullet()
        physics.add_things(world.things, world.ground.terrain)
        ObstacleHeightGrid(world.things, world.ground.terrain, 0.4)
        building.append(perf_counter() - between)
        reading.append(between - begin)
        physics.close()
    return {
        "200 x 200 m, 400 things, read, ms": 1e3 * median(reading),
        "200 x 200 m, 400 things, built, ms": 1e3 * median(building),
    }


def main() -> None:
    with TemporaryDirectory() as name:
        folder = Path(name)
        results = {
            **flights(folder),
            "64 rays of 10 m, batches a second": rays(folder, 10.0),
            "64 rays of 30 m, batches a second": rays(folder, 30.0),
            **loading(folder),
        }
    if "--json" in sys.argv[1:]:
        print(json.dumps({"machine": machine(), **results}, indent=2))
        return
    print(f"worlds; {machine()}")
    for what, figure in results.items():
        print(f"  {what:38}{figure:10.2f}")


if __name__ == "__main__":
    main()
