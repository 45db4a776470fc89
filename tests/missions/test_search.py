"""search: a sweep with a companion that detects; each tag is saved once."""

from __future__ import annotations

from math import dist

import pytest

from runner.testing import fly_mission
from worlds import find_world

TAGS = {thing.name: thing.at for thing in find_world("tag_field").things}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_each_tag_is_saved_once_where_the_vehicle_was_above_it(seed: int) -> None:
    flight = fly_mission("search", noise=1.0, seed=seed)
    assert (flight.outcome, flight.reason) == ("done", "")
    found = flight.output["found"]
    assert len(found) == len(TAGS) == 6
    for place in TAGS.values():
        # It saves its own place, up to 60 pixels (1.3 m) aside and half a second late.
        assert min(dist(place[:2], at[:2]) for at in found) < 2.2
    kept = [fields["with"] for _, kind, fields in flight.records if kind == "call"]
    assert sorted(each["name"] for each in kept) == [f"tag_{n}" for n in (12, 20, 21, 3, 30, 7)]
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_it_comes_home_when_the_battery_is_low_and_when_its_patience_is_over() -> None:
    for flight in (
        fly_mission("search", post={30.0: "battery.low"}),
        fly_mission("search", {"patience": "26 s"}),
    ):
        assert flight.states == ["takeoff", "barrido.fly", "come_home", "land", "finish"]
        assert flight.time < 65 and 0 < len(flight.output["found"]) < 6


@pytest.mark.slow
def test_where_there_are_no_tags_it_says_so() -> None:
    flight = fly_mission("search", {"patience": "5 s"}, world="empty")
    assert flight.outcome == "nothing_found"
