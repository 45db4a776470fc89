"""The shipped fleets in the simulator, asserted on the flights that came of them."""

from __future__ import annotations

from functools import cache
from math import cos, pi, sin

import pytest

from runner import FleetFlight, fly_fleet, missions, prepare_fleet
from tests.missions.shipped import FLEETS
from vencejo.geometry import Point, distance

HOMING = ["fleet_dance", "handover"]
"""Those whose vehicles land where they began."""
DANCERS = ["ada", "bo", "cleo", "dani", "emil"]


@cache
def flown(fleet: str, noise: float = 0.0, seed: int = 3) -> FleetFlight:
    return fly_fleet(fleet, noise=noise, seed=seed)


def entered(flight: FleetFlight, vehicle: str, state: str) -> float:
    """When a vehicle first entered a state, seconds."""
    return next(
        time
        for time, kind, fields in flight.vehicles[vehicle].records
        if kind == "enter" and fields["state"] == state
    )


def at(flight: FleetFlight, vehicle: str, time: float) -> Point:
    """Where a vehicle was, from its home."""
    return min(flight.vehicles[vehicle].track, key=lambda sample: abs(sample[0] - time))[1]


def test_all_shipped_fleets_are_tested_here() -> None:
    assert {*FLEETS} == {"cat_and_mouse", *HOMING}, "of cat_and_mouse by test_cat_and_mouse"


@pytest.mark.parametrize("fleet", FLEETS)
def test_nothing_is_wrong_with_it(fleet: str) -> None:
    assert prepare_fleet(missions.find(fleet)).faults == ()


@pytest.mark.parametrize("fleet", HOMING)
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_all_end_done_where_they_began(fleet: str, noise: float) -> None:
    flight = flown(fleet, noise)
    assert flight.summary.exit_code == 0
    for vehicle in flight.vehicles.values():
        assert (vehicle.outcome, vehicle.reason) == ("done", "")
        assert vehicle.states[-2:] == ["land", "finish"]
        assert vehicle.end.norm() < 0.3
    assert all(each.collisions == {} for each in flight.summary.vehicles.values())


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_no_two_dancers_come_nearer_than_a_metre(noise: float) -> None:
    flight = flown("fleet_dance", noise)
    assert list(flight.vehicles) == DANCERS
    assert len(flight.summary.separation) == 10
    assert 1.0 < flight.nearest.distance < 1.6
    assert entered(flight, "ada", "dance.star") < flight.nearest.time, "where their lines cross"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_no_two_dancers_come_near_whatever_the_noise(seed: int) -> None:
    flight = fly_fleet("fleet_dance", noise=1.0, seed=seed)
    assert flight.summary.exit_code == 0 and flight.nearest.distance > 1.0


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_the_dancers_begin_each_figure_together_and_dance_it(noise: float) -> None:
    flight = flown("fleet_dance", noise)
    for figure in ("ring", "wave", "gather", "star"):
        assert len({entered(flight, name, f"dance.{figure}") for name in DANCERS}) == 1
    for name, flown_ in flight.vehicles.items():
        seat = 2 * pi / 5 * DANCERS.index(name)
        middle = Point(-4 * cos(seat), -4 * sin(seat), 2)
        for k in range(5):
            place = middle.plus((4 * cos(seat + k * 2 * pi / 5), 4 * sin(seat + k * 2 * pi / 5), 0))
            assert flown_.nearest(place) < 0.6, "the ring and the star touch every seat"
        assert flown_.highest == pytest.approx(4.0, abs=0.15)
        gather = entered(flight, name, "dance.gather")
        near = [distance(p, middle) for t, p in flown_.track if gather < t < gather + 5]
        assert min(near) == pytest.approx(1.6, abs=0.5)
    tops = [max(f.track, key=lambda sample: sample[1].z)[0] for f in flight.vehicles.values()]
    assert tops == sorted(tops) and tops[-1] - tops[0] == pytest.approx(4.0, abs=0.5)


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_the_relief_takes_the_watch_over(noise: float) -> None:
    flight = flown("handover", noise)
    called, taken = entered(flight, "sentry", "call"), entered(flight, "sentry", "home")
    assert entered(flight, "relief", "takeoff") == pytest.approx(called + 0.025)
    joined = entered(flight, "relief", "patrol")
    assert taken == pytest.approx(joined + 0.025)
    post = at(flight, "sentry", called)
    over = at(flight, "relief", joined).plus((0, -3, 0))
    assert distance(over, post._replace(z=4.0)) < 0.3, "above the sentry, each from its own home"
    # The relief flies the sentry's square, twice.
    rounds = [fields for _, kind, fields in flight.vehicles["relief"].records if kind == "set"]
    assert len(rounds) == 4
    for corner in ((0, 3, 4), (6, 3, 4), (6, 9, 4), (0, 9, 4)):
        assert flight.vehicles["relief"].nearest(corner) < 0.7
    assert flight.nearest.distance > 1.5
    sent = [(t, f["to"]) for t, kind, f in flight.vehicles["relief"].records if kind == "send"]
    assert sent == [(joined, "sentry")]
