"""Flies a prepared mission: backend, pilot, recorder and whoever watches, in one loop."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cache, partial
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from platform import python_version
from typing import Any, Protocol

from behaviors import MissionFrame, Pilot
from fsm.engine.instance import Record
from hal import Options, open_backend
from hal.vehicle import Observation
from runner.pace import Pace
from runner.preparation import Prepared
from runner.recorder import Recorder
from runner.run_folder import ALONE, Flown, Header, MissionFacts, Summary
from vencejo.errors import UserError
from vencejo.geometry import distance
from vencejo.version import __version__


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

    Looks through ``pilot.vehicle``: what is read through ``pilot.flight`` counts as read by the
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
class _Never:
    count: int = 0


def fly(
    plan: Plan,
    record: Callable[[], Recorder] | None = None,
    watchers: Sequence[Watcher] = (),
    pace: Pace | None = None,
    stops: Stops | None = None,
) -> Summary:
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
        frame = MissionFrame(vehicle.observe().position, session.places, session.geographic)
        pilot = Pilot(graph, vehicle, plan.parameters, frame=frame, seed=plan.seed)
        header = _header(plan, session.engine)
        recorder = record() if record else None
        if recorder:
            stack.callback(recorder.close)
            recorder.begin(header)
            recorder.follow(pilot)
        tally, answered, start = Tally(), 0, vehicle.observe().time
        unwritten: UserError | None = None
        began = time.perf_counter()
        while not pilot.finished:
            session.wait()
            if stops.count > answered:
                answered = stops.count
                pilot.abort() if answered == 1 else pilot.land_now()
            pilot.period()
            try:
                records = recorder.take(pilot) if recorder else _drain(pilot)
            except UserError as error:
                # A flight nobody can read afterwards is of no use, but it is not left in the air.
                unwritten, recorder, records = error, None, []
                pilot.land_now()
            tally.add(pilot.flight.world, frame.origin.z)
            for watcher in watchers:
                watcher.show(pilot, records)
            if pace.factor is not None:
                pace.wait(pilot.flight.now, partial(_asked_more, stops, answered))
        if unwritten is not None:
            raise unwritten
        if recorder:
            recorder.close()
        flown = Flown(
            outcome=pilot.outcome or "failed",
            reason=pilot.reason,
            output=pilot.instance.output,
            mission_time=pilot.flight.now - start,
            distance=tally.distance,
            max_altitude=tally.max_altitude,
            battery=pilot.flight.observation.battery,
        )
        wall_time = time.perf_counter() - began
        return Summary(header, {vehicle.name: flown}, wall_time, answered > 0, versions())


def _asked_more(stops: Stops, answered: int) -> bool:
    return stops.count > answered


def _drain(pilot: Pilot) -> list[Record]:
    records, pilot.instance.records = pilot.instance.records, []
    return records


def _header(plan: Plan, engine: str) -> Header:
    prepared = plan.prepared
    first, *others = prepared.files
    mission = MissionFacts(
        name=prepared.graph.name,
        sha256=_file_hash(first),
        parameters=plan.parameters,
        files={file.relative_to(first.parent).as_posix(): _file_hash(file) for file in others},
    )
    return Header(
        missions={ALONE: mission},
        world=prepared.world.name,
        world_sha256=prepared.world.sha256,
        seed=plan.seed,
        backend=plan.backend,
        engine=engine,
        vencejo=__version__,
    )


def _file_hash(path: Path) -> str:
    """SHA-256 of a file, hexadecimal."""
    return sha256(path.read_bytes()).hexdigest()


@cache
def versions() -> Mapping[str, str]:
    """Versions of the packages that a run's result may depend on, and of Python."""
    packages = ("transitions", "numpy", "opencv-python-headless", "pymavlink")
    return {
        "vencejo": __version__,
        "python": python_version(),
        **{package: version(package) for package in packages},
    }
