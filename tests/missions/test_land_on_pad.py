"""land_on_pad and land_on_moving_pad: land in the middle of a pad, or where it began."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import pytest

from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import Point
from worlds import find_world
from worlds.motion import pose_at

PAD = next(thing for thing in find_world("pad").things if thing.name == "pad")
MOVING = find_world("moving_pad")
MOVING_PAD = next(thing for thing in MOVING.things if thing.name == "pad")
BARE = "world: bare\nstart: {at: [0, 0]}\nplaces: {near_pad: [3, 1, 3]}\n"
BOTH = pytest.mark.parametrize("mission", ["land_on_pad", "land_on_moving_pad"])


@pytest.fixture
def bare(tmp_path: Path) -> str:
    """A world without a pad."""
    world = tmp_path / "bare.yaml"
    world.write_text(BARE)
    return str(world)


def beside_moving(time: float, place: Point) -> float:
    """Distance over the ground from the middle of the pad; ``place`` is in the mission frame."""
    home, (at, _) = MOVING.starts[0].at, pose_at(MOVING_PAD, time)
    return hypot(place.x + home.x - at.x, place.y + home.y - at.y)


def time_in(flight: MissionFlight, state: str) -> float:
    """For how long it was in a state that it entered once, seconds."""
    begin, end = (
        time
        for time, kind, fields in flight.records
        if kind in ("enter", "exit") and fields["state"] == state
    )
    return end - begin


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_it_stands_in_the_middle_of_the_pad(seed: int) -> None:
    flight = fly_mission("land_on_pad", seed=seed, noise=1.0)
    assert (flight.outcome, flight.reason) == ("done", "")
    x, y, z = flight.end
    assert hypot(x - PAD.at.x, y - PAD.at.y) < 0.05
    assert z == pytest.approx(0.3, abs=0.005)
    assert flight.states == ["takeoff", "there", "pad", "on_the_pad"]
    assert not [fields for _, _, fields in flight.records if "collision" in str(fields)]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_it_stands_on_the_moving_pad_and_rides(seed: int) -> None:
    flight = fly_mission("land_on_moving_pad", seed=seed, noise=1.0)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert flight.states == ["takeoff", "there", "pad", "ride", "on_the_pad"]
    riding = [(time, place) for time, place in flight.track if time > flight.time - 4.0]
    offs = [beside_moving(time, place) for time, place in riding]
    assert max(offs) < 0.07
    # It neither slips nor drifts on the pad, which goes round a bend meanwhile.
    assert max(offs) - min(offs) < 0.01
    assert all(place.z == pytest.approx(0.3, abs=0.005) for _, place in riding)


@pytest.mark.slow
@BOTH
def test_without_a_pad_it_lands_where_it_began(mission: str, bare: str) -> None:
    flight = fly_mission(mission, world=bare)
    assert flight.outcome == "lost"
    assert flight.states[-4:] == ["pad", "come_home", "come_down", "elsewhere"]
    assert flight.end.norm() < 0.2


@pytest.mark.slow
@BOTH
def test_a_timeout_brings_it_home(mission: str, bare: str) -> None:
    flight = fly_mission(mission, {"patience": "10 s"}, world=bare)
    assert flight.states[-4:] == ["pad", "come_home", "come_down", "elsewhere"]
    assert time_in(flight, "pad") == pytest.approx(10.0, abs=0.05)
    assert flight.end.norm() < 0.2 and flight.time < 30


@pytest.mark.slow
@pytest.mark.parametrize("when", [3.0, 8.0, 11.0])
def test_a_low_battery_lands_it_at_once(when: float) -> None:
    """On the way, over the pad, and on the way down to it."""
    flight = fly_mission("land_on_pad", post={when: "battery.low"})
    assert flight.states[-2:] == ["come_down", "elsewhere"]
    assert flight.time < when + 10.0


@pytest.mark.slow
def test_a_low_battery_lands_it_beside_the_moving_pad() -> None:
    flight = fly_mission("land_on_moving_pad", post={10.0: "battery.low"})
    assert flight.states[-2:] == ["come_down", "elsewhere"]
    assert flight.time < 20.0 and flight.end.z < 0.35
