"""land_on_moving_pad: land on a pad that goes round, and ride on it."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import pytest

from runner.testing import fly_mission
from vencejo.geometry import Point
from worlds import find_world
from worlds.motion import pose_at

WORLD = find_world("moving_pad")
PAD = next(thing for thing in WORLD.things if thing.name == "pad")
HOME = WORLD.starts[0].at
BARE = "world: bare\nstart: {at: [0, 0]}\nplaces: {near_pad: [3, 1, 3]}\n"


def off(time: float, place: Point) -> float:
    """Distance over the ground from the middle of the pad; ``place`` is in the mission frame."""
    at, _ = pose_at(PAD, time)
    return hypot(place.x + HOME.x - at.x, place.y + HOME.y - at.y)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_it_stands_on_the_pad_and_rides(seed: int) -> None:
    flight = fly_mission("land_on_moving_pad", seed=seed, noise=1.0)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert flight.states == ["takeoff", "there", "pad", "ride", "on_the_pad"]
    riding = [(time, place) for time, place in flight.track if time > flight.time - 4.0]
    offs = [off(time, place) for time, place in riding]
    assert max(offs) < 0.07
    # It neither slips nor drifts on the pad, which goes round a bend meanwhile.
    assert max(offs) - min(offs) < 0.01
    assert all(place.z == pytest.approx(0.3, abs=0.005) for _, place in riding)


@pytest.mark.slow
def test_without_a_pad_it_lands_where_it_began(tmp_path: Path) -> None:
    world = tmp_path / "bare.yaml"
    world.write_text(BARE)
    flight = fly_mission("land_on_moving_pad", world=str(world))
    assert flight.outcome == "lost"
    assert flight.states[-4:] == ["pad", "come_home", "come_down", "elsewhere"]
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_a_low_battery_lands_it_at_once() -> None:
    flight = fly_mission("land_on_moving_pad", post={10.0: "battery.low"})
    assert flight.states[-2:] == ["come_down", "elsewhere"]
    assert flight.time < 20.0 and flight.end.z < 0.35


@pytest.mark.slow
def test_a_timeout_brings_it_home(tmp_path: Path) -> None:
    world = tmp_path / "bare.yaml"
    world.write_text(BARE)
    flight = fly_mission("land_on_moving_pad", {"patience": "10 s"}, world=str(world))
    assert flight.states[-3:] == ["come_home", "come_down", "elsewhere"]
    assert flight.end.norm() < 0.2 and flight.time < 30
