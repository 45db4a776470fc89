"""What a behaviour publishes, as its mission reads it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pytest

from behaviors import Behavior, describe, value
from behaviors.pilot import resume_flight, save_flight
from tests.behaviors.flying import Rig
from vencejo.geometry import Point


@dataclass(frozen=True, slots=True)
class Sighting:
    """A thing that was seen."""

    seen: bool = False
    """Whether anything was."""
    distance: float = value("m")
    """How far away."""
    name: str = "nothing"
    """Its name."""


class Glimpse(Behavior):
    """Sees something in its third step, and never again."""

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]
    publishes = Sighting
    controls = ()

    def start(self, flight: Any, progress: Any = None) -> None:
        self.steps = progress["steps"] if progress else 0

    def step(self, flight: Any) -> None:
        self.steps += 1
        if self.steps == 3:
            flight.publish(Sighting(True, 2.5, "gate"))

    def progress(self) -> dict[str, Any]:
        return {"steps": self.steps}


OWN = {"glimpse": describe(Glimpse)}
LOOKING = """
mission: looking
do: glimpse
throughout: {log: "${glimpse.seen} ${glimpse.distance} ${glimpse.name}"}
states:
  wait: {after: {2 s: end}}
  end: {type: final}
"""


def logged(rig: Rig) -> list[str]:
    return [str(fields["text"]) for kind, fields in rig.records if kind == "log"]


def test_it_is_blank_until_the_first_word_and_then_stays() -> None:
    rig = Rig(LOOKING, own=OWN)
    for _ in range(6):
        rig.period()
    assert logged(rig) == ["false 0 nothing"] * 3 + ["true 2.5 gate"] * 3


def test_a_saved_flight_goes_on_with_what_was_said_before() -> None:
    rig = Rig(LOOKING, own=OWN)
    for _ in range(5):
        rig.period()
    saved = json.loads(json.dumps(save_flight(rig.pilot), allow_nan=False))
    rig.pilot = resume_flight(rig.pilot.instance.graph, rig.vehicle, saved)
    rig.records.clear()
    for _ in range(3):
        rig.period()
    assert logged(rig) == ["true 2.5 gate"] * 3


def test_a_condition_reads_it_while_the_behaviour_flies() -> None:
    rig = Rig(
        "mission: near\nstates:\n  takeoff: {do: takeoff, with: {altitude: 3 m}, on: {done: out}}\n"
        "  out:\n    do: goto\n    as: way\n    with: {to: [9, 0, 3], speed: 2 m/s}\n"
        '    when: {"way.distance < 4 m and way.elapsed > 1 s": stay}\n'
        "    on: {done: land, blocked: land}\n"
        "  stay: {after: {1 s: land}}\n"
        "  land: {do: land, on: {done: end}}\n  end: {type: final}\n"
    )
    rig.until_in("stay")
    assert rig.vehicle.position == pytest.approx(Point(5.0, 0.0, 3.0), abs=0.2)
    assert rig.vehicle.position.x > 5.0
