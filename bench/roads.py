"""How well roads are followed in the simulator: a table, or JSON with ``--json``.

Each road of the families ``narrow_roads`` (bends) and ``corner_roads`` (right angles) is flown by
``follow_road`` at some speeds, and by the published row method, ``road_travel``. The vehicle begins
above the begin of the road, its nose anywhere. Physics are ``real``, with noise of commands,
shadows, and noise of 25 grey levels in each pixel (a tenth of the range); the row method also flies
without shadows and noise in its pictures (``clear``). Figures are by the simulator's own places:

- *ended*: in `done`, within a metre of the road's end;
- *passed*: the share of the centre line that the vehicle passed within half a width of the road;
- *RMSE*: of the vehicle's distance from the centre line, from the first metre on, away from corners
  (1.5 m of them) and from what is beyond the end; median and worst road;
- *corners*: the greatest distance from the centre line within 1.5 m of a corner, less half a
  width: how far it left the road;
- *branch*: flights that left by the wrong road (2 m from the centre line).

    python -m bench.roads [--seeds N] [--height METRES] [--json]
"""

from __future__ import annotations

import json
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from math import acos, sqrt
from statistics import median
from time import process_time
from typing import Any, NamedTuple

import numpy as np

from behaviors import MissionFrame, Pilot, drone_vocabulary
from bench.machine import machine
from fsm import Graph, compile_mission, read_mission, read_mission_text
from hal import Options, VehicleSpec, open_backend
from runner import missions
from worlds import find_world

FAMILIES = ("narrow_roads", "corner_roads")
SPEEDS = (1.0, 2.0)
GOALS = {1.0: 5.0, 2.0: 10.0}
"""Lateral RMSE, cm, by speed, m/s."""
LONGEST = 300.0
"""Seconds after which a flight counts as lost."""
CLEAR = 1.5
"""Metres from a corner that count as at it."""
SHARP = 0.6
"""Turns of the centre line above this are corners, radians."""
SETTINGS = {"physics": "real", "noise": 1.0}
HARD = {"shadows": True, "cameras": {"ventral": {"noise": 25.0}}}
"""What makes pictures hard to read."""
OURS = """
mission: one_road
states:
  up: {{do: takeoff, with: {{altitude: {height}}}, on: {{done: road}}}}
  road: {{do: follow_road, as: seen, with: {{speed: {speed}}}, on: {{done: finish, lost: lost}}}}
  lost: {{type: final, outcome: lost}}
  finish: {{type: final}}
"""


class Job(NamedTuple):
    """One flight."""

    method: str
    """``follow_road`` or ``road_travel``."""
    sight: str
    """``hard`` or ``clear``."""
    speed: float
    world: str
    height: float
    seed: int


@dataclass(frozen=True)
class Flown:
    """How a flight went; metres and seconds."""

    job: Job
    ended: bool
    passed: float
    rmse: float
    off_at_corners: float
    farthest: float
    mean_speed: float
    times_real: float
    """How much faster than the clock, CPU time of one core."""


def graph_of(job: Job) -> Graph:
    if job.method == "road_travel":
        return compile_mission(read_mission(missions.find("road_travel").path), drone_vocabulary())
    text = OURS.format(height=job.height, speed=job.speed)
    return compile_mission(read_mission_text(text, "one_road.yaml"), drone_vocabulary())


def fly(job: Job) -> Flown:
    """Fly a road, and measure by the centre line of its world."""
    begun = process_time()
    settings = {**SETTINGS, **(HARD if job.sight == "hard" else {})}
    options = Options((VehicleSpec("drone"),), job.world, job.seed, settings=settings)
    given = {} if job.method == "follow_road" else {"cruise": job.height, "max_vel": job.speed}
    track = []
    with open_backend("sim", options) as session:
        (vehicle,) = session.vehicles.values()
        session.wait()
        frame = MissionFrame.at_start(vehicle.observe(), session.places, session.geographic)
        pilot = Pilot(graph_of(job), vehicle, given, frame=frame)
        while pilot.outcome is None and vehicle.observe().time < LONGEST:
            session.wait()
            pilot.period()
            if pilot.instance.is_active("road"):
                track.append(vehicle.observe().position[:2])
        taken = process_time() - begun
        return measured(
            job, np.array(track), pilot.outcome == "done", vehicle.observe().time / taken
        )


def measured(job: Job, track: Any, is_done: bool, times_real: float) -> Flown:
    """The figures of a track (n, 2)."""
    main = find_world(job.world).roads[0]
    line = dense(main.points)
    ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    nearest, far = nearest_of(track, line)
    at_corner = np.zeros(len(line), bool)
    for corner in corners(main.points):
        at_corner |= np.hypot(*(line - corner).T) < CLEAR
    moved = np.concatenate([[0.0], np.hypot(*np.diff(track, axis=0).T)]) > 0.1 / 40
    inner = (ways[nearest] > 1.0) & (ways[nearest] < ways[-1] - 0.05)
    straight = far[inner & moved & ~at_corner[nearest]]
    turning = far[inner & at_corner[nearest]]
    return Flown(
        job,
        is_done and bool(np.hypot(*(track[-1] - line[-1])) < 1.0),
        float((nearest_of(line, track)[1] < main.width / 2).mean()),
        sqrt(float((straight**2).mean())) if len(straight) else 0.0,
        max(0.0, float(turning.max()) - main.width / 2) if len(turning) else 0.0,
        float(far.max()),
        float(ways[nearest].max()) / (len(track) / 40),
        times_real,
    )


