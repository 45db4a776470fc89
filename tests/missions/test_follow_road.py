"""The road missions: to the end of the road, and what they do when something goes wrong."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from math import hypot
from pathlib import Path

import numpy as np
import pytest

from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import Point
from worlds import find_world, pose_at

END = Point(29.0, 1.6, 4.0)
NO_ROAD = "world: bare\nground: {color: grass}\nstart: {at: [0, 0]}\n"


@cache
def flown(mission: str, seed: int = 0) -> MissionFlight:
    return fly_mission(mission, noise=1.0, seed=seed)


def along(flight: MissionFlight, state: str) -> list[Point]:
    """Where it was while a state was active."""
    times = [
        t
        for t, kind, fields in flight.records
        if kind in ("enter", "exit") and fields["state"] == state
    ]
    return [place for time, place in flight.track if times[0] <= time <= times[-1]]


def away(places: list[Point], line: list[tuple[float, float]]) -> np.ndarray:
    """The distance of each place from a polyline, metres."""
    dense = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(line)])
    return np.array([np.hypot(*(dense - place[:2]).T).min() for place in places])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_the_road_is_followed_to_its_end(seed: int) -> None:
    flight = flown("follow_road", seed)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert flight.states == ["takeoff", "follow", "come_home", "land", "finish"]
    assert flight.nearest(END) < 0.4 and flight.end.norm() < 0.3
    world = find_world("narrow_road")
    line = [*world.roads[0].points, *world.roads[1].points]
    far = away(along(flight, "follow"), line)
    assert far.max() < 0.4  # half a width
    assert float(np.sqrt((far**2).mean())) < 0.08
    assert flight.output["progress"] == pytest.approx(54, abs=2)


@pytest.mark.slow
def test_without_a_road_it_comes_home(tmp_path: Path) -> None:
    world = tmp_path / "bare.yaml"
    world.write_text(NO_ROAD)
    flight = fly_mission("follow_road", world=str(world))
    assert flight.outcome == "cut_short" and flight.output["ending"] == "lost"
    assert flight.states[-3:] == ["come_home", "land", "cut_short"]
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_a_low_battery_and_the_time_bring_it_home() -> None:
    low = fly_mission("follow_road", post={12.0: "battery.low"})
    late = fly_mission("follow_road", {"longest": "8 s"})
    for flight, ending in ((low, "battery"), (late, "timeout")):
        assert flight.outcome == "cut_short" and flight.output["ending"] == ending
        assert 2 < flight.output["progress"] < 30
        assert flight.states[-3:] == ["come_home", "land", "cut_short"]
        assert flight.end.norm() < 0.3


@pytest.mark.slow
def test_the_row_method_flies_its_road() -> None:
    flight = flown("road_travel")
    assert flight.outcome == "done"
    assert flight.states == [
        "takeoff",
        "road.first_image",
        "road.inicio",
        "road.en_movimiento",
        "land",
        "finish",
    ]
    assert hypot(flight.end.x - 33, flight.end.y) < 1
    corners = [Point(11, 0, 4), Point(11, 12, 4), Point(25, 12, 4), Point(25, 0, 4)]
    assert all(flight.nearest(corner) < 1.5 for corner in corners)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_cars_are_told_with_their_speed(seed: int) -> None:
    flight = flown("road_watch", seed)
    assert flight.outcome == "done"
    world = find_world("road_traffic")
    cars = {thing.name: thing for thing in world.things if thing.kind == "car"}
    home = world.starts[0].at
    told = [
        (t, f["fields"])
        for t, kind, f in flight.records
        if kind == "event" and f["name"] == "car.seen"
    ]
    names = set()
    for time, car in told:
        place = Point(*car["position"]).plus(home)
        name = min(cars, key=lambda n: hypot(*np.subtract(pose_at(cars[n], time)[0], place)[:2]))
        (x, y, _), (u, v, _) = pose_at(cars[name], time - 0.5)[0], pose_at(cars[name], time)[0]
        true = hypot(u - x, v - y) / 0.5
        assert hypot(u - place.x, v - place.y) < 0.8
        assert car["speed"] == pytest.approx(true, rel=0.1, abs=0.15)
        names.add(name)
    assert names == set(cars)
    too_fast = [car["id"] for _, car in told if car["speed"] > 3]
    assert flight.output["too_fast"] == too_fast and len(flight.output["cars"]) == len(told)


@pytest.mark.slow
def test_the_watch_comes_home_when_something_goes_wrong(tmp_path: Path) -> None:
    world = tmp_path / "bare.yaml"
    world.write_text(NO_ROAD)
    lost = fly_mission("road_watch", world=str(world))
    low = fly_mission("road_watch", post={15.0: "battery.low"})
    late = fly_mission("road_watch", {"longest": "6 s"})
    for flight, ending in ((lost, "lost"), (low, "battery"), (late, "timeout")):
        assert flight.outcome == "cut_short" and flight.output["ending"] == ending
        assert flight.states[-3:] == ["come_home", "land", "cut_short"]
        assert flight.end.norm() < 0.3
