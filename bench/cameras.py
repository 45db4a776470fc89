"""Cameras: images per second of each renderer, and missions flown with every frame read.

    python -m bench.cameras [--json]

A world of 20 boxes, 5 markers and a road on patterned ground. Figures are per second of this
process's own CPU time, on one core: other programs on the machine matter less that way, though
they still slow the caches. Vision is not part of it: frames are read and let go.
"""

from __future__ import annotations

import json
import os
import resource
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from math import pi
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

from behaviors import Pilot
from behaviors.perception.annotations import text_line
from bench.machine import machine
from fsm import parse_parameters
from fsm.engine.instance import Record
from hal.renderers import open_renderer, renderer_names
from hal.vehicle import Intrinsics
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from vencejo.errors import UserError
from vencejo.geometry import OPTICAL, Point, Pose, about_y, product
from worlds import World, load_world

SIZES = ((320, 240), (640, 480))
GOALS = {
    "no camera": 150.0,
    "one camera": 20.0,
    "one, noise and distortion": 15.0,
    "two cameras": 10.0,
}
LENS_AND_NOISE = {"noise": 3.0, "distortion": (-0.28, 0.09, 0.001, -0.0008, 0.0)}
RUNS = 5
BATCHES = 7


def write_world(folder: Path) -> Path:
    """Write the world that is rendered, in which things do not touch, and return its path."""
    draw = Random(3)
    places: list[tuple[float, float]] = []
    while len(places) < 25:
        x, y = draw.uniform(-9, 9), draw.uniform(-9, 9)
        # Apart from the place of take-off and from one another.
        if all(abs(x - a) + abs(y - b) > 2.5 for a, b in [(0.0, 0.0), *places]):
            places.append((x, y))
    lines = ["world: bench", "ground: {color: grass, size: 200 m}", "boxes:"]
    for number, (x, y) in enumerate(places[5:]):
        sides = [round(draw.uniform(0.4, 1.2), 3) for _ in range(3)]
        color = [draw.randrange(256) for _ in range(3)]
        turn = round(draw.uniform(0, 180))
        lines.append(
            f"  b{number}: {{at: [{x:.3f}, {y:.3f}], size: {sides}, heading: {turn} deg, "
            f"color: {color}}}"
        )
    lines.append("markers:")
    for number, (x, y) in enumerate(places[:5]):
        lines.append(f"  m{number}: {{at: [{x:.3f}, {y:.3f}], id: {number}, size: 60 cm}}")
    lines += ["roads:", "  road: {through: [[-50, -4], [0, -4], [10, 0], [50, 0]], width: 3 m}"]
    path = folder / "bench.yaml"
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def poses() -> dict[str, Pose]:
    """Two camera poses: down from a height of 6 m, and ahead from the edge, slightly down."""
    tilt = about_y(0.2)
    ahead = product(tilt, OPTICAL)
    down = product(about_y(pi / 2), OPTICAL)
    return {"ventral": (Point(0, 0, 6), down), "front": (Point(-12, 0, 3), ahead)}


def lens(width: int, height: int) -> Intrinsics:
    return Intrinsics.from_field_of_view(width, height, pi / 3)


def rates(world: World, name: str, images: int) -> dict[str, float]:
    """Images per second of CPU time, by pose and size: the median of some batches."""
    renderer, found = open_renderer(name, world, {}), {}
    try:
        for label, pose in poses().items():
            for width, height in SIZES:
                camera, times = lens(width, height), []
                renderer.render(pose, camera, 0.0, {})
                for _ in range(BATCHES):
                    began = process_time()
                    for _ in range(images):
                        renderer.render(pose, camera, 0.0, {})
                    times.append((process_time() - began) / images)
                found[f"{label} {width}x{height}"] = 1 / median(times)
    finally:
        renderer.close()
    return found


@dataclass
class _Reader:
    """Reads every frame of some cameras, and shows it annotated if asked for ``pictures``."""

    cameras: tuple[str, ...]
    pictures: bool = False
    frames: int = 0

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        for name in self.cameras:
            pilot.vehicle.use_camera(name)
            frame = pilot.channel.camera(name).latest()
            if frame is not None:
                self.frames += 1
                if self.pictures:
                    draw = partial(text_line, frame.image, f"{self.frames} frames")
                    pilot.channel.on_picture(name, draw)


def factor(
    world: Path,
    cameras: tuple[str, ...],
    settings: dict[str, object],
    frames: bool | None = None,
    pictures: bool = False,
) -> float:
    """Mission time over CPU time of one flight, its first image included.

    ``frames``: with a run folder, with frames in it or without; None for no run folder.
    ``pictures``: with annotated pictures of every camera in it.
    """
    prepared = prepare(missions.find("first_flight"), str(world))
    plan = Plan.alone(prepared, parse_parameters(prepared.graph, {}), settings=settings)
    with TemporaryDirectory() as folder:
        record = None if frames is None else lambda: Recorder(Path(folder), frames=frames)
        began = process_time()
        flown = fly(plan, record, [_Reader(cameras, pictures)] if cameras else [])
        took = process_time() - began
    assert flown.alone.outcome == "done", flown.alone.reason
    return flown.mission_time / took


def main() -> None:
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    fps: dict[str, dict[str, float] | str] = {}
    with TemporaryDirectory() as folder:
        path = write_world(Path(folder))
        world = load_world(path)
        for name in sorted(renderer_names(), key=lambda name: name != "raster"):
            try:
                fps[name] = rates(world, name, 60 if name == "raster" else 6)
            except UserError as error:
                fps[name] = error.faults[0].message
            if name == "raster":
                # The first of them, so that nothing of the others is in it. Linux counts KiB.
                peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        fly_with = partial(factor, path)
        noisy: dict[str, object] = {"cameras": {"front": LENS_AND_NOISE}}
        jobs = {
            "no camera": partial(fly_with, (), {}),
            "one camera": partial(fly_with, ("front",), {}),
            "one, noise and distortion": partial(fly_with, ("front",), noisy),
            "one camera, run folder": partial(fly_with, ("front",), {}, frames=False),
            "the same, frames kept": partial(fly_with, ("front",), {}, frames=True),
            "the same, and annotated": partial(
                fly_with, ("front",), {}, frames=True, pictures=True
            ),
            "two cameras": partial(fly_with, ("front", "ventral"), {}),
            "one camera, tiny": partial(fly_with, ("front",), {"renderer": "tiny"}),
        }
        factors = {
            name: [job() for _ in range(1 if "tiny" in name else RUNS)]
            for name, job in jobs.items()
        }
    if "--json" in sys.argv[1:]:
        figures = {name: median(values) for name, values in factors.items()}
        results = {"machine": machine(), "goals": GOALS, "fps": fps, "realtime_factor": figures}
        results["raster_peak_mib"] = peak
        print(json.dumps(results, indent=2))
        return
    print(f"cameras, 20 boxes, 5 markers, a road; CPU time of one core; {machine()}")
    for name, found in fps.items():
        if isinstance(found, str):
            print(f"  {name:8} {found}")
            continue
        shown = "   ".join(f"{label} {value:.0f}" for label, value in found.items())
        print(f"  {name:8} pictures a second: {shown}")
    print(
        f"  raster, 200 x 200 m of ground: {peak:.0f} MiB at most, all imports included; goal ≤ 400"
    )
    for name, values in factors.items():
        goal = f"; goal ≥ {GOALS[name]:.0f}" if name in GOALS else ""
        print(
            f"  first_flight, {name:26} {median(values):.0f} times real time, "
            f"{min(values):.0f} … {max(values):.0f}{goal}"
        )


if __name__ == "__main__":
    main()