def dense(points: Sequence[tuple[float, float]], step: float = 0.02) -> Any:
    """Places along a polyline, (n, 2)."""
    parts = []
    for a, b in pairwise(np.array(points)):
        count = max(1, round(float(np.hypot(*(b - a))) / step))
        parts.append(a + (b - a) * np.arange(count)[:, None] / count)
    return np.concatenate([*parts, [points[-1]]])


def nearest_of(places: Any, others: Any) -> tuple[Any, Any]:
    """For each place the number of the nearest of the others, and how far it is."""
    numbers, far = [], []
    for part in np.array_split(places, max(1, len(places) // 200)):
        away = np.hypot(*(part[:, None] - others[None]).transpose(2, 0, 1))
        numbers.append(away.argmin(1))
        far.append(away.min(1))
    return np.concatenate(numbers), np.concatenate(far)


def corners(points: Sequence[tuple[float, float]]) -> list[Any]:
    """The places of a polyline where it turns sharply."""
    found = []
    for (a, b), (_, c) in pairwise(pairwise(map(np.array, points))):
        share = np.dot(b - a, c - b) / (np.hypot(*(b - a)) * np.hypot(*(c - b)))
        if acos(max(-1.0, min(1.0, float(share)))) > SHARP:
            found.append(b)
    return found


def row(flights: Sequence[Flown]) -> dict[str, float]:
    """The figures of some flights by one method at one speed."""
    return {
        "roads": len(flights),
        "ended": sum(flight.ended for flight in flights),
        "passed_percent": round(100 * float(np.mean([flight.passed for flight in flights])), 2),
        "passed_least_percent": round(100 * min(flight.passed for flight in flights), 2),
        "rmse_median_cm": round(100 * median(flight.rmse for flight in flights), 1),
        "rmse_worst_cm": round(100 * max(flight.rmse for flight in flights), 1),
        "off_at_corners_cm": round(100 * max(flight.off_at_corners for flight in flights), 1),
        "wrong_branch": sum(flight.farthest > 2.0 for flight in flights),
        "mean_speed_m_s": round(float(np.mean([flight.mean_speed for flight in flights])), 2),
        "times_real": round(median(flight.times_real for flight in flights), 1),
    }


def jobs(seeds: int, height: float) -> list[Job]:
    """All flights: ours at each speed, the row method at its own, in hard and in clear sight."""
    ours = [("follow_road", "hard", speed) for speed in SPEEDS]
    rows = [("road_travel", sight, 1.0) for sight in ("hard", "clear")]
    return [
        Job(*how, f"{family}:{number}", height, number)
        for family in FAMILIES
        for how in (*ours, *rows)
        for number in range(seeds)
    ]


def main() -> None:
    given = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    given.add_argument("--seeds", type=int, default=20, help="roads of each family")
    given.add_argument("--height", type=float, default=6.0, help="of the flight, metres")
    given.add_argument("--json", action="store_true")
    arguments = given.parse_args()
    with ProcessPoolExecutor(2) as pool:
        flights = list(pool.map(fly, jobs(arguments.seeds, arguments.height)))
    table = {
        f"{family}, {method}, {sight}, {speed:g} m/s": row(chosen)
        for family in FAMILIES
        for method, sight, speed in dict.fromkeys(each.job[:3] for each in flights)
        if (
            chosen := [
                each
                for each in flights
                if each.job.world.startswith(family) and each.job[:3] == (method, sight, speed)
            ]
        )
    }
    if arguments.json:
        print(json.dumps({"machine": machine(), "height_m": arguments.height, **table}, indent=2))
        return
    print(machine())
    print(f"{arguments.seeds} roads of each family, {arguments.height:g} m above them")
    print(
        f"{'':40}{'ended':>7}{'passed, least, %':>18}{'RMSE, worst, cm':>17}{'goal':>6}"
        f"{'off at corners, cm':>20}{'wrong branch':>14}{'m/s':>6}{'× real':>8}"
    )
    for name, figures in table.items():
        speed = float(name.split()[-2])
        goal = f"{GOALS[speed]:g}" if "follow_road" in name else ""
        print(
            f"{name:40}{figures['ended']:>4}/{figures['roads']:<2}"
            f"{figures['passed_percent']:>10.1f}{figures['passed_least_percent']:>8.1f}"
            f"{figures['rmse_median_cm']:>11.1f}{figures['rmse_worst_cm']:>6.1f}{goal:>6}"
            f"{figures['off_at_corners_cm']:>20.1f}{figures['wrong_branch']:>14}"
            f"{figures['mean_speed_m_s']:>6.2f}{figures['times_real']:>8.1f}"
        )


if __name__ == "__main__":
    main()
