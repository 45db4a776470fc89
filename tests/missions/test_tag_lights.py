"""tag_lights: green while a tag is below, red while there is none."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from runner.testing import MissionFlight, fly_mission

ROW = {3: 2.0, 7: 4.2, 12: 6.0, 21: 7.8, 30: 10.0}
"""Marker → how far along the row it lies, metres."""


@cache
def flown(noise: float = 1.0) -> MissionFlight:
    return fly_mission("tag_lights", noise=noise, seed=4)


def entered(flight: MissionFlight, state: str) -> list[float]:
    """How far along the row it was whenever a state was entered."""
    places = dict(flight.track)
    return [
        places[time].x
        for time, kind, fields in flight.records
        if kind == "enter" and fields["state"].endswith(state)
    ]


@pytest.mark.slow
def test_each_tag_of_the_row_is_seen_and_shown() -> None:
    flight = flown()
    assert (flight.outcome, flight.reason) == ("done", "")
    assert flight.output == {"seen": list(ROW)}
    # From 1.5 m it sees 1.25 m along its way. The lights follow within a third of a second.
    shown = entered(flight, ".detected")
    assert len(shown) == 5
    for place, at in zip(shown, ROW.values(), strict=True):
        assert at - 0.65 < place < at - 0.2
    hidden = entered(flight, ".undetected")[1:]
    for place, at in zip(hidden, ROW.values(), strict=True):
        assert at + 0.2 < place < at + 0.95
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_without_tags_it_says_so(tmp_path: Path) -> None:
    world = tmp_path / "bare.yaml"
    world.write_text("world: bare\nstart: {at: [0, 0]}\nplaces: {end: [3, 0, 1.5]}\n")
    flight = fly_mission("tag_lights", world=str(world))
    assert flight.outcome == "nothing_seen"
    assert "look.lights.detected" not in flight.states
    assert flight.states[-3:] == ["come_home", "land", "nothing_seen"]
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_a_low_battery_brings_it_home() -> None:
    flight = fly_mission("tag_lights", post={8.0: "battery.low"})
    assert flight.states[-3:] == ["come_home", "land", "finish"]
    assert max(place.x for _, place in flight.track) < 6
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_a_timeout_brings_it_home() -> None:
    flight = fly_mission("tag_lights", {"patience": "5 s"})
    assert flight.states[-3:] == ["come_home", "land", "finish"]
    assert flight.output == {"seen": [3]}
    assert flight.end.norm() < 0.2
