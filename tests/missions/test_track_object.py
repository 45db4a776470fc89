"""track_object: stay before a red ball, come home and land."""

from __future__ import annotations

from pathlib import Path

import pytest

from runner.testing import fly_mission
from vencejo.geometry import distance
from worlds import find_world
from worlds.motion import pose_at

WORLD = find_world("moving_ball")
BALL = next(thing for thing in WORLD.things if thing.name == "ball")
BARE = "world: bare\nstart: {at: [0, 0]}\n"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_it_stays_before_the_ball(seed: int) -> None:
    flight = fly_mission("track_object", seed=seed, noise=1.0)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert flight.states == ["takeoff", "follow", "come_home", "come_down", "end", "finish"]
    followed = [(time, place) for time, place in flight.track if 10.0 < time < 41.0]
    errors = []
    for time, place in followed:
        x, y, z = pose_at(BALL, time)[0]
        # The middle of the ball is its radius above where it is placed.
        errors.append(distance(place, (x, y, z + 0.2)) - 3.0)
    rms = (sum(error**2 for error in errors) / len(errors)) ** 0.5
    assert rms < 0.15 and max(map(abs, errors)) < 0.6
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_without_a_ball_it_comes_home(tmp_path: Path) -> None:
    world = tmp_path / "bare.yaml"
    world.write_text(BARE)
    flight = fly_mission("track_object", world=str(world))
    assert flight.outcome == "lost"
    assert flight.states == ["takeoff", "follow", "come_home", "come_down", "end", "missed"]
    assert flight.end.norm() < 0.2


@pytest.mark.slow
def test_a_low_battery_lands_it_at_once() -> None:
    flight = fly_mission("track_object", post={12.0: "battery.low"})
    assert flight.states == ["takeoff", "follow", "come_down", "end", "finish"]
    assert flight.time < 20.0 and flight.end.norm() > 1.0


@pytest.mark.slow
def test_after_its_time_it_comes_home() -> None:
    flight = fly_mission("track_object", {"follows": "8 s"})
    assert flight.outcome == "done"
    assert flight.states == ["takeoff", "follow", "come_home", "come_down", "end", "finish"]
    assert flight.end.norm() < 0.2 and flight.time < 20.0
