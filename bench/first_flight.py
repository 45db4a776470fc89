"""`first_flight`: speed on one core, and byte-for-byte equality of equal runs.

    python -m bench.first_flight [--json]

The realtime factor is mission time by wall time from the first step to the last byte of events and
telemetry: recording on, live view off, the picture apart. Beside each run stands what the engine
alone reaches at that moment (six steps, states read and pushes given, nothing else), since shared
machines change their speed by more than half from one minute to the next.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from hashlib import sha256
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from rich.console import Console

from bench.machine import machine
from cli.live_view import LiveView
from fsm import parse_parameters
from hal import PERIOD
from hal.sim.bullet import Bullet
from hal.sim.dynamics import STEPS_PER_PERIOD
from hal.sim.physics import GRAVITY
from runner import missions
from runner.loop import Watcher, fly
from runner.pace import Pace
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder

GOAL = 150.0
RUNS = 15


def plan(noise: float) -> Plan:
    prepared = prepare(missions.find("first_flight"))
    return Plan.alone(prepared, parse_parameters(prepared.graph, {}), settings={"noise": noise})


def realtime_factors() -> tuple[list[float], list[float]]:
    """Realtime factors of several runs, and of the engine alone before each of them."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    ordered = plan(noise=0.0)
    factors, engine = [], []
    for _ in range(RUNS):
        engine.append(engine_alone())
        with TemporaryDirectory() as folder:
            flown = fly(ordered, lambda folder=folder: Recorder(Path(folder)))  # type: ignore[misc]
            factors.append(flown.mission_time / flown.wall_time)
    return factors, engine


def engine_alone(periods: int = 400, clock: Callable[[], float] = perf_counter) -> float:
    """The realtime factor of pybullet alone, with the calls that every flight makes."""
    physics = Bullet()
    body = physics.add_body(0.4, (0.01, 0.01, 0.01), (0.5, 0.5, 0.1), (0.0, 0.0, 9.0), (0, 0, 0, 1))
    began = clock()
    for _ in range(periods):
        for _ in range(STEPS_PER_PERIOD):
            body.push((0.0, 0.0, 0.4 * GRAVITY), (0.0, 0.0, 0.0))
            physics.step()
            body.state()
    elapsed = clock() - began
    physics.close()
    return periods * PERIOD / elapsed


def digest(factor: float | None, watched: bool) -> str:
    """The SHA-256 of the event log of a run in this process, with command noise."""
    ordered = plan(noise=1.0)
    with TemporaryDirectory() as folder:
        watchers: Sequence[Watcher] = ()
        if watched:
            console = Console(file=io.StringIO(), force_terminal=True, width=90)
            watchers = [LiveView(console, ordered.world, factor)]
        fly(ordered, lambda: Recorder(Path(folder)), watchers, Pace(factor))
        return sha256((Path(folder) / "events.jsonl").read_bytes()).hexdigest()


def digest_elsewhere() -> str:
    """The same in another process and folder, by the command line."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-c", "from cli.main import main; main()"]
        # Without a limit on calls, as above: it stands in the log's settings.
        options = ["run", "first_flight", "--noise", "1", "--call-limit", "none", "--json"]
        subprocess.run([*command, *options], cwd=folder, check=True, capture_output=True)
        (log,) = Path(folder).glob("runs/*/events.jsonl")
        return sha256(log.read_bytes()).hexdigest()


def main() -> None:
    digests = {
        "max, unwatched": digest(None, watched=False),
        "max, live view": digest(None, watched=True),
        "speed 5, unwatched": digest(5.0, watched=False),
        "speed 5, live view": digest(5.0, watched=True),
        "max, another folder and process": digest_elsewhere(),
    }
    factors, engine = realtime_factors()
    results = {
        "machine": machine(),
        "seed": 0,
        "realtime_factor": {"median": median(factors), "min": min(factors), "max": max(factors)},
        "engine_alone": {"median": median(engine), "min": min(engine), "max": max(engine)},
        "goal": GOAL,
        "identical": len(set(digests.values())) == 1,
        "digests": digests,
    }
    if "--json" in sys.argv[1:]:
        print(json.dumps(results, indent=2))
        return
    print(f"first_flight, seed 0, one core; {machine()}")
    print(
        f"  realtime factor   median {median(factors):.0f}, {min(factors):.0f} … {max(factors):.0f}"
    )
    print(f"                    of {RUNS} runs; goal ≥ {GOAL:.0f}")
    print(f"  the engine alone  median {median(engine):.0f}, {min(engine):.0f} … {max(engine):.0f}")
    for name, value in digests.items():
        print(f"  events.jsonl      {value[:16]}  {name}, command noise 1")
    print(f"  identical         {'yes' if results['identical'] else 'NO'}")


if __name__ == "__main__":
    main()
