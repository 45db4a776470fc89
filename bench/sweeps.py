"""Fields swept and searched in the simulator: one table, or JSON with ``--json``.

    python -m bench.sweeps [--seeds N] [--first N] [--noise X] [--physics SETTING] [--jobs N]

Each seed is another field: convex, concave and with holes in turn. In it lie people (some stand),
orange balls and markers, ten things or more, and four decoys or more: things of the same colours
with other shapes or sizes, and a marker that is not asked for. Truth is the world file. All is
measured on what was flown, with command noise, and takes the harder definition:

- *covered*: the share of the area inside the union of the pictures' outlines on the ground, by the
  frames of the flight, every fourth of them;
- *recall*, *precision*: a finding counts for a thing of its kind within 1 m, once;
- *error*: the largest distance of a finding from its thing;
- *path*: the way flown from the begin of the first lane to the end; beside the best boustrophedon
  of all headings where the area is convex (straight lanes no farther apart, trimmed as ours,
  worked out here by trying 360 headings), elsewhere beside area / lane spacing.
"""

from __future__ import annotations

import json
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import ceil, cos, dist, hypot, pi, sin
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
import shapely
from shapely import LineString, Polygon

from behaviors import Pilot
from behaviors.perception import ground_points
from bench.machine import machine
from fsm import parse_parameters
from fsm.engine.instance import Record
from hal.vehicle import Frame
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from vencejo.polylines import XY
from vencejo.seeds import generator

HEIGHT, SPEED, OVERLAP = 6.0, 2.0, 0.25
KINDS = ("convex", "concave", "holes")
GOALS = {
    "covered": 0.99,
    "recall": 1.0,
    "precision": 0.99,
    "error": 0.3,
    "convex": 1.15,
    "other": 1.35,
}
_BRIGHT = ("orange", "red", "blue", "yellow", "magenta", "cyan")
_WANTED_IDS, _OTHER_ID = (3, 7, 12, 20), 33
_APART, _FROM_EDGE = 2.5, 0.5
_SAME = 1.0


class Thing(NamedTuple):
    """A thing that is to be found."""

    kind: str
    at: XY


class Field(NamedTuple):
    """An area with things in it."""

    kind: str
    outline: list[XY]
    holes: list[list[XY]]
    things: list[Thing]
    world: str
    """Its world file."""

    @property
    def area(self) -> Polygon:
        return Polygon(self.outline, self.holes)


# -- fields -------------------------------------------------------------------------------------


def field_of(seed: int) -> Field:
    """The field of a seed."""
    random = generator(seed, "bench", "sweeps")
    kind = KINDS[seed % len(KINDS)]
    outline = _concave(random) if kind == "concave" else _convex(random)
    holes = _holes(random, outline) if kind == "holes" else []
    turn = random.uniform(-pi, pi)
    outline, *holes = [[_turned(place, turn) for place in each] for each in (outline, *holes)]
    things, text = _strewn(random, Polygon(outline, holes))
    return Field(kind, outline, holes, things, text)


def _turned(place: XY, angle: float) -> XY:
    c, s = cos(angle), sin(angle)
    return round(place[0] * c - place[1] * s + 30, 2), round(place[0] * s + place[1] * c, 2)


def _convex(random: Random) -> list[XY]:
    """A convex polygon of 3 to 8 corners, about 1000 square metres."""
    while True:
        count = random.randint(3, 8)
        angles = sorted(random.uniform(0, 2 * pi) for _ in range(count))
        across = random.uniform(14, 24)
        hull = Polygon([(22 * cos(a), across * sin(a)) for a in angles]).convex_hull
        if 600 < hull.area < 1600:
            return list(hull.exterior.coords)[:-1]


def _concave(random: Random) -> list[XY]:
    """A letter (L, T, U, Z), or a star without symmetry."""
    a, b, w = random.uniform(26, 36), random.uniform(26, 36), random.uniform(10, 14)
    m = a / 2
    letters: list[list[XY]] = [
        [(0, 0), (a, 0), (a, w), (w, w), (w, b), (0, b)],
        [(0, b - w), (m - w / 2, b - w), (m - w / 2, 0), (m + w / 2, 0), (m + w / 2, b - w),
         (a, b - w), (a, b), (0, b)],
        [(0, 0), (a, 0), (a, b), (a - w, b), (a - w, w), (w, w), (w, b), (0, b)],
        [(0, 0), (m + w / 2, 0), (m + w / 2, b - w), (a, b - w), (a, b), (m - w / 2, b),
         (m - w / 2, w), (0, w)],
    ]  # fmt: skip
    choice = random.randrange(5)
    if choice < 4:
        return [(x - a / 2, y - b / 2) for x, y in letters[choice]]
    while True:
        count = random.randint(6, 10)
        star = [
            (r * cos(2 * pi * k / count), r * sin(2 * pi * k / count))
            for k in range(count)
            for r in (random.uniform(13, 24),)
        ]
        if Polygon(star).area > 600 and Polygon(star).convex_hull.area > 1.15 * Polygon(star).area:
            return star


