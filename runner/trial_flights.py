"""Trial flights of a mission in the simulator, to measure what may be expected of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from behaviors import Pilot
from fsm.chart.graph import Node
from fsm.engine.instance import Record
from runner.call_limit import CallLimit
from runner.loop import fly
from runner.plan import Plan
from runner.run_folder import SUCCESS, Flown
from runner.separation import Nearest
from vencejo.geometry import Point
from worlds.obstacles import Near, Obstacles

FARTHEST = 50.0
"""Things farther away than this are not measured, metres."""
_PERIODS = 4
"""Periods between two measurements; the way between them counts as straight."""


class Clearance(NamedTuple):
    """The least distance from a thing."""

    distance: float
    """Metres, from the vehicle's own place."""
    thing: str
    seed: int
    """Of the flight that came so near."""


@dataclass(frozen=True)
class TrialFlight:
    """What was measured of one flight of one vehicle."""

    vehicle: str
    seed: int
    outcome: str
    reason: str
    """The reason why the mission was ended from outside; empty when it ended by itself."""
    time: float
    """Seconds."""
    battery: float
    """Charge left, 0 to 1."""
    distance: float
    """Length of the path, metres."""
    max_altitude: float
    """Above home, metres."""
    clearances: Mapping[str, Clearance]
    """By state, in the order in which they flew; of those that came within FARTHEST of a thing."""
    entered: frozenset[str]
    """The paths of the states that were entered."""


@dataclass(frozen=True)
class Trial:
    """One flight of all vehicles of a plan."""

    seed: int
    flights: tuple[TrialFlight, ...]
    """Of the vehicles that have a mission."""
    separation: tuple[Nearest, ...]
    """The least distance of each two vehicles."""
    success: bool


def fly_trials(plan: Plan, seeds: Sequence[int], limit: CallLimit | None = None) -> Iterator[Trial]:
    """Fly a plan once with each seed; nothing is recorded.

    ``limit``, which its caller has entered, ends calls into people's code that last too long.
    Raises VehicleError without a simulator, UserError when it cannot fly this.
    """
    obstacles = Obstacles(plan.world)
    missions = [name for name, each in plan.assignments.items() if not each.stands]
    for seed in seeds:
        watches = {name: _Watch(obstacles, seed) for name in missions}
        summary = fly(replace(plan, seed=seed), watchers=[_Watches(watches)], limit=limit)
        flights = [_measured(name, summary.vehicles[name], each) for name, each in watches.items()]
        yield Trial(seed, tuple(flights), summary.separation, summary.exit_code == SUCCESS)


def _measured(vehicle: str, flown: Flown, watch: _Watch) -> TrialFlight:
    return TrialFlight(
        vehicle,
        watch.seed,
        flown.outcome,
        flown.reason,
        flown.mission_time,
        flown.battery,
        flown.distance,
        flown.max_altitude,
        watch.clearances,
        frozenset(watch.entered),
    )


@dataclass(frozen=True)
class _Watches:
    """Shows each vehicle to the watch of its own."""

    by_vehicle: Mapping[str, _Watch]

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        watch = self.by_vehicle.get(pilot.vehicle.name)
        if watch is not None:
            watch.show(pilot, records)


@dataclass
class _Watch:
    """Notes how near a flight comes to things, and which states it enters."""

    obstacles: Obstacles
    seed: int
    clearances: dict[str, Clearance] = field(default_factory=dict)
    entered: set[str] = field(default_factory=set)
    _last: Point | None = None
    _began: float | None = None
    _periods: int = 0

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        entered = [fields["state"] for kind, fields in records if kind == "enter"]
        self.entered.update(entered)
        seen = pilot.vehicle.observe()
        self._periods += 1
        if self._began is None:
            self._began = seen.time
        if not seen.flying:
            self._last = None
        elif entered or self._last is None or self._periods % _PERIODS == 0:
            begin, self._last = self._last or seen.position, seen.position
            for node in pilot.instance.active:
                if not node.children:
                    self._measure(node, begin, seen.position, seen.time - self._began)

    def _measure(self, node: Node, a: Point, b: Point, time: float) -> None:
        """Measure how near the way from one place to the next comes to things, in a state."""
        known = self.clearances.get(node.path)
        within = known.distance if known else FARTHEST
        near = [*self.obstacles.near(a, b, within), *self.obstacles.moving_at(b, time, within)]
        behavior = node.invocation.behavior if node.invocation else None
        if near and behavior and (behavior.takes_off or behavior.ends_landed):
            stood_on = self.obstacles.below(b).thing
            near = [each for each in near if each.thing is not stood_on]
        nearest: Near | None = min(near, key=lambda each: each.distance, default=None)
        if nearest is not None:
            found = Clearance(nearest.distance, nearest.thing.name, self.seed)
            self.clearances[node.path] = found
