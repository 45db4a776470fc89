"""Shipped missions in the simulator, saved and gone on with after every period."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pytest

from behaviors import MissionFrame, Pilot
from behaviors.pilot import resume_flight, save_flight
from hal import Options, open_backend
from runner import missions
from runner.preparation import prepare


def flown(mission: str, post: Mapping[int, str], saved: bool) -> list[Any]:
    """All that happens, period by period; ``post`` says in which one an event comes."""
    prepared = prepare(missions.find(mission))
    trace: list[Any] = []
    with open_backend("sim", Options(world=prepared.world_word, seed=0)) as session:
        (vehicle,) = session.vehicles.values()
        session.wait()
        frame = MissionFrame.at_start(vehicle.observe(), session.places, session.geographic)
        pilot = Pilot(prepared.graph, vehicle, frame=frame, seed=0)
        while not pilot.finished:
            if len(trace) in post:
                pilot.instance.post(post[len(trace)])
            pilot.period()
            records, pilot.instance.records = pilot.instance.records, []
            trace.append((pilot.channel.world, records, pilot.outcome))
            if saved:
                known = json.loads(json.dumps(save_flight(pilot), allow_nan=False))
                places, origin = session.places, session.geographic
                graph = prepared.graph
                pilot = resume_flight(graph, vehicle, known, places=places, geographic=origin)
            session.wait()
    return trace


@pytest.mark.parametrize(
    ("mission", "post"),
    [
        ("beacon_route", {}),
        ("first_flight", {200: "operator.takeover", 300: "operator.release"}),
        ("first_flight", {200: "operator.abort"}),
    ],
)
def test_saved_after_every_period_the_flight_is_the_same(
    mission: str, post: Mapping[int, str]
) -> None:
    assert flown(mission, post, saved=True) == flown(mission, post, saved=False)
