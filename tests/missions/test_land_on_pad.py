"""land_on_pad: land in the middle of a pad, or where it began."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import pytest

from runner.testing import fly_mission
from worlds import find_world

PAD = next(thing for thing in find_world("pad").things if thing.name == "pad")
BARE = "world: bare\nstart: {at: [0, 0]}\nplaces: {near_pad: [3, 1, 3]}\n"


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
def test_without_a_pad_it_lands_where_it_began(tmp_path: Path) -> None:
    world = tmp_path / "bare.yaml"
    world.write_text(BARE)
    flight = fly_mission("land_on_pad", world=str(world))
    assert flight.outcome == "lost"
    assert flight.states[-4:] == ["pad", "come_home", "come_down", "elsewhere"]
    assert flight.end.norm() < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("when", [3.0, 8.0, 11.0])
def test_a_low_battery_lands_it_at_once(when: float) -> None:
    """On the way, over the pad, and on the way down to it."""
    flight = fly_mission("land_on_pad", post={when: "battery.low"})
    assert flight.states[-2:] == ["come_down", "elsewhere"]
    assert flight.time < when + 10.0


@pytest.mark.slow
def test_a_timeout_brings_it_home(tmp_path: Path) -> None:
    world = tmp_path / "bare.yaml"
    world.write_text(BARE)
    flight = fly_mission("land_on_pad", {"patience": "10 s"}, world=str(world))
    left = [time for time, kind, fields in flight.records if kind == "exit"]
    assert left
    assert flight.states[-3:] == ["come_home", "come_down", "elsewhere"]
    assert flight.end.norm() < 0.2 and flight.time < 30
