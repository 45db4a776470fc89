"""cat_and_mouse: the shipped game of a cat and a mouse."""

from __future__ import annotations

import pytest

from runner import FleetFlight, fly_fleet
from vencejo.geometry import Point, distance

CAT, MOUSE = Point(-4.0, -3.0, 0.0), Point(3.0, 2.0, 0.0)
"""Where they start, world frame."""
SHORT = {"mouse.durations": "[6 s, 6 s]", "mouse.speeds": "[0 m/s, 1 m/s]"}


def logged(flight: FleetFlight, vehicle: str) -> list[str]:
    return [fields["text"] for _, kind, fields in flight.vehicles[vehicle].records if kind == "log"]


def test_the_cat_finds_the_mouse_and_stays_until_the_game_is_over() -> None:
    flight = fly_fleet("cat_and_mouse", SHORT, noise=1.0, seed=2)
    assert flight.summary.exit_code == 0
    assert all(each.collisions == {} for each in flight.summary.vehicles.values())
    assert logged(flight, "cat") == ["the mouse is in sight"]
    assert logged(flight, "mouse") == ["level 1", "level 2"]
    cat, mouse = flight.vehicles["cat"], flight.vehicles["mouse"]
    assert cat.states == ["takeoff", "hunt", "land", "finish"]
    far = [
        distance(CAT.plus(one), MOUSE.plus(other))
        for (time, one), (_, other) in zip(cat.track, mouse.track, strict=False)
        if 10 < time < 13.5
    ]
    assert all(2.4 < each < 3.6 for each in far)
    verdict = flight.summary.verdict
    assert verdict is not None and verdict.losses == 0 and flight.nearest.distance > 2.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_the_whole_game_at_all_levels(seed: int) -> None:
    flight = fly_fleet("cat_and_mouse", noise=1.0, seed=seed)
    assert flight.summary.exit_code == 0 and flight.nearest.distance > 1.5
    verdict = flight.summary.verdict
    assert verdict is not None and verdict.losses == 0
    assert verdict.time_near > 0.8 * verdict.time
    assert logged(flight, "mouse") == ["level 1", "level 2", "level 3", "level 4"]


@pytest.mark.slow
def test_a_cat_that_never_sees_the_mouse_gives_up() -> None:
    flight = fly_fleet("cat_and_mouse", {"cat.color": "magenta", "cat.patience": "12 s"})
    cat = flight.vehicles["cat"]
    assert cat.outcome == "lost" and cat.states == ["takeoff", "hunt", "give_up", "lost"]
    assert flight.vehicles["mouse"].outcome == "done" and flight.summary.exit_code == 1


@pytest.mark.slow
def test_a_low_battery_ends_the_hunt_of_either() -> None:
    flight = fly_fleet("cat_and_mouse", SHORT, post=["5s:cat:battery.low"])
    cat = flight.vehicles["cat"]
    assert cat.outcome == "done" and cat.states[-2:] == ["land", "finish"] and cat.time < 11
    flight = fly_fleet("cat_and_mouse", SHORT, post=["5s:mouse:battery.low"])
    assert {each.outcome for each in flight.vehicles.values()} == {"done"}
    assert all(each.time < 12 for each in flight.vehicles.values()), "the cat is told"


@pytest.mark.slow
def test_the_cat_gives_up_after_its_time() -> None:
    flight = fly_fleet("cat_and_mouse", {**SHORT, "cat.timeout": "6 s"})
    assert flight.vehicles["cat"].outcome == "lost" and flight.vehicles["cat"].time < 13
