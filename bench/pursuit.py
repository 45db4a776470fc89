"""A cat that stays 3 m from a mouse, beside the published cat; truth from the simulator.

    python -m bench.pursuit [--json] [--seeds N] [--reference N]

The mouse flies a square of 8 m without lights, turning at up to 90°/s; the seed chooses where the
cat starts and how both are turned. It hovers for 10 s first, then keeps its speed for 30 s. Three
times the camera of the cat sees nothing for 1 s: its picture is grey (what covers the lens hides
more than what covers the mouse). Physics and command noise are on.

"in view": the share of all frames since the mouse was first seen, grey ones included, in which its
middle is in the picture. "distance": RMSE to 3 m since the cat has come to within 15 cm of that,
the grey seconds included, and then without them and the 2 s after each. "again": from the end of a
grey second until the cat says that it sees the mouse. The published cat keeps an area, not a
distance: its error is that to its own mean distance.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from math import cos, inf, pi, sin, sqrt
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from behaviors import Pilot
from behaviors.perception.projection import is_inside, pixels_of
from bench.machine import machine
from fsm.engine.instance import Record
from hal.vehicle import Camera, Frame, Vehicle
from runner import fly_fleet
from vencejo.geometry import Point, distance

SPEEDS = (0.0, 0.5, 1.0, 1.5)
SEEDS, REFERENCE_SEEDS = 20, 3
DISTANCE = 3.0
HOVER, FLIGHT = 10.0, 30.0
"""Seconds for which the mouse hovers, and flies."""
HIDDEN = 1.0
"""Seconds for which it cannot be seen, each time."""
AGAIN = 2.0
"""Goal: seconds until it is seen again."""
RMSE = 0.15
"""Goal, metres."""
IN_VIEW = 0.995
"""Goal."""
NEAR = 4.0
MIDDLE = 0.06
"""Height of the mouse's middle over its place, metres."""
GREY = 128
REFERENCE = Path(__file__).parent / "reference_cat.yaml"
CAT = """\
mission: cat
states:
  takeoff: {do: takeoff, with: {altitude: 2 m}, on: {done: hunt, failed: land}}
  hunt:
    do: pursue
    with: {target: {color: red, size: 52 cm}, distance: 3 m}
    on: {lost: land, failed: land}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""
MOUSE = """\
mission: mouse
states:
  takeoff:
    entry: {{call: {{lights: {{pattern: off}}}}}}
    do: takeoff
    with: {{altitude: 2 m}}
    on: {{done: play, failed: land}}
  play:
    do: evade
    with:
      beacons: [[8, 0, 2], [8, 8, 3], [0, 8, 2], [0, 0, 3]]
      durations: [{hover}, {flight}]
      speeds: [0, {speed}]
    on: {{done: land, failed: land}}
  land: {{do: land, on: {{done: finish}}}}
  finish: {{type: final}}
"""
FLEET = """\
fleet: pursuit
world: empty
vehicles:
  cat: {{mission: cat.yaml, start: {{at: [{x}, {y}], heading: {heading}}}, color: blue}}
  mouse: {{mission: mouse.yaml, start: {{at: [0, 0], heading: {turned}}}, color: red}}