def _holes(random: Random, outline: Sequence[XY]) -> list[list[XY]]:
    """One or two holes inside an outline, 3 m from its edge or more."""
    inside = Polygon(outline).buffer(-3.0)
    holes: list[list[XY]] = []
    for _ in range(200):
        west, south, east, north = inside.bounds
        x, y = random.uniform(west, east), random.uniform(south, north)
        turn, count = random.uniform(0, pi), random.choice((3, 4, 4, 6))
        hole = [
            (x + r * cos(turn + 2 * pi * k / count), y + r * sin(turn + 2 * pi * k / count))
            for k in range(count)
            for r in (random.uniform(3, 5),)
        ]
        if inside.covers(Polygon(hole)) and all(
            Polygon(hole).distance(Polygon(each)) > 3 for each in holes
        ):
            holes.append(hole)
        if len(holes) == 2 - (len(outline) % 2):
            break
    return holes


def _strewn(random: Random, area: Polygon) -> tuple[list[Thing], str]:
    """Things and decoys in an area, and the world file that has them."""
    spots: list[XY] = []
    inner = area.buffer(-_FROM_EDGE)
    west, south, east, north = inner.bounds
    while len(spots) < 17:
        spot = (round(random.uniform(west, east), 2), round(random.uniform(south, north), 2))
        if inner.covers(shapely.Point(spot)) and all(dist(spot, e) >= _APART for e in spots):
            spots.append(spot)
    things: list[Thing] = []
    people, balls, markers, boxes = [], [], [], []

    def at(spot: XY) -> str:
        return f"at: [{spot[0]:g}, {spot[1]:g}], heading: {random.uniform(-3, 3):.2f}"

    for k in range(5):
        things.append(Thing("person", spots[-1]))
        lying = "true" if k < 3 else "false"
        hue = random.choice(_BRIGHT)
        people.append(f"  p{k}: {{{at(spots.pop())}, color: {hue}, lying: {lying}}}")
    for k in range(4):
        things.append(Thing("ball", spots[-1]))
        balls.append(f"  b{k}: {{at: {list(spots.pop())}, radius: 30 cm, color: orange}}")
    for number in _WANTED_IDS:
        things.append(Thing(f"marker {number}", spots[-1]))
        markers.append(f"  m{number}: {{{at(spots.pop())}, id: {number}, size: 50 cm}}")
    markers.append(f"  other: {{{at(spots.pop())}, id: {_OTHER_ID}, size: 50 cm}}")
    decoys = {
        "mat": f"size: [1.75, 0.5, 0.2], color: {random.choice(_BRIGHT)}",
        "crate": "size: [0.55, 0.55, 0.55], color: orange",
        "chest": f"size: [1.2, 0.7, 0.6], color: {random.choice(_BRIGHT)}",
    }
    boxes = [f"  {name}: {{{at(spots.pop())}, {keys}}}" for name, keys in decoys.items()]
    text = [
        "world: sweeps", "origin: {lat: 40.4168, lon: -3.7038, alt: 667 m}",
        "ground: {color: grass, size: 200 m}", "start: {at: [0, 0]}",
        "people:", *people, "spheres:", *balls, "markers:", *markers, "boxes:", *boxes,
    ]  # fmt: skip
    if any(hypot(*thing.at) < 1.5 for thing in things):
        return _strewn(random, area)
    return things, "\n".join(text) + "\n"


# -- flights ------------------------------------------------------------------------------------

MISSION = """\
mission: sweeps
states:
  takeoff: {{do: takeoff, with: {{altitude: {height}}}, on: {{done: search, failed: lost}}}}
  search:
    do: sweep_detect
    with:
      area: {area}
      holes: {holes}
      height: {height}
      speed: {speed}
      overlap: {overlap}
      detect:
        - people
        - {{color: {{color: orange, size: 60 cm, shape: round, kind: ball}}}}
        - {{fiducials: {{ids: {ids}}}}}
    on: {{done: finish, failed: lost}}
  lost: {{type: final, outcome: lost}}
  finish: {{type: final}}
"""


