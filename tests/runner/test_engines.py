"""Missions on each of the physics engines."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from itertools import combinations, cycle, product
from pathlib import Path

import pytest

from behaviors import Pilot
from fsm.engine.instance import Record
from runner import missions
from runner.by_vehicle import ALONE
from runner.fleets import PreparedFleet, prepare_any
from runner.loop import fly
from runner.plan import Assignment, Plan
from runner.recorder import Recorder
from tests.hal.engines import ENGINES
from tests.missions.shipped import FLEETS, MISSIONS
from vencejo.geometry import Point, distance

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


class Tracks:
    """The places where each vehicle was, one for each mission period."""

    def __init__(self) -> None:
        self.places: dict[str, list[Point]] = {}

    def show(self, pilot: Pilot, _: Sequence[Record]) -> None:
        vehicle = pilot.vehicle
        self.places.setdefault(vehicle.name, []).append(vehicle.observe().position)


def plan(flown: str, engine: str, world: str | None = None, noise: float = 0.0) -> Plan:
    """The plan of a mission or a fleet."""
    prepared = prepare_any(missions.find(flown), world)
    settings = {"engine": engine, "noise": noise}
    if isinstance(prepared, PreparedFleet):
        return Plan(prepared.assignments, settings=settings, fleet=prepared.fleet)
    return Plan({ALONE: Assignment(prepared)}, settings=settings)


def tracks(flown: str, engine: str, world: str | None = None) -> Mapping[str, list[Point]]:
    seen = Tracks()
    summary = fly(plan(flown, engine, world), watchers=[seen])
    assert summary.exit_code == 0
    return seen.places


SEEING = {
    *("cat_and_mouse", "follow_road", "land_on_moving_pad", "land_on_pad", "road_travel"),
    *("road_watch", "roundel_follower", "search", "sweep_detect", "tag_follower"),
    *("tag_follower_braking", "tag_lights", "tag_navigator", "track_object"),
}
"""Missions and fleets that fly by what they see."""


def assert_alike(flown: str, world: str | None = None) -> None:
    """Engines fly a mission or fleet within a centimetre of each other, period by period."""
    found = [tracks(flown, engine, world) for engine in ENGINES]
    for one, other in combinations(found, 2):
        assert one.keys() == other.keys()
        for name, places in one.items():
            assert len(places) == len(other[name]) > 100
            assert max(map(distance, places, other[name])) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("flown", sorted({*MISSIONS, *FLEETS} - SEEING))
def test_engines_fly_what_is_shipped_alike(flown: str) -> None:
    assert_alike(flown)


@pytest.mark.slow
@pytest.mark.parametrize("flown", sorted(SEEING))
def test_what_flies_by_sight_comes_to_the_same_place_with_each_engine(flown: str) -> None:
    """A tenth of a millimetre is another pixel somewhere, and so another way, but no other end."""
    one, other = (tracks(flown, engine, None) for engine in ENGINES)
    assert one.keys() == other.keys()
    for name, places in one.items():
        assert len(places) == pytest.approx(len(other[name]), rel=0.05)
        assert distance(places[-1], other[name][-1]) < 0.3


@pytest.mark.slow
def test_engines_land_on_things_alike(tmp_path: Path) -> None:
    file = tmp_path / "box_and_back.yaml"
    file.write_text(LANDS_ON_A_BOX)
    assert_alike(str(file), "yard")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("flown", "engine"),
    [
        *product(sorted({*MISSIONS, "handover"} - SEEING), ENGINES),
        *zip(sorted(SEEING), cycle(ENGINES), strict=False),  # they take longer: each with one
    ],
)
def test_a_flight_on_one_engine_is_the_same_to_the_last_byte(
    flown: str, engine: str, tmp_path: Path
) -> None:
    logs = set()
    for name in ("one", "other"):
        folder = tmp_path / name
        folder.mkdir()
        fly(plan(flown, engine, noise=1.0), lambda folder=folder: Recorder(folder))  # type: ignore[misc]
        telemetry = sorted(folder.glob("telemetry*/*")) or [folder / "telemetry.csv"]
        files = [file.read_bytes() for file in (folder / "events.jsonl", *telemetry)]
        logs.add(hashlib.sha256(b"".join(files)).hexdigest())
    assert len(logs) == 1
