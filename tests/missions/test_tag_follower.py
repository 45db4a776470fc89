"""tag_follower and tag_follower_braking: before a marker that somebody carries."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import pytest

from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import Point
from worlds import find_world
from worlds.motion import pose_at

BEFORE = Point(-1.7, 0.0, -0.02)
"""The vehicle's place before the marker: its camera is 20 cm ahead of it, 2 cm up, metres."""


def rms(flight: MissionFlight, world: str = "tag_walk") -> float:
    """How far it was from its place before the marker, from 10 to 50 s, metres."""
    (marker,) = (thing for thing in find_world(world).things if thing.kind == "marker")
    off = [
        pose_at(marker, time)[0].plus(BEFORE).minus(at).norm()
        for time, at in flight.track
        if 10 < time < 50
    ]
    return sqrt(sum(each * each for each in off) / len(off))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mission", "seed", "error"),
    [
        ("tag_follower", 1, 0.12),
        ("tag_follower", 2, 0.12),
        ("tag_follower_braking", 1, 0.5),
    ],
)
def test_it_stays_before_the_marker_and_comes_home(mission: str, seed: int, error: float) -> None:
    flight = fly_mission(mission, noise=1.0, seed=seed)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert rms(flight) < error
    assert flight.states[-3:] == ["come_home", "land", "finish"]
    assert flight.end.norm() < 0.2


@pytest.mark.slow
@pytest.mark.parametrize("mission", ["tag_follower", "tag_follower_braking"])
def test_a_marker_that_is_taken_away_is_waited_for_and_then_given_up(
    mission: str, tmp_path: Path
) -> None:
    """It is carried up out of sight."""
    world = tmp_path / "away.yaml"
    world.write_text(
        "world: away\nstart: {at: [0, 0]}\nmarkers: {held: {id: 3, size: 25 cm, faces: 180 deg,"
        " moves: {through: [[2, 0, 1.4], [2, 0, 60]], speed: 1.5 m/s, turns: false}}}\n"
    )
    flight = fly_mission(mission, world=str(world))
    assert flight.outcome == "lost"
    assert flight.states[-4:] == ["work.waiting", "come_home", "land", "lost"]
    assert flight.highest < 3.5
    assert flight.end.norm() < 0.2 and flight.time < 30


@pytest.mark.slow
@pytest.mark.parametrize("mission", ["tag_follower", "tag_follower_braking"])
def test_a_low_battery_and_the_end_of_the_walk_bring_it_home(mission: str) -> None:
    low = fly_mission(mission, post={8.0: "battery.low"})
    assert low.states[-3:] == ["come_home", "land", "finish"] and low.time < 20
    short = fly_mission(mission, {"walk": "6 s"})
    assert short.states[-3:] == ["come_home", "land", "finish"] and short.time < 20
    assert low.end.norm() < 0.2 and short.end.norm() < 0.2
