"""sweep_detect: all that is in the meadow is found, also after a change of batteries."""

from __future__ import annotations

from collections.abc import Mapping
from math import dist
from typing import Any

import pytest

from runner.testing import MissionFlight, fly_mission
from worlds import find_world

WANTED = {
    "person": ("sleeper", "swimmer", "farmer", "child", "warden"),
    "buoy": ("buoy_west", "buoy_east", "buoy_north"),
    "marker": ("gate", "pier", "hide", "stile"),
}


def found(flight: MissionFlight, status: str) -> list[Mapping[str, Any]]:
    """What was told of things with a status."""
    return [
        fields["fields"]
        for _, kind, fields in flight.records
        if kind == "event"
        and fields["name"] == "thing.found"
        and fields["fields"]["status"] == status
    ]


def assert_all_found(flight: MissionFlight) -> None:
    """Each thing once, where it is, and nothing else."""
    new, last = found(flight, "new"), {told["id"]: told for told in found(flight, "known")}
    assert sorted(flight.output["found"]) == sorted(told["id"] for told in new) == sorted(last)
    places = {thing.name: thing.at for thing in find_world("meadow").things}
    for kind, names in WANTED.items():
        left = [told["position"] for told in last.values() if told["kind"] == kind]
        assert len(left) == len(names), kind
        for name in names:
            assert min(dist(at[:2], places[name][:2]) for at in left) < 0.15, name


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 5])
def test_all_is_found_and_told_from_what_is_like_it(seed: int) -> None:
    flight = fly_mission("sweep_detect", noise=1.0, seed=seed)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert_all_found(flight)
    # It never flies over the pond, and never leaves the meadow while it searches.
    for _, at in flight.track:
        assert not (16.5 < at.x < 23.5 and -2.5 < at.y < 3.5)
        assert -13.5 < at.y < 16.5 and at.x < 38.5
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_after_a_change_of_batteries_it_goes_on_where_it_was() -> None:
    flight = fly_mission("sweep_detect", noise=1.0, seed=3, post={60.0: "battery.low"})
    assert (flight.outcome, flight.reason) == ("done", "")
    states = ["takeoff", "search.sweep", "swap.back", "swap.down", "swap.change"]
    assert flight.states == [*states, *states[:2], "come_home", "land", "finish"]
    assert_all_found(flight)
    # From home and back it is 50 m or so, and no lane is flown twice.
    whole = sum(dist(a, b) for (_, a), (_, b) in zip(flight.track, flight.track[1:], strict=False))
    assert whole < 340


@pytest.mark.slow
def test_when_the_second_battery_is_low_it_comes_home_with_what_it_has() -> None:
    posts = {20.0: "battery.low", 60.0: "battery.low"}
    flight = fly_mission("sweep_detect", post=posts)
    assert flight.outcome == "done"
    assert flight.states[-3:] == ["come_home", "land", "finish"]
    assert flight.states.count("swap.change") == 1
    assert 0 < len(flight.output["found"]) < 12


@pytest.mark.slow
def test_when_its_patience_is_over_it_comes_home() -> None:
    flight = fly_mission("sweep_detect", {"patience": "20 s"})
    assert (flight.outcome, flight.states[-3:]) == ("done", ["come_home", "land", "finish"])
    assert flight.time < 55 and flight.end.norm() < 0.2


@pytest.mark.slow
def test_where_there_is_nothing_it_says_so() -> None:
    flight = fly_mission("sweep_detect", {"patience": "15 s"}, world="empty")
    assert flight.outcome == "nothing_found" and found(flight, "new") == []
