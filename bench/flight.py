"""Flights: how much faster than the clock they are, and how still a hover is in wind.

    python -m bench.flight [--json] [--alone]

CPU time of one core, the median of three rounds, each of which makes every job once; beside them
PyFlyt and RotorPy, installed into environments that are thrown away (`--alone` leaves them out;
gym-pybullet-drones is not on the package registry). Ours are whole missions, recorded; opening the
world is not counted. 240 physics steps a second everywhere.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from math import sqrt
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

from bench import fleets
from bench.machine import machine
from bench.peers_flight import PEERS, ROUNDS
from hal import PERIOD
from hal.sim import open_session
from hal.vehicle import Options, Position, VehicleSpec
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from vencejo.errors import UserError, VehicleError
from vencejo.geometry import Point, distance

HOVER = """\
mission: hover
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: stay}}
  stay: {do: hover, after: {30 s: down}}
  down: {do: land, on: {done: end}}
  end: {type: final}
"""
LANES = """\
mission: lanes
world: WORLD
states:
  up: {do: takeoff, with: {altitude: 1.5 m}, on: {done: out}}
  out: {do: goto, with: {to: [34, 0, 1.5], speed: 3 m/s}, on: {done: aside, blocked: stuck}}
  aside: {do: goto, with: {to: [34, 4, 1.5], speed: 3 m/s}, on: {done: back, blocked: stuck}}
  back: {do: goto, with: {to: [2, 4, 1.5], speed: 3 m/s}, on: {done: down, blocked: stuck}}
  down: {do: land, on: {done: end}}
  end: {type: final}
  stuck: {type: final, outcome: failed}