until: mouse.vehicle.mode == 'landing' and time > 10 s
"""


class Veiled:
    """A vehicle whose camera sees nothing at times; it keeps what its camera took."""

    def __init__(self, vehicle: Vehicle, veils: Sequence[float]) -> None:
        self._vehicle = vehicle
        self._veils = veils
        """When each begins, seconds."""
        self.frames: list[Frame] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._vehicle, name)

    def camera(self, name: str) -> Camera:
        return _VeiledCamera(self, self._vehicle.camera(name))

    def seen(self, frame: Frame) -> Frame:
        """The frame as the mission gets it."""
        if not self.frames or self.frames[-1].sequence != frame.sequence:
            self.frames.append(frame)
        if any(begin <= frame.time < begin + HIDDEN for begin in self._veils):
            return replace(frame, image=np.full_like(frame.image, GREY))
        return frame


class _VeiledCamera:
    def __init__(self, vehicle: Veiled, camera: Camera) -> None:
        self._vehicle = vehicle
        self._camera = camera

    def latest(self) -> Frame | None:
        frame = self._camera.latest()
        return None if frame is None else self._vehicle.seen(frame)


@dataclass
class Watch:
    """Veils the cat's camera, and keeps where both were and when the cat saw the mouse."""

    veils: Sequence[float]
    cat: Veiled | None = None
    places: dict[str, list[tuple[float, Point]]] = field(default_factory=dict)
    sights: list[tuple[float, bool]] = field(default_factory=list)

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        name, seen = pilot.vehicle.name, pilot.channel.world
        if name == "cat":
            if self.cat is None:
                self.cat = Veiled(pilot.vehicle, self.veils)
                pilot.channel.vehicle = self.cat  # type: ignore[assignment]
            hunt = pilot.instance.graph.by_path["hunt"].invocation
            assert hunt is not None
            published = pilot.instance.slots[hunt.slot]
            self.sights.append((seen.time, published is not None and published.visible))
        self.places.setdefault(name, []).append((seen.time, seen.position))


class Found(NamedTuple):
    """The figures of a flight; NaN where there is none."""

    first_seen: float
    """Seconds."""
    in_view: float
    """Share."""
    rmse: float
    """Metres."""
    rmse_seen: float
    again: float
    """The longest, seconds."""
    least: float
    """Least distance, metres."""
    near: float
    """Share of the time since it was first seen within NEAR."""


def flown(job: tuple[str, float, int]) -> Found:
    """The figures of one flight: ``ours`` or ``published``, speed (m/s), seed."""
    which, speed, seed = job
    draw = Random(f"{speed} {seed}")
    angle, far = draw.uniform(0, 2 * pi), draw.uniform(4, 8)
    begin = HOVER + 2
    veils = [begin + 10 * k + draw.uniform(3, 8) for k in range(3)]
    with TemporaryDirectory() as folder:
        path = Path(folder)
        cat = CAT if which == "ours" else REFERENCE.read_text("utf-8")
        (path / "cat.yaml").write_text(cat)
        mouse = MOUSE.format(hover=HOVER, flight=FLIGHT, speed=speed)
        (path / "mouse.yaml").write_text(mouse)
        where = {"x": far * cos(angle), "y": far * sin(angle), "heading": draw.uniform(-pi, pi)}
        (path / "fleet.yaml").write_text(FLEET.format(**where, turned=draw.uniform(-pi, pi)))
        watch = Watch(veils)
        fly_fleet(path / "fleet.yaml", seed=seed, noise=1.0, watchers=[watch])
    return figures(watch, own_mean=which != "ours")


def figures(watch: Watch, *, own_mean: bool) -> Found:
    """The figures of what a watch has kept."""
    pairs = zip(watch.places["cat"], watch.places["mouse"], strict=False)
    far = [(time, distance(one, other)) for (time, one), (_, other) in pairs]
    end = HOVER + FLIGHT + 1
    first = next((time for time, visible in watch.sights if visible), inf)
    wanted = DISTANCE
    if own_mean:
        wanted = float(np.mean([d for t, d in far if first + 10 < t < end] or [DISTANCE]))
    there = next((t for t, d in far if t > first and abs(d - wanted) <= RMSE), inf)
    errors = [(t, d - wanted) for t, d in far if there <= t < end]
    clear = [e for t, e in errors if not any(v <= t < v + HIDDEN + AGAIN for v in watch.veils)]
    after = [(t, d) for t, d in far if first <= t < end]
    return Found(
        first,
        _in_view(watch, first, end),
        _rms([e for _, e in errors]),
        _rms(clear),
        max(_again(watch, veil) for veil in watch.veils),
        min((d for _, d in after), default=inf),
        sum(d <= NEAR for _, d in after) / len(after) if after else 0.0,
    )


