"""How the trial flights of a mission are shown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from fsm import Graph
from runner.by_vehicle import ALONE
from runner.plan import Plan
from runner.separation import Nearest
from runner.trial_flights import Clearance, Trial, TrialFlight


def never_reached(graph: Graph, flights: Sequence[TrialFlight]) -> list[str]:
    """The states without states inside that no flight entered."""
    entered = frozenset().union(*(flight.entered for flight in flights))
    leaves = (n.path for n in graph.nodes if not n.children and n.type != "history")
    return [path for path in leaves if path not in entered]


def least_clearances(flights: Sequence[TrialFlight]) -> dict[str, Clearance]:
    """The least clearance of all flights, by state."""
    found: dict[str, Clearance] = {}
    for flight in flights:
        for state, clearance in flight.clearances.items():
            found[state] = min(clearance, found.get(state, clearance))
    return found


def trials_fields(plan: Plan, trials: Sequence[Trial]) -> dict[str, Any]:
    """What `check --fly --json` says of trial flights; of a fleet by vehicle."""
    by_vehicle = {
        name: trial_fields(plan.assignments[name].prepared.graph, flights)
        for name, flights in _flights(trials).items()
    }
    if plan.fleet is None:
        return by_vehicle[ALONE]
    nearest = _nearest(trials)
    apart = (
        {
            "vehicles": list(nearest[1].vehicles),
            "distance_m": round(nearest[1].distance, 3),
            "seed": nearest[0],
        }
        if nearest
        else None
    )
    return {"vehicles": by_vehicle, "nearest": apart}


def trials_lines(plan: Plan, trials: Sequence[Trial]) -> Iterator[str]:
    """What was measured of trial flights, for people; of a fleet by vehicle."""
    for name, flights in _flights(trials).items():
        if plan.fleet is not None:
            yield name
        yield from trial_lines(plan.assignments[name].prepared.graph, flights)
    nearest = _nearest(trials)
    if nearest is not None:
        seed, (pair, distance, _) = nearest
        yield f"nearest       {' and '.join(pair)}: {distance:.2f} m (seed {seed})"


def _flights(trials: Sequence[Trial]) -> dict[str, list[TrialFlight]]:
    """The flights of each vehicle."""
    found: dict[str, list[TrialFlight]] = {}
    for trial in trials:
        for flight in trial.flights:
            found.setdefault(flight.vehicle, []).append(flight)
    return found


def _nearest(trials: Sequence[Trial]) -> tuple[int, Nearest] | None:
    """The two vehicles that came nearest to each other, and the seed of that flight."""
    found = [(trial.seed, pair) for trial in trials for pair in trial.separation]
    return min(found, key=lambda each: each[1].distance, default=None)


def trial_fields(graph: Graph, flights: Sequence[TrialFlight]) -> dict[str, Any]:
    """What `check --fly --json` says of trial flights."""
    least = least_clearances(flights)
    return {
        "flights": [_flight_fields(flight) for flight in flights],
        "clearance": {
            state: {"distance_m": round(near.distance, 3), "thing": near.thing, "seed": near.seed}
            for state, near in least.items()
        },
        "never_reached": never_reached(graph, flights),
    }


def _flight_fields(flight: TrialFlight) -> dict[str, Any]:
    distances = {name: round(near.distance, 3) for name, near in flight.clearances.items()}
    return {
        "seed": flight.seed,
        "outcome": flight.outcome,
        "reason": flight.reason or None,
        "mission_time_s": round(flight.time, 3),
        "distance_m": round(flight.distance, 2),
        "max_altitude_m": round(flight.max_altitude, 2),
        "battery_left": round(flight.battery, 4),
        "clearance_m": distances,
    }


def trial_lines(graph: Graph, flights: Sequence[TrialFlight]) -> Iterator[str]:
    """What was measured of trial flights, for people."""
    outcomes = Counter(flight.outcome for flight in flights)
    ends = ", ".join(f"{number} {outcome}" for outcome, number in outcomes.most_common())
    seeds = "seed 0" if len(flights) == 1 else f"seeds 0 to {len(flights) - 1}"
    yield f"flown with {seeds}: {ends}"
    for flight in flights:
        if flight.outcome != "done":
            reason = f": {flight.reason}" if flight.reason else ""
            yield f"  seed {flight.seed} ended in {flight.outcome}{reason}"
    yield f"  time        {_span([flight.time for flight in flights], '.1f')} s"
    yield f"  battery     {_span([100 * flight.battery for flight in flights], '.0f')} % left"
    yield f"  highest     {_span([flight.max_altitude for flight in flights], '.1f')} m above home"
    title = "clearance"
    for state, (distance, thing, seed) in least_clearances(flights).items():
        yield f"  {title:11} {state}: {distance:.2f} m from '{thing}' (seed {seed})"
        title = ""
    missed = never_reached(graph, flights)
    if missed:
        yield f"  not reached {', '.join(missed)}"


def _span(values: Sequence[float], form: str) -> str:
    """``18.9 to 19.4``; one number where they are shown alike."""
    low, high = format(min(values), form), format(max(values), form)
    return low if low == high else f"{low} to {high}"
