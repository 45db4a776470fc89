"""Landings on a marked pad by ``land_on``, still and at 1 m/s: one table, or JSON with ``--json``.

    python -m bench.landings [--seeds N] [--first SEED] [--json]

Each seed draws the pad's place (up to 1.5 m beside the vehicle, half of them out of its view) and
heading, a wind of 1 m/s with natural turbulence and gusts to 3 m/s every 8 s, and when the camera
sees nothing: 0.2 to 2 s, every 3 s on average, the frame black. Command noise as in the reference
(``--noise 1``), an AR.Drone 2.0, the marker of 0.5 m (6X6_250) with one of 0.12 m (4X4_50) inside.

The error is the distance over the ground between the middle of the vehicle and that of the pad in
the first mission period in which the vehicle touches it, by the simulator. A try fails when it does
not end on the pad; it ends safe when the vehicle is in the air then, or stands upright on the
ground, its motors off. ``slip`` is how far the vehicle is from there on the pad 5 s later.
"""

from __future__ import annotations

import json
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from math import cos, nan, pi, sin
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

from behaviors import MissionFrame, Pilot, drone_vocabulary
from bench.machine import machine
from fsm import compile_mission, read_mission_text
from hal import Options, Vehicle, open_backend
from hal.vehicle import Camera, Frame
from vencejo.geometry import horizontal_distance
from worlds import load_world
from worlds.motion import pose_at
from worlds.things import Thing

SPEEDS = (0.0, 1.0)
"""Of the pad, m/s."""
PATIENCE = 120.0
"""Seconds of a flight at the most."""
RIDE = 5.0
"""Seconds on the pad after which the slip is measured."""
GOALS = {"median_cm": 3.0, "p95_cm": 8.0, "failed": 2}

WORLD = """
world: landing
start: {{at: [-4, 0], heading: {heading} deg}}
ground: {{color: grass, size: 300 m}}
boxes:
  pad:
    size: [1, 1, 0.3]
    color: blue
    {place}
    marker: {{id: 5, size: 50 cm, dictionary: 6X6_250, inside: {{id: 9, size: 12 cm}}}}
wind:
  speed: 1 m/s
  from: {wind} deg
  gusts: {{to: 3 m/s, duration: 3 s, every: 8 s}}
  turbulence: natural
"""
MISSION = """
mission: landing
data: {tries: 0}
states:
  takeoff: {do: takeoff, with: {altitude: 3 m}, on: {done: near}}
  near:
    do: goto
    with: {to: {x: 0, y: 0, z: 3 m, frame: world}}
    on: {done: pad, blocked: pad}
  pad:
    do: land_on
    with: {marker: {id: 5, size: 50 cm, dictionary: 6X6_250, inside: {id: 9, size: 12 cm}}}
    on:
      done: {target: landed, actions: {set: {tries: $event.tries}}}
      lost: lost
  landed: {type: final, output: {tries: $tries}}
  lost: {type: final, outcome: lost}
"""


@dataclass(frozen=True, slots=True)
class Landing:
    """One try."""

    seed: int
    outcome: str
    error: float | None
    """At the first touch of the pad, metres; None for none."""
    slip: float
    """Metres."""
    safe: bool
    seconds: float
    """From the take-off on."""
    tries: int
    """How often the pad was lost."""
    cpu: float
    """Seconds."""


class Blinking:
    """A camera whose frames are black at times."""

    def __init__(self, camera: Camera, dark: Sequence[tuple[float, float]]) -> None:
        self._camera, self._dark = camera, dark

    def latest(self) -> Frame | None:
        frame = self._camera.latest()
        if frame is None or not any(a <= frame.time <= b for a, b in self._dark):
            return frame
        return replace(frame, image=np.zeros_like(frame.image))


class Blinded:
    """A vehicle with such cameras; all else is the vehicle's own."""

    def __init__(self, vehicle: Vehicle, dark: Sequence[tuple[float, float]]) -> None:
        self._vehicle, self._dark = vehicle, dark

    def __getattr__(self, name: str) -> Any:
        return getattr(self._vehicle, name)

    def camera(self, name: str) -> Camera:
        return Blinking(self._vehicle.camera(name), self._dark)


def drawn_world(speed: float, draw: Random) -> str:
    """The world of a seed; a moving pad is there when the vehicle comes, after 7 s."""
    x, y = draw.uniform(-1.5, 1.5), draw.uniform(-1.5, 1.5)
    heading, along = draw.uniform(-180, 180), draw.uniform(-pi, pi)
    if speed:
        begin, end = ((x + far * cos(along), y + far * sin(along)) for far in (-7 * speed, 140.0))
        points = ", ".join(f"[{u:.4f}, {v:.4f}]" for u, v in (begin, end))
        place = f"moves: {{through: [{points}], speed: {speed} m/s, turns: false}}"
    else:
        place = f"at: [{x:.4f}, {y:.4f}]\n    heading: {heading:.2f} deg"
    facts = {"heading": round(draw.uniform(-180, 180), 2), "wind": round(draw.uniform(0, 360), 1)}
    return WORLD.format(place=place, **facts)