"""
"""Along the lanes of a field of boxes, in the middle between them."""
WIND = "3m/s@270deg,gusts=5m/s"
Settings = Mapping[str, object]
Job = Callable[[], float]


def variants() -> dict[str, Settings]:
    """The settings to fly with, those of them that there are here."""
    chosen: dict[str, Settings] = {"": {}}
    for setting, words in {"physics": ("ideal", "real"), "engine": ("bullet", "mujoco")}.items():
        known = [word for word in words if _opens({setting: word})]
        if known:
            chosen = {
                f"{name}, {word}": {**settings, setting: word}
                for (name, settings), word in product(chosen.items(), known)
            }
    return chosen


def _opens(settings: Settings) -> bool:
    try:
        with open_session(Options(settings=settings)):
            return True
    except (UserError, VehicleError):
        return False


class _Stopwatch:
    """Takes the CPU time from the first mission period on."""

    def __init__(self) -> None:
        self.began = 0.0

    def show(self, pilot: object, records: object) -> None:
        self.began = self.began or process_time()


def recorded(mission: str, settings: Settings) -> float:
    """Times real time of a whole mission with its recording."""
    prepared = prepare(missions.find(mission))
    watch = _Stopwatch()
    with TemporaryDirectory() as folder:
        plan = Plan.alone(prepared, settings=settings)
        flown = fly(plan, lambda: Recorder(Path(folder)), [watch])
        elapsed = process_time() - watch.began
    (vehicle,) = flown.vehicles.values()
    assert vehicle.outcome == "done", vehicle
    return flown.mission_time / elapsed


def rms_of_hover(model: str, wind: str, seconds: float = 60.0) -> float:
    """Root mean square distance from the place where it is told to be, millimetres."""
    place = Point(0.0, 0.0, 5.0)
    drones = (VehicleSpec("drone", model),)
    with open_session(Options(drones, settings={"wind": wind})) as session:
        (vehicle,) = session.vehicles.values()
        order = vehicle.takeoff(place.z)
        while not order.ended:
            session.wait()
        squares = []
        for _ in range(round((seconds + 10.0) / PERIOD)):
            vehicle.command(Position(place, yaw=0.0))
            session.wait()
            squares.append(distance(vehicle.observe().position, place) ** 2)
    settled = squares[round(10.0 / PERIOD) :]
    return sqrt(sum(settled) / len(settled)) * 1e3


def field(folder: Path, boxes: bool) -> str:
    """The mission through the lanes, in a world with a hundred boxes 4 m apart or without."""
    rows = product(range(10), range(10))
    lines = [f"  b{x}{y}: {{at: [{4 * x}, {4 * y - 18}], size: [1, 1, 3]}}" for x, y in rows]
    world = f"{'full' if boxes else 'empty'}_field"
    text = f"world: {world}\nstart: {{at: [0, 0]}}\n"
    (folder / f"{world}.yaml").write_text(text + "\n".join(["boxes:", *lines] if boxes else []))
    mission = folder / f"{world}_lanes.yaml"
    mission.write_text(LANES.replace("WORLD", f"{world}.yaml"))
    return str(mission)


def jobs(folder: Path) -> Iterator[tuple[str, str, Job]]:
    """Name, unit and job of each figure of ours."""
    hover = folder / "hover.yaml"
    hover.write_text(HOVER)
    for name, settings in variants().items():
        for label, mission in (("hover", str(hover)), ("first_flight", "first_flight")):
            yield f"{label}{name}", "× real time", lambda m=mission, s=settings: recorded(m, s)
    shuttle = folder / "there_and_back.yaml"
    shuttle.write_text(fleets.MISSION)
    prepared = prepare(missions.find(str(shuttle)))
    for count in fleets.NUMBERS:
        flown = partial(fleets.time_of_a_period, fleets.plan(prepared, count))
        yield f"fleet of {count}", "µs per vehicle-period", lambda f=flown: 1e6 * f()
    for boxes in (True, False):
        mission = field(folder, boxes)
        label = f"lanes between {'100 boxes' if boxes else 'no boxes'}"
        yield label, "× real time", lambda m=mission: recorded(m, {})
    for model, wind in product(("f450", "ardrone2"), ("none", WIND, f"{WIND},turbulence=natural")):
        hold = partial(rms_of_hover, model, wind)
        yield f"hover of {model}, wind {wind}", "mm RMS", hold


def peers() -> dict[str, dict[str, object]]:
    """The figures of each peer, or the reason why there are none."""
    return {name: peer(name) for name in PEERS}


def peer(name: str) -> dict[str, object]:
    with TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        python = Path(folder) / "bin" / "python"
        installed = subprocess.run([python, "-m", "pip", "install", "-q", name], check=False)
        if installed.returncode:
            return {"missing": "does not install here"}
        script = Path(__file__).parent / "peers_flight.py"
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        environment.pop("PYTHONPATH", None)
        done = subprocess.run(
            [python, script, name], check=True, capture_output=True, text=True, env=environment
        )
        found: dict[str, object] = json.loads(_line_of_json(done.stdout))
        return found


def _line_of_json(printed: str) -> str:
    """The line of the results: pybullet prints at the end of a process, too."""
    return next(line.partition("}}")[0] + "}}" for line in printed.splitlines() if line[:1] == "{")


def measured(rounds: int) -> dict[str, tuple[str, list[float]]]:
    """Figures by name: the unit, and the value of each round."""
    found: dict[str, tuple[str, list[float]]] = {}
    with TemporaryDirectory() as folder:
        ours = list(jobs(Path(folder)))
        for _ in range(rounds):
            for name, unit, job in ours:
                found.setdefault(name, (unit, []))[1].append(job())
    return found


def main() -> None:
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    found = measured(ROUNDS)
    others = {} if "--alone" in sys.argv else peers()
    if "--json" in sys.argv:
        ours = {name: {"unit": unit, "values": values} for name, (unit, values) in found.items()}
        print(json.dumps({"machine": machine(), "vencejo": ours, "peers": others}, indent=2))
        return
    print(f"flights, CPU time of one core, median of {ROUNDS}; {machine()}")
    for name, (unit, values) in found.items():
        print(f"  {name:54}{_shown(values)} {unit}")
    for name, told in others.items():
        factors = told.get("factors", {})
        assert isinstance(factors, dict)
        for job, factor in factors.items():
            print(f"  {job + ', ' + name + ' ' + str(told['version']):54}{factor:9.3g} × real time")
        if "missing" in told:
            print(f"  {name:54}{told['missing']}")


def _shown(values: Sequence[float]) -> str:
    return f"{median(values):9.4g}"


if __name__ == "__main__":
    main()
