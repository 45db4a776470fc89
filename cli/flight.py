"""Flies a prepared mission: backend, pilot, recorder and whoever watches, in one loop."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path
from platform import python_version
from typing import Any, Protocol

from behaviors import MissionFrame, Pilot
from cli.pace import Pace
from cli.prepare import Prepared
from cli.recorder import Recorder, file_hash
from fsm.engine.instance import Record
from hal import Options, open_backend
from hal.vehicle import Observation
from vencejo.errors import UserError
from vencejo.geometry import distance
from vencejo.version import __version__

SUCCESS, OTHER_OUTCOME, WRONG, VEHICLE_FAILED, INTERRUPTED = 0, 1, 2, 3, 130


@dataclass(frozen=True)
class Plan:
    """A flight as ordered."""

    prepared: Prepared
    parameters: Mapping[str, Any]
    backend: str = "sim"
    seed: int = 0
    settings: Mapping[str, object] = field(default_factory=dict)


class Watcher(Protocol):
    """Sees every period of a flight.

    Looks through ``pilot.vehicle``: what is read through ``pilot.channel`` counts as read by the
    mission and is recorded.
    """

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None: ...


class Stops(Protocol):
    """How often somebody asked to stop."""

    @property
    def count(self) -> int: ...


@dataclass
class Tally:
    """Figures of a flight that grow with it."""

    distance: float = 0.0
    max_altitude: float = 0.0
    _last: Observation | None = None

    def add(self, seen: Observation, home_z: float) -> None:
        if self._last is not None:
            self.distance += distance(self._last.position, seen.position)
        self.max_altitude = max(self.max_altitude, seen.position.z - home_z)
        self._last = seen


@dataclass(frozen=True)
class Flown:
    """How a flight ended."""

    outcome: str
    reason: str
    output: Mapping[str, Any]
    mission_time: float
    wall_time: float
    engine: str
    tally: Tally
    battery: float
    interrupted: bool

    @property
    def exit_code(self) -> int:
        if self.interrupted:
            return INTERRUPTED
        return SUCCESS if self.outcome == "done" else OTHER_OUTCOME


@dataclass(frozen=True)
class _Never:
    count: int = 0


def fly(
    plan: Plan,
    record: Callable[[], Recorder] | None = None,
    watchers: Sequence[Watcher] = (),
    pace: Pace | None = None,
    stops: Stops | None = None,
) -> Flown:
    """Fly a plan to its end.

    ``record`` makes the recorder once nothing can keep the flight from starting any more.
    Raises VehicleError when the backend fails, UserError when the vehicle cannot fly this, or,
    after it has landed, when the flight could not be recorded.
    """
    pace, stops = pace or Pace(None), stops or _Never()
    graph = plan.prepared.graph
    options = Options(world=plan.prepared.world_word, seed=plan.seed, settings=plan.settings)
    with open_backend(plan.backend, options) as session, ExitStack() as stack:
        (vehicle,) = session.vehicles.values()
        dt = session.wait()
        frame = MissionFrame.at_start(vehicle.observe(), session.places, session.geographic)
        pilot = Pilot(graph, vehicle, plan.parameters, frame=frame, seed=plan.seed)
        recorder = record() if record else None
        if recorder:
            stack.callback(recorder.close)
            recorder.header(_facts(plan, session.engine))
            recorder.follow(pilot)
        tally, answered, start = Tally(), 0, vehicle.observe().time - dt
        unwritten: UserError | None = None
        began = time.perf_counter()
        while True:
            if stops.count > answered:
                answered = stops.count
                pilot.abort() if answered == 1 else pilot.land_now()
            pilot.period(dt)
            try:
                records = recorder.take(pilot) if recorder else _drain(pilot)
            except UserError as error:
                # A flight nobody can read afterwards is of no use, but it is not left in the air.
                unwritten, recorder, records = error, None, []
                pilot.land_now()
            tally.add(pilot.channel.world, frame.origin.z)
            for watcher in watchers:
                watcher.show(pilot, records)
            if pace.factor is not None:
                pace.wait(pilot.channel.now, partial(_asked_more, stops, answered))
            if pilot.finished:
                break
            dt = session.wait()
        if unwritten is not None:
            raise unwritten
        if recorder:
            recorder.close()
        return Flown(
            outcome=pilot.outcome or "failed",
            reason=pilot.reason,
            output=pilot.instance.output,
            mission_time=round(pilot.channel.now - start, 6),
            wall_time=time.perf_counter() - began,
            engine=session.engine,
            tally=tally,
            battery=pilot.channel.observation.battery,
            interrupted=answered > 0,
        )


def _asked_more(stops: Stops, answered: int) -> bool:
    return stops.count > answered


def _drain(pilot: Pilot) -> list[Record]:
    records, pilot.instance.records = pilot.instance.records, []
    return records


def _facts(plan: Plan, engine: str) -> dict[str, Any]:
    """The first line of the log: everything that decides how this run goes."""
    prepared = plan.prepared
    return {
        "mission": prepared.graph.name,
        "mission_sha256": file_hash(prepared.found.path),
        **_included(prepared),
        "world": prepared.world.name,
        "world_sha256": prepared.world.sha256,
        "seed": plan.seed,
        "parameters": dict(plan.parameters),
        "backend": plan.backend,
        "engine": engine,
        "vencejo": __version__,
    }


def _included(prepared: Prepared) -> dict[str, Any]:
    """Hashes of what else a person wrote, by names from the mission's folder."""
    first, *others = prepared.files
    named = {file.relative_to(first.parent).as_posix(): file_hash(file) for file in others}
    return {"files_sha256": named} if named else {}


def versions() -> dict[str, str]:
    """What a run's result may depend on."""
    packages = ("transitions", "numpy", "opencv-python-headless", "pymavlink")
    return {
        "vencejo": __version__,
        "python": python_version(),
        **{package: version(package) for package in packages},
    }


def summarise(plan: Plan, flown: Flown, folder: Path | None) -> dict[str, Any]:
    """What `summary.json` holds, and `--json` prints."""
    wall = flown.wall_time
    return {
        "mission": plan.prepared.graph.name,
        "outcome": flown.outcome,
        "success": flown.outcome == "done" and not flown.interrupted,
        "reason": flown.reason or None,
        "output": dict(flown.output),
        "exit_code": flown.exit_code,
        "mission_time_s": flown.mission_time,
        "wall_time_s": round(wall, 4),
        "realtime_factor": round(flown.mission_time / wall, 1) if wall > 0 else None,
        "distance_m": round(flown.tally.distance, 2),
        "max_altitude_m": round(flown.tally.max_altitude, 2),
        "battery_left": round(flown.battery, 4),
        "world": plan.prepared.world.name,
        "parameters": dict(plan.parameters),
        "seed": plan.seed,
        "backend": plan.backend,
        "engine": flown.engine,
        "versions": versions(),
        "run_folder": str(folder) if folder else None,
    }
