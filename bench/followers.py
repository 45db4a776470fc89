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
CAMERA = Point(0.2, 0.0, 0.02)
"""The front camera's place on the vehicle, which keeps its heading."""
PRINTED = {"tolerance": "0.35", "tolerance_distance": "0.4"}
LAWS: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "proportional, as printed": (
        "tag_follower",
        {"gain": "0.2 m/s", "distance": "1.2 m", "lead": "0", **PRINTED},
    ),
    "braking, as printed": (
        "tag_follower_braking",
        {"gain": "0.3 m/s", "distance": "2 m", **PRINTED},
    ),
    "proportional, our values": ("tag_follower", {"lead": "0"}),
    "braking, our values": ("tag_follower_braking", {}),
    "ours, with the marker's velocity": ("tag_follower", {}),
}


def walk_at(speed: float, folder: Path) -> Path:
    """The world `tag_walk` with a marker of that speed, m/s."""
    text = Path(find_world("tag_walk").source).read_text("utf-8")
    path = folder / "tag_walk.yaml"
    path.write_text(text.replace("speed: 15 cm/s", f"speed: {speed} m/s"), "utf-8")
    return path


def errors(flight: MissionFlight, marker: Thing, distance: float) -> list[float]:
    """The distance of the camera from its place before the marker at each period, metres."""
    place = Point(-distance, 0.0, 0.0).minus(CAMERA)
    return [
        pose_at(marker, time)[0].plus(place).minus(at).norm()
        for time, at in flight.track
        if BEGIN <= time < END
    ]


def figures(law: str, speed: float, seeds: int) -> dict[str, float]:
    """The median and the worst error of a law, metres, and the shares that it lost the marker."""
    mission, parameters = LAWS[law]
    distance = float(parameters.get("distance", "1.5 m").split()[0])
    runs, lost = [], 0
    with TemporaryDirectory() as folder:
        world = walk_at(speed, Path(folder))
        (marker,) = (thing for thing in find_world(str(world)).things if thing.name == "held")
        for seed in range(seeds):
            flight = fly_mission(mission, parameters, world=str(world), noise=1.0, seed=seed)
            off = errors(flight, marker, distance)
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
        law: {f"{speed} m/s": figures(law, speed, seeds) for speed in SPEEDS} for law in LAWS
    }
    if "--json" in arguments:
        print(json.dumps({"machine": machine(), "seeds": seeds, **found}, indent=2))
        return
    print(f"following a marker, error of the camera in cm: median RMS of {seeds} seeds / largest")
    print(f"{'law':34}" + "".join(f"{f'{speed} m/s':>20}" for speed in SPEEDS))
    for law, rows in found.items():
        cells = (
            f"{100 * row['rms_m']:.1f} / {100 * row['max_m']:.0f}"
            + (f" lost {row['lost']:.0%}" if row["lost"] else "")
            for row in rows.values()
        )
        print(f"{law:34}" + "".join(f"{cell:>20}" for cell in cells))


if __name__ == "__main__":
    main(sys.argv[1:])