def dark_times(draw: Random) -> list[tuple[float, float]]:
    """When the camera sees nothing: begin and end, seconds."""
    found, now = [], 0.0
    while now < PATIENCE:
        now += draw.expovariate(1 / 3.0)
        length = draw.uniform(0.2, 2.0)
        found.append((now, now + length))
        now += length
    return found


def landing(speed: float, seed: int) -> Landing:
    """Fly one seed."""
    began = process_time()
    draw = Random(f"{seed} {speed}")
    graph = compile_mission(read_mission_text(MISSION, "landing.yaml"), drone_vocabulary())
    with TemporaryDirectory() as folder:
        file = Path(folder, "landing.yaml")
        file.write_text(drawn_world(speed, draw), "utf-8")
        pad = next(thing for thing in load_world(file).things if thing.name == "pad")
        options = Options(world=str(file), seed=seed, settings={"noise": 1.0})
        dark = dark_times(draw)
        with open_backend("sim", options) as session:
            vehicle = session.vehicles["drone"]
            session.wait()
            frame = MissionFrame.at_start(vehicle.observe(), session.places, session.geographic)
            seen: Any = Blinded(vehicle, dark)
            pilot = Pilot(graph, seen, frame=frame, seed=seed)
            error = None
            while pilot.outcome is None and session.wait() and vehicle.observe().time < PATIENCE:
                pilot.period()
                if error is None and pilot.instance.is_active("pad"):
                    error = _touch(vehicle, pad)
            now = vehicle.observe()
            safe = now.flying or not (now.armed or now.health)
            ended = now.time
            slip = 0.0
            if error is not None and pilot.outcome == "done":
                before = _beside(vehicle, pad)
                for _ in range(round(RIDE * 40)):
                    session.wait()
                after = _beside(vehicle, pad)
                slip = horizontal_distance(before, after)
    outcome = pilot.outcome or "timeout"
    tries = int(pilot.instance.output.get("tries", 0))
    return Landing(seed, outcome, error, slip, safe, ended, tries, process_time() - began)


def _touch(vehicle: Vehicle, pad: Thing) -> float | None:
    """The distance from the middle of the pad, once the vehicle stands; None before."""
    if vehicle.observe().flying:
        return None
    x, y, z = _beside(vehicle, pad)
    return horizontal_distance((x, y, z), (0.0, 0.0, 0.0))


def _beside(vehicle: Vehicle, pad: Thing) -> tuple[float, float, float]:
    """The place of the vehicle from the middle of the pad's top, metres."""
    seen = vehicle.observe()
    at, _ = pose_at(pad, seen.time)
    x, y, z = seen.position.minus(at)
    return x, y, z


def figures(flown: Sequence[Landing]) -> dict[str, Any]:
    """The figures of some tries."""
    good = [each for each in flown if each.outcome == "done"]
    errors = sorted(100 * each.error for each in good if each.error is not None) or [nan]
    failed = [each for each in flown if each.outcome != "done"]
    return {
        "tries": len(flown),
        "median_cm": round(median(errors), 2),
        "p95_cm": round(errors[max(0, -(-95 * len(errors) // 100) - 1)], 2),
        "worst_cm": round(errors[-1], 2),
        "failed": len(failed),
        "failed_safe": sum(each.safe for each in failed),
        "failed_seeds": [each.seed for each in failed],
        "lost_and_found": sum(each.tries > 0 for each in good),
        "slip_mm": round(1000 * max((each.slip for each in good), default=0.0), 1),
        "seconds": round(median([each.seconds for each in good] or [nan]), 1),
        "cpu_s": round(sum(each.cpu for each in flown), 1),
    }


def main() -> None:
    given = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    given.add_argument("--seeds", type=int, default=100)
    given.add_argument("--first", type=int, default=0)
    given.add_argument("--each", action="store_true", help="show every try")
    given.add_argument("--json", action="store_true")
    arguments = given.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    with ProcessPoolExecutor(2) as pool:
        flown = {
            speed: list(pool.map(partial(landing, speed), seeds, chunksize=1)) for speed in SPEEDS
        }
    found = {f"{speed:g}": figures(each) for speed, each in flown.items()}
    if arguments.json:
        print(json.dumps({"machine": machine(), "goals": GOALS, "pads": found}, indent=2))
        return
    print(machine())
    for speed, each in flown.items():
        for one in each if arguments.each else ():
            print(f"{speed:g} m/s", one)
    width = max(map(len, found["0"]))
    print(f"{'pad':{width}}" + "".join(f"{speed + ' m/s':>12}" for speed in found) + "   goal")
    for name in found["0"]:
        goal = f"   ≤ {GOALS[name]:g}" if name in GOALS else ""
        values = "".join(f"{row[name]!s:>12}" for row in found.values())
        print(f"{name:{width}}{values}{goal}")


if __name__ == "__main__":
    main()
