"""roundel_follower: above a roundel that is pulled over the ground."""

from __future__ import annotations

from pathlib import Path

import pytest

from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import horizontal_distance
from worlds import World, find_world
from worlds.motion import pose_at


def offsets(flight: MissionFlight, world: World, begin: float, end: float) -> list[float]:
    """How far it was from above the roundel, over the ground, metres."""
    (roundel,) = world.things
    start = world.starts[0].at
    return [
        horizontal_distance(pose_at(roundel, time)[0].minus(start), at)
        for time, at in flight.track
        if begin < time < end
    ]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_it_stays_above_and_lands_after_the_walk(seed: int) -> None:
    flight = fly_mission("roundel_follower", noise=1.0, seed=seed)
    assert (flight.outcome, flight.reason) == ("done", "")
    assert flight.states == ["takeoff", "follow.waiting", "follow.above", "land", "finish"]
    off = offsets(flight, find_world("roundel_walk"), 5, 41)
    assert max(off) < 0.1
    assert flight.end.norm() > 2, "it went along"


def pulled(folder: Path, path: str) -> World:
    file = folder / "pulled.yaml"
    file.write_text(
        "world: pulled\nstart: {at: [0, 0]}\nground: {color: grass, size: 60 m}\n"
        f"roundels: {{r: {{size: 30 cm, moves: {{{path}}}}}}}\n"
    )
    return find_world(str(file))


@pytest.mark.slow
def test_one_that_is_pulled_away_is_followed_when_it_is_seen_from_higher_up(tmp_path: Path) -> None:
    """It begins 70 cm ahead, out of view of the height at which the vehicle flies."""
    world = pulled(tmp_path, "through: [[0.7, 0], [0.85, 0], [0.85, 0.3]], speed: 3 cm/s")
    flight = fly_mission("roundel_follower", world=str(world.source), noise=1.0)
    assert flight.outcome == "done"
    assert flight.states.count("follow.above") >= 1 and flight.highest > 1.8
    assert max(offsets(flight, world, 20, 41)) < 0.1


@pytest.mark.slow
def test_one_that_is_lost_for_good_ends_it(tmp_path: Path) -> None:
    """It jumps away faster than the vehicle may fly."""
    world = pulled(tmp_path, "through: [[0, 0], [90, 0]], speed: 6 m/s")
    flight = fly_mission("roundel_follower", world=str(world.source))
    assert flight.outcome == "lost"
    assert flight.states[-2:] == ["land", "lost"] and flight.time < 25
    assert flight.end.z == pytest.approx(0, abs=0.02)


@pytest.mark.slow
def test_a_low_battery_ends_it() -> None:
    flight = fly_mission("roundel_follower", post={8.0: "battery.low"})
    assert flight.states[-3:] == ["follow.above", "land", "finish"] and flight.time < 14
    assert flight.end.z == pytest.approx(0, abs=0.02)


@pytest.mark.slow
def test_the_end_of_the_walk_is_a_parameter() -> None:
    flight = fly_mission("roundel_follower", {"walk": "6 s", "turn": "true"}, noise=1.0)
    assert flight.outcome == "done" and flight.time < 12
