"""Helpers for tests of missions: fly one in the simulator and look at how it went."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from behaviors import Pilot, drone_vocabulary
from fsm import (
    Graph,
    Vocabulary,
    compile_mission,
    parse_parameters,
    read_mission,
    read_mission_text,
)
from fsm.engine.instance import Record
from runner import missions
from runner.fleets import prepare_fleet, with_parameters
from runner.loop import Watcher, fly
from runner.plan import Plan
from runner.posts import parse_posts
from runner.preparation import prepare
from runner.run_folder import Flown, Summary
from runner.separation import Nearest
from vencejo.geometry import Point, distance


@dataclass
class MissionFlight:
    """The course of a flight; positions in the mission frame."""

    outcome: str = ""
    reason: str = ""
    output: Mapping[str, Any] = field(default_factory=dict)
    time: float = 0.0
    """Seconds from the first period to the last."""
    states: list[str] = field(default_factory=list)
    """Paths of the leaf states, in the order in which they were entered."""
    track: list[tuple[float, Point]] = field(default_factory=list)
    """Time and place, every mission period."""
    records: list[tuple[float, str, dict[str, Any]]] = field(default_factory=list)
    """Time, kind and fields of everything that was logged."""

    @property
    def end(self) -> Point:
        return self.track[-1][1]

    @property
    def highest(self) -> float:
        return max(place.z for _, place in self.track)

    def nearest(self, place: tuple[float, float, float]) -> float:
        """The least distance to a place during the flight, metres."""
        return min(distance(point, place) for _, point in self.track)


class _Watch:
    def __init__(self, flight: MissionFlight, post: Mapping[float, str]) -> None:
        self.flight = flight
        self.post = sorted(post.items())

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        now = pilot.channel.now
        while self.post and self.post[0][0] <= now:
            pilot.instance.post(self.post.pop(0)[1])
        self.flight.track.append((now, pilot.channel.observation.position))
        for kind, fields in records:
            self.flight.records.append((now, kind, fields))
            if kind == "enter" and not pilot.instance.graph.by_path[fields["state"]].children:
                self.flight.states.append(fields["state"])

    def take(self, flown: Flown) -> None:
        """Note how the flight ended."""
        flight = self.flight
        flight.outcome, flight.reason, flight.output = flown.outcome, flown.reason, flown.output
        flight.time = round(flown.mission_time, 6)


def graph_of(source: str | Path, vocabulary: Vocabulary | None = None) -> Graph:
    """The graph of a mission given by path or name, or by its text (which has several lines).

    Raises UserError like `drone-cli check`.
    """
    text = str(source)
    if "\n" in text:
        return compile_mission(read_mission_text(text), vocabulary or drone_vocabulary())
    found = missions.find(text)
    if vocabulary is None:
        return prepare(found).graph
    return compile_mission(read_mission(found.path, found.shown_as), vocabulary)


@dataclass(frozen=True)
class FleetFlight:
    """The course of a fleet's flight."""

    vehicles: Mapping[str, MissionFlight]
    """By name; each counts from its own home."""
    summary: Summary

    @property
    def nearest(self) -> Nearest:
        """The two vehicles that came nearest to each other. Raises ValueError where none flew."""
        return min(self.summary.separation, key=lambda pair: pair.distance)


def fly_fleet(
    fleet: str | Path,
    parameters: Mapping[str, str] | None = None,
    *,
    world: str | None = None,
    seed: int = 0,
    noise: float = 0.0,
    post: Iterable[str] = (),
    watchers: Sequence[Watcher] = (),
) -> FleetFlight:
    """Fly a fleet, given by path or name, in the simulator, without files or pacing.

    ``parameters`` and ``post`` are texts as after ``-p`` (``{"cat.speed": "3 m/s"}``) and
    ``--post`` (``6s:cat:battery.low``). Raises UserError like the command line.
    """
    prepared = prepare_fleet(missions.find(str(fleet)), world)
    prepared.require()
    assignments = with_parameters(prepared.assignments, parameters or {})
    posts = parse_posts({n: each.prepared.graph for n, each in assignments.items()}, post)
    watches = {name: _Watch(MissionFlight(), {}) for name in assignments}
    plan = Plan(
        assignments, seed=seed, settings={"noise": noise}, posts=posts, fleet=prepared.fleet
    )
    summary = fly(plan, watchers=[_EachItsOwn(watches), *watchers])
    for name, flown in summary.vehicles.items():
        watches[name].take(flown)
    return FleetFlight({name: watch.flight for name, watch in watches.items()}, summary)


class _EachItsOwn:
    """Shows each vehicle to the watch of its own."""

    def __init__(self, watches: Mapping[str, _Watch]) -> None:
        self._watches = watches

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        self._watches[pilot.vehicle.name].show(pilot, records)


def fly_mission(
    mission: str | Path,
    parameters: Mapping[str, str] | None = None,
    *,
    world: str | None = None,
    seed: int = 0,
    noise: float = 0.0,
    post: Mapping[float, str] | None = None,
    watch: Callable[[Graph], None] | None = None,
) -> MissionFlight:
    """Fly a mission in the simulator, without files or pacing.

    ``parameters`` are texts as after ``-p``; ``post`` says at which second which event comes from
    outside; ``watch`` is given the graph before it flies. Raises UserError like the command line.
    """
    prepared = prepare(missions.find(str(mission)), world)
    if watch:
        watch(prepared.graph)
    values = parse_parameters(prepared.graph, parameters or {})
    plan = Plan.alone(prepared, values, seed=seed, settings={"noise": noise})
    watched = _Watch(MissionFlight(), post or {})
    watched.take(fly(plan, watchers=[watched]).alone)
    return watched.flight
