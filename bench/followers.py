"""Followers of a marker that is carried about: the laws of the second reference, and ours.

    python -m bench.followers [--json] [--seeds N]

Each law flies the mission `tag_follower` or `tag_follower_braking` before a marker of 25 cm that
goes round at a constant speed, with command noise (`--noise 1`). The error is how far the front
camera is from where it should be before the marker, over 40 s from the tenth second on; what is
lost counts with where it waits then. Truth is the simulator's.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from bench.machine import machine
from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import Point
from worlds import find_world
from worlds.motion import pose_at
from worlds.things import Thing

SPEEDS = (0.1, 0.2, 0.3)
"""Of the marker, m/s."""
SEEDS = 3
BEGIN, END = 10.0, 50.0
"""Seconds of the flight that are measured."""
PRINTED = {"tolerance": "0.35", "tolerance_distance": "0.4"}
TRACKING = """
mission: tracking
states:
  up: {do: takeoff, with: {altitude: 1.4 m}, on: {done: track, failed: land}}
  track:
    do: track_object
    with: {camera: front, target: {id: 3, size: 25 cm}, distance: 1.7 m, height: 0 m, align: 0 deg}
    on: {lost: over, failed: land}
    after: {50 s: land}
  land: {do: land, on: {done: finish}}
  over: {do: land, on: {done: lost}}
  finish: {type: final}
  lost: {type: final, outcome: lost}
"""
"""A mission whose behaviour follows by place, as the others do by what the picture shows."""


@dataclass(frozen=True)
class Law:
    """A way to follow a marker."""

    mission: str
    """A name, or a text."""
    parameters: Mapping[str, str]
    place: Point
    """Where the vehicle is to be, from the marker, metres. Its camera is 20 cm ahead, 2 cm up."""


LAWS: Mapping[str, Law] = {
    "proportional, as printed": Law(
        "tag_follower",
        {"gain": "0.72 m/s", "distance": "1.2 m", "lead": "0", **PRINTED},
        Point(-1.4, 0.0, -0.02),
    ),
    "braking, as printed": Law(
        "tag_follower_braking",
        {"gain": "1.08 m/s", "distance": "2 m", **PRINTED},
        Point(-2.2, 0.0, -0.02),
    ),
    "braking": Law("tag_follower_braking", {}, Point(-1.7, 0.0, -0.02)),
    "proportional": Law("tag_follower", {"lead": "0"}, Point(-1.7, 0.0, -0.02)),
    "proportional, and its velocity": Law("tag_follower", {}, Point(-1.7, 0.0, -0.02)),
    "track_object": Law(TRACKING, {}, Point(-1.7, 0.0, 0.0)),
}


def walk_at(speed: float, folder: Path) -> Path:
    """The world `tag_walk` with a marker of that speed, m/s."""
    text = Path(find_world("tag_walk").source).read_text("utf-8")
    path = folder / "tag_walk.yaml"
    path.write_text(text.replace("speed: 15 cm/s", f"speed: {speed} m/s"), "utf-8")
    return path


def errors(flight: MissionFlight, marker: Thing, place: Point) -> list[float]:
    """The distance of the vehicle from its place before the marker in each period, metres."""
    return [
        pose_at(marker, time)[0].plus(place).minus(at).norm()
        for time, at in flight.track
        if BEGIN <= time < END
    ]


def figures(law: Law, speed: float, seeds: int) -> dict[str, float]:
    """The median and the worst error of a law, metres, and the share of flights that ended lost."""
    runs, lost = [], 0
    with TemporaryDirectory() as folder:
        world, mission = walk_at(speed, Path(folder)), law.mission
        if "\n" in mission:
            mission = str(Path(folder) / "tracking.yaml")
            Path(mission).write_text(law.mission, "utf-8")
        (marker,) = (thing for thing in find_world(str(world)).things if thing.name == "held")
        for seed in range(seeds):
            flight = fly_mission(mission, law.parameters, world=str(world), noise=1.0, seed=seed)
            off = errors(flight, marker, law.place)
            runs.append((sqrt(sum(each * each for each in off) / len(off)), max(off)))
            lost += flight.outcome == "lost"
    rms = [each for each, _ in runs]
    return {
        "rms_m": median(rms),
        "worst_rms_m": max(rms),
        "max_m": max(most for _, most in runs),
        "lost": lost / seeds,
    }


def main(arguments: Sequence[str]) -> None:
    seeds = int(arguments[arguments.index("--seeds") + 1]) if "--seeds" in arguments else SEEDS
    found: dict[str, Any] = {
        name: {f"{speed} m/s": figures(law, speed, seeds) for speed in SPEEDS}
        for name, law in LAWS.items()
    }
    if "--json" in arguments:
        print(json.dumps({"machine": machine(), "seeds": seeds, **found}, indent=2))
        return
    print(f"following a marker, error of the camera in cm: median RMS of {seeds} seeds / largest")
    print(f"{'law':34}" + "".join(f"{f'{speed} m/s':>24}" for speed in SPEEDS))
    for law, rows in found.items():
        cells = (
            f"{100 * row['rms_m']:.1f} / {100 * row['max_m']:.0f}"
            + (f" lost {row['lost']:.0%}" if row["lost"] else "")
            for row in rows.values()
        )
        print(f"{law:34}" + "".join(f"{cell:>24}" for cell in cells))


if __name__ == "__main__":
    main(sys.argv[1:])
