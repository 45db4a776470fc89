"""square: four sides by place, so that it ends where it began."""

from __future__ import annotations

from pathlib import Path

import pytest

from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import horizontal_distance

TIMED = Path(__file__).parents[1] / "fsm" / "lrp" / "square.yaml"
"""The square as it was printed: eight times of 0.8 s, ended after 8 s."""


def closure(flight: MissionFlight) -> float:
    """How far from its start it landed, metres over the ground."""
    return horizontal_distance(flight.end, flight.track[0][1])


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_it_flies_its_four_sides_and_lands_where_it_began(noise: float) -> None:
    flight = fly_mission("square", noise=noise, seed=5)
    assert (flight.outcome, flight.reason) == ("done", "")
    sides = [f"flying.{side}" for side in ("forward", "right", "back", "left")]
    assert flight.states == ["takingoff", *sides, "landing", "finish"]
    for corner in ((2, 0), (2, -2), (0, -2)):
        assert flight.nearest((*corner, 1.5)) < 0.1
    inside = [place for _, place in flight.track]
    assert all(-0.15 < p.x < 2.15 and -2.15 < p.y < 0.15 for p in inside)
    assert closure(flight) < 0.1


def test_by_the_clock_it_lands_elsewhere() -> None:
    """As printed its second forward leg ends the flight a side ahead."""
    assert closure(fly_mission(TIMED)) > 0.3


def test_it_turns_with_the_vehicle(tmp_path: Path) -> None:
    world = tmp_path / "turned.yaml"
    world.write_text("world: turned\nstart: {at: [3, 1], heading: 90 deg}\n")
    flight = fly_mission("square", {"side": "1 m"}, world=str(world))
    assert flight.outcome == "done"
    # Ahead is north, right is east.
    assert all(flight.nearest((*corner, 1.5)) < 0.1 for corner in ((0, 1), (1, 1), (1, 0)))
    assert closure(flight) < 0.1


def test_a_low_battery_ends_it() -> None:
    flight = fly_mission("square", post={6.0: "battery.low"})
    assert flight.outcome == "cut_short" and flight.output == {"sides": 1}
    assert flight.states[-3:] == ["flying.right", "landing", "cut_short"]
    assert flight.end.z == pytest.approx(0, abs=0.02)


def test_a_timeout_ends_it() -> None:
    flight = fly_mission("square", {"patience": "10 s"})
    assert flight.outcome == "cut_short" and flight.output == {"sides": 2}
    assert flight.states[-2:] == ["landing", "cut_short"]
    assert flight.time < 20


def test_a_corner_that_it_cannot_reach_ends_it(tmp_path: Path) -> None:
    world = tmp_path / "walled.yaml"
    world.write_text(
        "world: walled\nstart: {at: [0, 0]}\n"
        "walls: {wall: {through: [[1.2, -4], [1.2, 4]], height: 4 m}}\n"
    )
    flight = fly_mission("square", world=str(world))
    assert flight.outcome == "cut_short" and flight.output == {"sides": 0}
    assert "blocked" in [fields.get("name") for _, _, fields in flight.records]
    assert flight.end.x < 1.2
    assert flight.end.z == pytest.approx(0, abs=0.02)
