"""What perception costs a frame of 320 × 240: one table, or JSON with ``--json``.

    python -m bench.perception [--frames N] [--json]

CPU time from the image to what is known of the world, in frames with sensor noise of 3 grey levels:

- *road*: the mask, the map of the ground and the line traced on it, as ``follow_road`` does in each
  frame, above the road of `road_town`;
- *blob*: the ball of `pursuit` placed by its colour and size, by the front camera;
- *ArUco* and *AprilTag*: 30 ids looked for, and what is found placed, 2 to 4 m above `marker_yard`;
  beside them all 587 ids of ``APRILTAG_36h11``.
"""

from __future__ import annotations

import json
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Callable, Sequence
from itertools import pairwise
from math import atan2, cos, pi, sin
from random import Random
from statistics import median
from time import process_time
from typing import Any

from behaviors.perception import FiducialDetector, marker_pose, read_color
from behaviors.perception.centre_line import Node, Widths
from behaviors.perception.road_mask import shaded
from behaviors.perception.targets import ColorTarget
from behaviors.road_sight import Look, RoadSight
from bench.machine import machine
from hal.raster import Raster
from hal.sim.sensors.camera_spec import CameraSpec
from hal.sim.sensors.lens import Lens
from hal.vehicle import Frame
from vencejo.geometry import Point, Pose, about_x, about_y, product, yaw_quaternion
from worlds import find_world
from worlds.motion import pose_at

GOAL_MS = 2.0
NOISE = 3.0
HEIGHT = 6.0
"""Above the road, metres: twice as high as that is wide."""
TILT = 0.05
"""Standard deviation of roll and pitch, radians."""
FRONT, VENTRAL = CameraSpec(noise=NOISE), CameraSpec(tilt=pi / 2, noise=NOISE)
Step = Callable[[Frame], object]


def frames(world: str, camera: CameraSpec, poses: Sequence[tuple[Pose, float]]) -> list[Frame]:
    """What a camera sees of a world from some poses, at their times."""
    raster, lens = Raster(find_world(world), {}, False), Lens(camera, 0, ("bench",))
    found = []
    for number, ((at, body), time) in enumerate(poses):
        pose = at, product(body, camera.attitude)
        image = lens.develop([raster.render(pose, lens.pinhole, time, {})], number)
        found.append(Frame(image, number, time, camera.intrinsics, *pose))
    raster.close()
    return found


def leaning(draw: Random, yaw: float) -> tuple[float, float, float, float]:
    """The attitude of a vehicle that flies."""
    lean = product(about_y(draw.gauss(0, TILT)), about_x(draw.gauss(0, TILT)))
    return product(yaw_quaternion(yaw), lean)


class Replay:
    """A camera that gives the frame it is told to."""

    def __init__(self) -> None:
        self.frame: Frame | None = None

    def latest(self) -> Frame | None:
        return self.frame


def road(count: int, draw: Random) -> tuple[list[Frame], Step]:
    """A flight along the first hundred metres of the road, and what follow_road makes of it."""
    points = [Point(x, y, 0.0) for x, y in find_world("road_town").roads[0].points]
    places: list[tuple[Pose, float]] = []
    nodes = []
    for k in range(count):
        way = 5.0 + 90.0 * k / count
        for a, b in pairwise(points):
            length = b.minus(a).norm()
            if way <= length:
                break
            way -= length
        yaw = atan2(b.y - a.y, b.x - a.x)
        x, y = a.x + way * cos(yaw), a.y + way * sin(yaw)
        places.append(((Point(x, y, HEIGHT), leaning(draw, yaw)), k / 20))
        nodes.append(Node(x, y, yaw, 0.0))
    camera = Replay()
    look = Look(shaded(read_color("asphalt"), 0.5), Widths(0.3, 10.0), 1.5)
    sight = RoadSight(camera, look, HEIGHT, 0.0)

    def step(frame: Frame) -> object:
        camera.frame = frame
        sight.update()
        node = nodes[frame.sequence]
        return sight.trace([node]) if sight.width else sight.find((node.x, node.y))

    return frames("road_town", VENTRAL, places), step


def blob(count: int, draw: Random) -> tuple[list[Frame], Step]:
    """Views of a ball from 3 to 8 m, and where its size places it."""
    ball = next(thing for thing in find_world("pursuit").things if thing.name == "ball")
    places: list[tuple[Pose, float]] = []
    for k in range(count):
        time, side, far = k / 20, draw.uniform(-pi, pi), draw.uniform(3.0, 8.0)
        at, _ = pose_at(ball, time)
        eye = at.plus((far * cos(side), far * sin(side), draw.uniform(-0.3, 0.5)))
        yaw = side + pi + draw.uniform(-0.3, 0.3)
        places.append(((eye, leaning(draw, yaw)), time))
    return frames("pursuit", FRONT, places), ColorTarget(read_color("red"), 0.5).look


def markers(dictionary: str, ids: int | None) -> Callable[[int, Random], tuple[list[Frame], Step]]:
    """Views of a yard with markers of two dictionaries, and where they are placed."""
    detector = FiducialDetector(dictionary, None if ids is None else range(ids))

    def measured(count: int, draw: Random) -> tuple[list[Frame], Step]:
        places: list[tuple[Pose, float]] = []
        for k in range(count):
            eye = Point(draw.uniform(-5, 9), draw.uniform(-5, 5), draw.uniform(2.0, 4.0))
            places.append(((eye, leaning(draw, draw.uniform(-pi, pi))), k / 20))

        def step(frame: Frame) -> object:
            found = detector.detect(frame.image).found
            return [marker_pose(frame, each.corners, 0.5) for each in found]

        return frames("marker_yard", VENTRAL, places), step

    return measured


JOBS: dict[str, Callable[[int, Random], tuple[list[Frame], Step]]] = {
    "road": road,
    "blob": blob,
    "ArUco 4X4_50, 30 ids": markers("4X4_50", 30),
    "AprilTag 36h11, 30 ids": markers("APRILTAG_36h11", 30),
    "AprilTag 36h11, 587 ids": markers("APRILTAG_36h11", None),
}


def measure(count: int) -> dict[str, dict[str, float]]:
    """Milliseconds by job."""
    found = {}
    for name, prepare in JOBS.items():
        pictures, step = prepare(count, Random(name))
        times = []
        for frame in pictures:
            begun = process_time()
            step(frame)
            times.append(1e3 * (process_time() - begun))
        times.sort()
        found[name] = {
            "median_ms": round(median(times), 2),
            "p95_ms": round(times[int(0.95 * len(times))], 2),
            "worst_ms": round(times[-1], 2),
        }
    return found


def main() -> None:
    given = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    given.add_argument("--frames", type=int, default=200)
    given.add_argument("--json", action="store_true")
    arguments = given.parse_args()
    found: dict[str, Any] = measure(arguments.frames)
    if arguments.json:
        print(json.dumps({"machine": machine(), "goal_ms": GOAL_MS, "ms": found}, indent=2))
        return
    print(machine())
    print(f"{'ms a frame':26}{'median':>8}{'p95':>8}{'worst':>8}   goal: median ≤ {GOAL_MS:g}")
    for name, row in found.items():
        print(f"  {name:24}" + "".join(f"{value:8.2f}" for value in row.values()))


if __name__ == "__main__":
    main()