def _rms(errors: Sequence[float]) -> float:
    return sqrt(sum(e * e for e in errors) / len(errors)) if errors else inf


def _again(watch: Watch, veil: float) -> float:
    """Seconds from the end of a veil until the mouse was seen."""
    end = veil + HIDDEN
    return next((time - end for time, visible in watch.sights if visible and time >= end), inf)


def _in_view(watch: Watch, first: float, end: float) -> float:
    """The share of the frames in which the mouse was in the picture."""
    assert watch.cat is not None
    times = [time for time, _ in watch.places["mouse"]]
    track = np.array([place for _, place in watch.places["mouse"]])
    inside = []
    for frame in watch.cat.frames:
        if first <= frame.time < end:
            place = [np.interp(frame.time, times, track[:, axis]) for axis in range(3)]
            place[2] += MIDDLE
            inside.append(bool(is_inside(frame, pixels_of(frame, [place]))[0]))
    return sum(inside) / len(inside) if inside else 0.0


def table(found: Mapping[tuple[str, float], Sequence[Found]]) -> list[dict[str, Any]]:
    """A row for each cat and speed: medians and worst cases of its seeds."""
    rows = []
    for (which, speed), flights in found.items():
        kept = [each.rmse for each in flights]
        rows.append(
            {
                "cat": which,
                "speed_m_s": speed,
                "seeds": len(flights),
                "first_seen_s": median(each.first_seen for each in flights),
                "in_view_median": median(each.in_view for each in flights),
                "in_view_worst": min(each.in_view for each in flights),
                "rmse_m_median": median(kept),
                "rmse_m_worst": max(kept),
                "rmse_seen_m_median": median(each.rmse_seen for each in flights),
                "rmse_seen_m_worst": max(each.rmse_seen for each in flights),
                "again_s_median": median(each.again for each in flights),
                "again_s_worst": max(each.again for each in flights),
                "least_m": min(each.least for each in flights),
                "near_median": median(each.near for each in flights),
            }
        )
    return rows


def _option(name: str, default: int) -> int:
    words = sys.argv[1:]
    return int(words[words.index(name) + 1]) if name in words else default


def main() -> None:
    seeds = {"ours": _option("--seeds", SEEDS), "published": 0}
    seeds["published"] = _option("--reference", min(REFERENCE_SEEDS, seeds["ours"]))
    jobs = [(w, v, seed) for w, count in seeds.items() for v in SPEEDS for seed in range(count)]
    with ProcessPoolExecutor(2) as pool:
        results = list(pool.map(flown, jobs))
    found: dict[tuple[str, float], list[Found]] = {}
    for (which, speed, _), each in zip(jobs, results, strict=True):
        found.setdefault((which, speed), []).append(each)
    rows = table(found)
    goals = {"in_view": IN_VIEW, "rmse_m": RMSE, "again_s": AGAIN}
    if "--json" in sys.argv[1:]:
        print(json.dumps({"machine": machine(), "goals": goals, "rows": rows}, indent=2))
        return
    print(f"pursuit; {machine()}")
    print(
        f"goals: in view ≥ {IN_VIEW:.1%}, distance RMSE ≤ {RMSE:g} m at {DISTANCE:g} m, seen again "
        f"≤ {AGAIN:g} s after {HIDDEN:g} s without a sight; median (worst)"
    )
    print("cat        m/s  seeds  in view          distance     without veils  again        least")
    for row in rows:
        print(
            f"{row['cat']:10}{row['speed_m_s']:4.1f}{row['seeds']:6}  "
            f"{row['in_view_median']:6.2%} ({row['in_view_worst']:6.2%})  "
            f"{row['rmse_m_median']:.2f} ({row['rmse_m_worst']:.2f}) m  "
            f"{row['rmse_seen_m_median']:.2f} ({row['rmse_seen_m_worst']:.2f}) m  "
            f"{row['again_s_median']:.2f} ({row['again_s_worst']:.2f}) s  {row['least_m']:.2f} m"
        )


if __name__ == "__main__":
    main()
