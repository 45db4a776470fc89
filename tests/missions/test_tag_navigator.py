"""tag_navigator: round after round over roundels that point to each other."""

from __future__ import annotations

from math import cos, pi, sin
from pathlib import Path

import pytest

from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import Point, horizontal_distance
from worlds import find_world

START = find_world("roundel_ring").starts[0].at
ROUNDELS = [
    thing.at.minus(START) for thing in find_world("roundel_ring").things if thing.kind == "roundel"
]
"""Mission frame."""


def left(flight: MissionFlight, state: str) -> list[Point]:
    """Where it was whenever it left a state."""
    places = dict(flight.track)
    return [
        places[time] for time, kind, f in flight.records if kind == "exit" and f["state"] == state
    ]


@pytest.mark.slow
def test_it_stops_above_each_roundel_in_turn() -> None:
    flight = fly_mission("tag_navigator", noise=1.0, seed=1)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert flight.output == {"visited": [1, 2, 3, 4, 1, 2, 3, 4, 1]}
    above = left(flight, "navigate.center")
    assert len(above) == 9
    for k, place in enumerate(above):
        assert horizontal_distance(place, ROUNDELS[k % 4]) < 0.1
        assert place.z == pytest.approx(1.0, abs=0.1)
    assert horizontal_distance(flight.end, ROUNDELS[0]) < 0.15


@pytest.mark.slow
def test_any_regular_polygon_will_do(tmp_path: Path) -> None:
    lines, x, y = [], 0.0, 0.0
    for k in range(6):
        lines.append(f"  r{k}: {{at: [{x}, {y}], size: 30 cm, heading: {60 * k} deg}}\n")
        x, y = x + 1.8 * cos(k * pi / 3), y + 1.8 * sin(k * pi / 3)
    world = tmp_path / "hexagon.yaml"
    world.write_text(
        "world: hexagon\nstart: {at: [0.2, 0.1]}\nground: {color: grass, size: 60 m}\n"
        f"roundels:\n{''.join(lines)}"
    )
    flight = fly_mission("tag_navigator", {"rounds": "1"}, world=str(world), noise=1.0, seed=3)
    assert (flight.outcome, flight.output) == ("done", {"visited": [1, 2, 3, 4, 5, 6, 1]})


def ring(folder: Path, second: str = "1.8, 0", battery: str = "100 %") -> str:
    path = folder / "ring.yaml"
    path.write_text(
        f"world: ring\nbattery: {battery}\nstart: {{at: [-0.2, -0.15]}}\n"
        "ground: {color: asphalt, size: 60 m}\nroundels:\n  first: {at: [0, 0], size: 30 cm}\n"
        f"  second: {{at: [{second}], size: 30 cm, heading: 180 deg}}\n"
    )
    return str(path)


@pytest.mark.slow
def test_two_that_point_to_each_other_will_do(tmp_path: Path) -> None:
    flight = fly_mission("tag_navigator", {"rounds": "1"}, world=ring(tmp_path), noise=1.0)
    assert (flight.outcome, flight.output) == ("done", {"visited": [1, 2, 1]})


@pytest.mark.slow
def test_one_that_is_not_where_it_was_expected_is_found_from_higher_up(tmp_path: Path) -> None:
    """It is 80 cm too far and aside, out of view of the height at which the vehicle flies."""
    world = ring(tmp_path, "2.6, 0.3")
    flight = fly_mission("tag_navigator", {"rounds": "1"}, world=world, noise=1.0)
    assert flight.outcome == "done"
    assert 1.5 < flight.highest < 2.1


@pytest.mark.slow
def test_a_roundel_that_is_nowhere_ends_it(tmp_path: Path) -> None:
    flight = fly_mission("tag_navigator", world=ring(tmp_path, "9, 9"), noise=1.0)
    assert flight.outcome == "cut_short"
    assert flight.output == {"visited": [1], "rounds": 0}
    assert 1.9 < flight.highest < 2.1
    assert flight.states[-3:] == ["navigate.center.search", "land", "cut_short"]
    assert flight.end.z == pytest.approx(0, abs=0.02)


@pytest.mark.slow
def test_a_low_battery_ends_it() -> None:
    flight = fly_mission("tag_navigator", post={6.0: "battery.low"})
    assert flight.outcome == "cut_short" and flight.output["visited"] == [1]
    assert flight.end.z == pytest.approx(0, abs=0.02) and flight.time < 12


@pytest.mark.slow
def test_a_timeout_ends_it() -> None:
    flight = fly_mission("tag_navigator", {"limit": "10 s"})
    assert flight.outcome == "cut_short" and flight.time < 17
    assert flight.end.z == pytest.approx(0, abs=0.02)
