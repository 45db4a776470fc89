"""The shipped missions in the simulator, asserted on the flight that came of them."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path

import pytest

from runner import missions
from runner.testing import MissionFlight, fly_mission
from tests.missions.shipped import FLEETS, MISSIONS
from vencejo.geometry import Point, distance

SHIPPED = ("beacon_route", "figure_eight", "first_flight", "inspect_tower", "survey_square")
BEACONS = {"b1": Point(5, 0, 3), "b2": Point(5, 5, 4), "b3": Point(0, 5, 3)}
LOW_BATTERY = Path(__file__).parents[1] / "worlds_for_tests" / "low_battery.yaml"


@cache
def flown(mission: str, noise: float = 0.0) -> MissionFlight:
    """The flight at default parameters."""
    return fly_mission(mission, noise=noise, seed=3)


def first_within(flight: MissionFlight, place: Point, reach: float) -> float:
    """When it first came that near, seconds."""
    return next(time for time, at in flight.track if distance(at, place) <= reach)


def events(flight: MissionFlight) -> list[str]:
    return [fields["name"] for _, kind, fields in flight.records if kind == "event"]


def speeds(flight: MissionFlight) -> list[float]:
    return [distance(a, b) / (later - sooner) for (sooner, a), (later, b) in pairwise(flight.track)]


@pytest.mark.parametrize("mission", SHIPPED)
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_each_ends_done_where_it_began(mission: str, noise: float) -> None:
    flight = flown(mission, noise)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert flight.states[0] == "takeoff"
    assert flight.states[-2:] == ["land", "finish"]
    assert flight.end.norm() < 0.2
    assert min(place.z for _, place in flight.track) > -0.05


def test_first_flight_flies_its_square() -> None:
    flight = flown("first_flight")
    corners = [Point(4, 0, 2), Point(4, 4, 2), Point(0, 4, 2), Point(0, 0, 2)]
    assert flight.states[1:-2] == [f"square.{side}" for side in ("east", "north", "west", "south")]
    assert all(flight.nearest(corner) < 0.05 for corner in corners)
    assert 1.45 < max(speeds(flight)[80:600]) < 1.5 * 1.05
    assert flight.time < 22


def test_first_flight_neither_bumps_nor_wobbles() -> None:
    flight = flown("first_flight")
    begun = next(
        time for time, kind, fields in flight.records
        if kind == "enter" and fields["state"] == "square.east"
    )  # fmt: skip
    over = next(
        time for time, kind, fields in flight.records
        if kind == "enter" and fields["state"] == "land"
    )  # fmt: skip
    heights = [place.z for time, place in flight.track if begun + 0.5 < time < over]
    assert max(heights) < 2.02 and min(heights) > 1.95
    inside = [place for time, place in flight.track if begun < time < over]
    assert all(-0.05 < place.x < 4.05 and -0.05 < place.y < 4.05 for place in inside)


def test_first_flight_takes_parameters() -> None:
    flight = fly_mission("first_flight", {"altitude": "5 m", "side": "8 m", "speed": "3 m/s"})
    assert flight.outcome == "done"
    assert flight.nearest((8, 8, 5)) < 0.05
    assert max(speeds(flight)) == pytest.approx(3.0, abs=0.2)


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_beacon_route_reaches_every_beacon_in_order(noise: float) -> None:
    flight = flown("beacon_route", noise)
    times = [first_within(flight, beacon, 0.5) for beacon in BEACONS.values()]
    assert times == sorted(times)
    assert flight.output == {"reached": 3, "of": 3}
    assert flight.states.count("travel.leg") == 3


def test_beacon_route_takes_other_beacons() -> None:
    flight = fly_mission(
        "beacon_route", {"beacons": "[b3, [2, 2, 5], b1]", "reach": "20 cm", "cruise": "3 m/s"}
    )
    assert flight.outcome == "done"
    stops = [BEACONS["b3"], Point(2, 2, 5), BEACONS["b1"]]
    times = [first_within(flight, stop, 0.2) for stop in stops]
    assert times == sorted(times)
    assert fly_mission("beacon_route", {"beacons": "[]"}).output == {"reached": 0, "of": 0}


def test_beacon_route_comes_home_when_the_battery_is_low() -> None:
    flight = fly_mission("beacon_route", post={6.0: "battery.low"})
    assert flight.outcome == "done"
    assert flight.states[-3:] == ["come_home", "land", "finish"]
    assert flight.output["reached"] < 3
    assert flight.end.norm() < 0.2


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_survey_square_flies_its_lanes_and_looks_at_the_centre(noise: float) -> None:
    flight = flown("survey_square", noise)
    assert flight.output == {"lanes": 4, "centre_seen": True}
    for x in (0, 4, 8, 12):
        assert flight.nearest((x, 6, 4)) < 0.1
    assert events(flight).count("route.reached") == 8
    assert flight.states[1:5] == [
        "survey.sweep",
        "survey.inspect.approach",
        "survey.inspect.look",
        "survey.inspect.looked",
    ]


def test_survey_square_comes_home_early_when_the_battery_is_low() -> None:
    flight = fly_mission("survey_square", world=str(LOW_BATTERY))
    assert flight.outcome == "cut_short"
    assert "battery.low" in events(flight)
    assert flight.states == ["takeoff", "survey.sweep", "come_home", "land", "cut_short"]
    assert 0 < flight.output["lanes"] < 4
    assert flight.output["centre_seen"] is False
    assert flight.end.norm() < 0.2


def test_survey_square_takes_parameters() -> None:
    flight = fly_mission("survey_square", {"side": "6 m", "altitude": "8 m", "look": "1 s"})
    assert flight.outcome == "done"
    assert flight.nearest((6, 0, 8)) < 0.5
    assert flight.highest < 8.1


def test_a_flight_is_the_same_whenever_it_is_flown() -> None:
    first, again = (fly_mission("beacon_route", noise=1.0, seed=7) for _ in range(2))
    other = fly_mission("beacon_route", noise=1.0, seed=8)
    assert first.records == again.records
    assert first.track == again.track
    assert first.track != other.track


def test_all_shipped_missions_are_tested_here_or_in_a_module_beside() -> None:
    modules = [path.read_text("utf-8") for path in Path(__file__).parent.glob("test_*.py")]
    for mission in {*MISSIONS} - {*SHIPPED}:
        assert any(f'"{mission}"' in module for module in modules), mission
    assert {*MISSIONS, *FLEETS} == missions.names().keys()


def test_figure_eight_keeps_to_its_curve_and_speed() -> None:
    flight = flown("figure_eight")
    (begun,) = [t for t, kind, f in flight.records if kind == "enter" and f["state"] == "eight"]
    laps = [t for t, kind, f in flight.records if kind == "event" and f["name"] == "path.lap"]
    angles = [k * 2 * pi / 1000 for k in range(1000)]
    curve = [Point(4 * cos(a), 2 * sin(2 * a), 3) for a in angles]
    track = [(t, place) for t, place in flight.track if begun + 8 < t < laps[-1]]
    off = [min(distance(place, on) for on in curve) for _, place in track[::4]]
    assert max(off) < 0.05
    fast = [distance(a, b) / (u - t) for (t, a), (u, b) in pairwise(track)]
    assert 1.9 < max(fast) < 2.0 * 1.05
    assert len(laps) == 2


def test_inspect_tower_looks_at_the_shed_from_all_sides() -> None:
    flight = flown("inspect_tower")
    assert flight.output == {"pictures": [f"side_{k}" for k in (1, 2, 3, 4)]}
    around = [
        place for time, place in flight.track if time > 10 and distance(place, (6, 2, 3)) < 5.5
    ]
    assert min(distance(place, (6, 2, 3)) for place in around) > 4.8
    taken = [f["fields"] for _, kind, f in flight.records if kind == "outcome" and f.get("fields")]
    for photo in taken:
        assert distance(photo["position"], (6, 2, 3)) == pytest.approx(5.0, abs=0.3)