class _Watch:
    """Keeps where frames were taken, the track, and what was found."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.track: list[tuple[float, float, float]] = []
        self.found: dict[str, dict[str, Any]] = {}
        self.time = 0.0

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        pilot.channel.on_frame = self._frame
        searching = pilot.instance.is_active("search")
        if searching:
            self.track.append(pilot.channel.world.position)
            self.time = pilot.channel.now
        for kind, fields in records:
            if kind == "event" and fields["name"] == "thing.found":
                told = fields["fields"]
                if told["status"] != "far":
                    self.found[told["id"]] = told

    def _frame(self, camera: str, frame: Frame) -> None:
        if not self.frames or frame.sequence != self.frames[-1].sequence:
            # Without the picture, which would fill the memory.
            self.frames.append(replace(frame, image=frame.image[:0].copy()))


def flown(seed: int, noise: float, physics: str) -> dict[str, Any]:
    """Fly over the field of a seed; the figures."""
    field = field_of(seed)
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "sweeps.yaml").write_text(
            MISSION.format(
                area=_listed(field.outline), holes=[_listed(hole) for hole in field.holes],
                height=HEIGHT, speed=SPEED, overlap=OVERLAP, ids=list(_WANTED_IDS),
            )
        )  # fmt: skip
        (folder / "field.yaml").write_text(field.world)
        prepared = prepare(missions.find(str(folder / "sweeps.yaml")), str(folder / "field.yaml"))
        values = parse_parameters(prepared.graph, {})
        settings = {"noise": noise, "physics": physics}
        plan = Plan.alone(prepared, values, seed=seed, settings=settings)
        watch, began = _Watch(), perf_counter()
        summary = fly(plan, watchers=[watch])
        wall = perf_counter() - began
    return {
        "seed": seed,
        "kind": field.kind,
        "outcome": summary.alone.outcome,
        **_seen(field, watch.frames),
        **_judged(field.things, watch),
        **_way(field, watch),
        "seconds": round(watch.time, 1),
        "realtime_factor": round(summary.mission_time / wall, 1),
    }


def _listed(places: Sequence[XY]) -> list[list[float]]:
    return [list(place) for place in places]


def _seen(field: Field, frames: Sequence[Frame]) -> dict[str, float]:
    """The share of the area that was in pictures."""
    pictures = []
    for frame in frames[::4]:
        lens = frame.intrinsics
        w, h = lens.width - 0.5, lens.height - 0.5
        corners = ground_points(frame, [[-0.5, -0.5], [w, -0.5], [w, h], [-0.5, h]])
        if np.isfinite(corners).all():
            pictures.append(Polygon(corners[:, :2]))
    union = shapely.union_all(pictures)
    return {"covered": float(union.intersection(field.area).area / field.area.area)}


def _judged(things: Sequence[Thing], watch: _Watch) -> dict[str, Any]:
    """What was found beside what is there."""
    left, errors, false = list(things), [], []
    for told in watch.found.values():
        kind = told["id"].replace("_", " ") if told["kind"] == "marker" else told["kind"]
        near = [
            (dist(told["position"][:2], thing.at), k)
            for k, thing in enumerate(left)
            if thing.kind == kind
        ]
        if near and min(near)[0] <= _SAME:
            error, k = min(near)
            errors.append(error)
            del left[k]
        else:
            false.append(f"{told['id']} at {[round(v, 2) for v in told['position'][:2]]}")
    return {
        "things": len(things),
        "recall": len(errors) / len(things),
        "precision": len(errors) / len(watch.found) if watch.found else 0.0,
        "error_m": round(max(errors, default=0.0), 3),
        "median_error_m": round(median(errors), 3) if errors else 0.0,
        "missed": [f"{thing.kind} at {list(thing.at)}" for thing in left],
        "false": false,
    }


def _way(field: Field, watch: _Watch) -> dict[str, float]:
    """The way flown from the begin of the first lane on, beside the best there is."""
    lens = watch.frames[0].intrinsics
    across = HEIGHT * lens.width / lens.fx * (1 - OVERLAP)
    ahead = HEIGHT * lens.height / lens.fy / 2 * 0.92
    inside = field.area.buffer(0.5)
    shapely.prepare(inside)
    begin = next(
        k for k, place in enumerate(watch.track) if shapely.contains_xy(inside, *place[:2])
    )
    # From the edge of the area to the first lane it is not on its lanes yet: counted all the same.
    line = LineString([place[:2] for place in watch.track[begin:]])
    best = (
        best_boustrophedon(field.outline, across, ahead)
        if field.kind == "convex"
        else field.area.area / across
    )
    return {"path_m": round(line.length, 1), "ratio": round(line.length / best, 3)}


def best_boustrophedon(outline: Sequence[XY], spacing: float, ahead: float) -> float:
    """The shortest way to and fro over a convex area, of 360 headings, metres."""
    lengths = []
    for k in range(360):
        angle = pi * k / 360
        c, s = cos(angle), sin(angle)
        places = [(x * c + y * s, y * c - x * s) for x, y in outline]
        low, high = min(y for _, y in places), max(y for _, y in places)
        count = ceil((high - low) / spacing)
        ends: list[XY] = []
        for number in range(count):
            y = low + (number + 0.5) * (high - low) / count
            crossed = sorted(
                x1 + (x2 - x1) * (y - y1) / (y2 - y1)
                for (x1, y1), (x2, y2) in zip(places, [*places[1:], places[0]], strict=True)
                if (y1 <= y) != (y2 <= y)
            )
            west, east = crossed[0] + ahead, crossed[-1] - ahead
            if west > east:
                west = east = (west + east) / 2
            ends += [(west, y), (east, y)] if number % 2 == 0 else [(east, y), (west, y)]
        lengths.append(sum(dist(a, b) for a, b in pairwise(ends)))
    return min(lengths)


def main() -> None:
    given = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    given.add_argument("--seeds", type=int, default=20)
    given.add_argument("--first", type=int, default=0)
    given.add_argument("--noise", type=float, default=1.0)
    given.add_argument("--physics", default="real")
    given.add_argument("--jobs", type=int, default=2)
    given.add_argument("--json", action="store_true")
    arguments = given.parse_args()
    one = partial(flown, noise=arguments.noise, physics=arguments.physics)
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    with ProcessPoolExecutor(arguments.jobs) as pool:
        rows = list(pool.map(one, seeds))
    if arguments.json:
        print(json.dumps({"machine": machine(), "fields": rows, **together(rows)}, indent=2))
        return
    print(
        f"{len(rows)} fields, {HEIGHT:g} m, {SPEED:g} m/s, noise {arguments.noise:g}; {machine()}"
    )
    print("seed  kind     covered  recall  precision  error cm (median)  path m  ratio  seconds")
    for row in rows:
        print(
            f"{row['seed']:4}  {row['kind']:8}{row['covered']:8.2%}{row['recall']:8.0%}"
            f"{row['precision']:11.0%}{100 * row['error_m']:10.1f}"
            f" ({100 * row['median_error_m']:.1f})"
            f"{row['path_m']:13.0f}{row['ratio']:7.2f}{row['seconds']:9.0f}"
        )
        for what in ("missed", "false"):
            if row[what]:
                print(f"      {what}: {', '.join(row[what])}")
    print("worst (median)")
    for name, figure in together(rows)["figures"].items():
        print(f"  {name:34}{figure['worst']:8.3f} ({figure['median']:.3f})  goal {figure['goal']}")


def together(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The worst and the median of each figure, with its goal."""

    def figure(values: list[float], goal: float, at_most: bool) -> dict[str, Any]:
        worst = max(values) if at_most else min(values)
        sign = "≤" if at_most else "≥"
        return {"worst": worst, "median": median(values), "goal": f"{sign} {goal:g}"}

    convex = [row["ratio"] for row in rows if row["kind"] == "convex"]
    others = [row["ratio"] for row in rows if row["kind"] != "convex"]
    figures = {
        "covered": figure([row["covered"] for row in rows], GOALS["covered"], False),
        "recall": figure([row["recall"] for row in rows], GOALS["recall"], False),
        "precision": figure([row["precision"] for row in rows], GOALS["precision"], False),
        "error, m": figure([row["error_m"] for row in rows], GOALS["error"], True),
    }
    if convex:
        figures["path by the best, convex"] = figure(convex, GOALS["convex"], True)
    if others:
        figures["path by area / spacing, others"] = figure(others, GOALS["other"], True)
    return {"figures": figures}


if __name__ == "__main__":
    main()
