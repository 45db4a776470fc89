"""Saving a mission in flight and going on with it: the instance, and what its pilot knows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from behaviors.flight import MissionFrame
from behaviors.pilot import Pilot
from behaviors.watch import Thresholds
from fsm.chart.graph import Graph
from fsm.engine.saving import TORN, load, save
from fsm.values.packing import pack, unpack
from hal.vehicle import Position, Vehicle
from vencejo.errors import UserError
from vencejo.geometry import Point

PARTS = {"origin", "watch", "rng", "last", "outcome", "reason", "ended_at", "landing"}


def save_flight(pilot: Pilot) -> dict[str, Any]:
    """A flight at the end of a period, as JSON holds it; the vehicle itself is not in it."""
    last = pilot._last
    return {
        **save(pilot.instance),
        "pilot": {
            "origin": pack(pilot.flight.frame.origin),
            "watch": pilot._watch.progress(),
            "rng": pack(pilot.flight.rng.getstate()),
            "last": pack([*last]) if isinstance(last, Position) else None,
            "outcome": pilot.outcome,
            "reason": pilot.reason,
            "ended_at": pilot._ended_at,
            "landing": pilot._landing_asked if pilot.landing else None,
        },
    }


def resume_flight(
    graph: Graph,
    vehicle: Vehicle,
    saved: Mapping[str, Any],
    *,
    places: Mapping[str, Point] | None = None,
    geographic: tuple[float, float, float] | None = None,
    thresholds: Thresholds | None = None,
) -> Pilot:
    """A pilot that goes on with a saved flight.

    Raises UserError (see fsm.engine.saving.restore).
    """
    known = saved.get("pilot")
    if not isinstance(known, Mapping) or known.keys() != PARTS:
        raise _torn()
    try:
        frame = MissionFrame(unpack(known["origin"]), places, geographic)
        pilot = Pilot(graph, vehicle, frame=frame, thresholds=thresholds)
        _go_on(pilot, known)
    except TORN:
        raise _torn() from None
    load(pilot.instance, saved)
    if known["landing"] is not None:
        # The vehicle is at it already: this gives the order back.
        pilot.landing = vehicle.land()
    return pilot


def _go_on(pilot: Pilot, known: Mapping[str, Any]) -> None:
    pilot._watch.go_on(known["watch"])
    pilot.flight.rng.setstate(unpack(known["rng"]))
    if known["last"] is not None:
        pilot._last = Position(*unpack(known["last"]))
    pilot.outcome, pilot.reason = known["outcome"], known["reason"]
    pilot._ended_at = known["ended_at"]
    if known["landing"] is not None:
        pilot._landing_asked = float(known["landing"])


def _torn() -> UserError:
    hint = "name a file of a flight, or start the mission anew"
    return UserError("torn-save", "this is no whole saved flight", hint=hint)
