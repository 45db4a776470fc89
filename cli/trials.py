"""How the trial flights of a mission are shown."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from fsm import Graph
from runner.trial_flights import Clearance, TrialFlight


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
