"""Missions on each of the physics engines."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path

import pytest

from behaviors import Pilot
from fsm import parse_parameters
from fsm.engine.instance import Record
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from tests.hal.engines import ENGINES
from vencejo.geometry import Point, distance

SHIPPED = sorted(path.stem for path in (Path(__file__).parents[2] / "missions").glob("*.yaml"))
LANDS_ON_A_BOX = """
mission: box_and_back
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: there}}
  there: {do: goto, with: {to: [3, -4]}, on: {done: down, blocked: down}}
  down: {do: land, on: {done: stand}}
  stand: {after: {3 s: again}}
  again: {do: takeoff, with: {altitude: 1 m}, on: {done: home}}
  home: {do: goto, with: {to: home, speed: 3 m/s}, on: {done: land, blocked: land}}
  land: {do: land, on: {done: end}}
  end: {type: final}
"""


class Track:
    """The places where a vehicle was, one for each mission period."""

    def __init__(self) -> None:
        self.places: list[Point] = []

    def show(self, pilot: Pilot, _: Sequence[Record]) -> None:
        self.places.append(pilot.vehicle.observe().position)


def track(mission: str, engine: str, world: str | None = None) -> list[Point]:
    prepared, seen = prepare(missions.find(mission), world), Track()
    values = parse_parameters(prepared.graph, {})
    flown = fly(Plan.alone(prepared, values, settings={"engine": engine}), watchers=[seen])
    assert flown.alone.outcome == "done"
    return seen.places


def assert_alike(mission: str, world: str | None = None) -> None:
    """Engines fly a mission within a centimetre of each other, period by period."""
    tracks = [track(mission, engine, world) for engine in ENGINES]
    for one, other in combinations(tracks, 2):
        assert len(one) == len(other) > 100
        assert max(map(distance, one, other)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("mission", SHIPPED)
def test_engines_fly_shipped_missions_alike(mission: str) -> None:
    assert_alike(mission)


@pytest.mark.slow
def test_engines_land_on_things_alike(tmp_path: Path) -> None:
    file = tmp_path / "box_and_back.yaml"
    file.write_text(LANDS_ON_A_BOX)
    assert_alike(str(file), "yard")


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("mission", SHIPPED)
def test_a_mission_on_one_engine_is_the_same_to_the_last_byte(
    mission: str, engine: str, tmp_path: Path
) -> None:
    logs = set()
    for name in ("one", "other"):
        prepared, folder = prepare(missions.find(mission)), tmp_path / name
        folder.mkdir()
        values = parse_parameters(prepared.graph, {})
        plan = Plan.alone(prepared, values, settings={"engine": engine, "noise": 1.0})
        fly(plan, lambda folder=folder: Recorder(folder))  # type: ignore[misc]
        files = [(folder / file).read_bytes() for file in ("events.jsonl", "telemetry.csv")]
        logs.add(hashlib.sha256(b"".join(files)).hexdigest())
    assert len(logs) == 1
