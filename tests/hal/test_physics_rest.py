"""What stands still stays where it is, in every engine, until something moves it."""

from __future__ import annotations

from math import degrees, dist, radians, tan

import pytest

from hal.sim import open_session
from hal.vehicle import Options
from tests.hal.engines import ENGINES, WEIGHT, box, run, simulation, vehicle
from tests.hal.flying import finish, only, take_off, wait
from vencejo.geometry import Point, Quaternion, yaw_quaternion
from worlds.motion import pose_at
from worlds.terrain import height_at
from worlds.things import UPRIGHT, Motion, Terrain

HOUR = 3600.0


def turn_between(one: Quaternion, other: Quaternion) -> float:
    """The small angle between two attitudes, radians; q and −q are the same one."""
    return 2 * min(dist(one, other), dist(one, [-part for part in other]))


def slope(angle: float) -> Terrain:
    rise = 5 * tan(radians(angle))
    return Terrain(
        tuple(tuple(rise * min(i, 8 - i) * (0 < j < 8) for j in range(9)) for i in range(9)), 40.0
    )


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("heading", [0.0, 0.7])
@pytest.mark.parametrize("angle", [0.0, 5.0, 17.0, 30.0])
def test_what_stands_does_not_creep(engine: str, angle: float, heading: float) -> None:
    terrain = slope(angle)
    with simulation(engine, terrain=terrain) as physics:
        at = (0.3, -8.2, height_at(terrain, 0.3, -8.2) + 0.06 + 0.4 * tan(radians(angle)))
        body = vehicle(physics, at, yaw_quaternion(heading))
        run(physics, 2)
        stood = body.state()
        run(physics, 60)
        assert dist(body.state()[0], stood[0]) < 0.1e-3
        assert degrees(turn_between(body.state()[1], stood[1])) < 0.01


@pytest.mark.parametrize("engine", ENGINES)
def test_what_stands_on_level_ground_for_an_hour_does_not_creep(engine: str) -> None:
    with simulation(engine) as physics:
        body = vehicle(physics, (0, 0, 0.06))
        run(physics, HOUR)
        assert dist(body.state()[0], (0, 0, 0.06)) < 0.1e-3
        assert degrees(turn_between(body.state()[1], UPRIGHT)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_what_stands_on_a_slope_for_an_hour_does_not_creep(engine: str) -> None:
    terrain = slope(30.0)
    with simulation(engine, terrain=terrain) as physics:
        body = vehicle(physics, (0.3, -8.2, height_at(terrain, 0.3, -8.2) + 0.25))
        run(physics, 2)
        stood = body.state()
        run(physics, HOUR)
        assert dist(body.state()[0], stood[0]) < 0.1e-3
        assert degrees(turn_between(body.state()[1], stood[1])) < 0.01


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("speed", [0.001, 0.01, 0.2, 1.0])
@pytest.mark.parametrize("climb", [0.0, 1.0])
def test_what_stands_on_a_mover_goes_with_it(engine: str, speed: float, climb: float) -> None:
    way = 40 / dist((1, climb), (0, 0))
    motion = Motion((Point(0, 0, 1), Point(way, 0, 1 + climb * way)), speed, False, False)
    pad = box("pad", Point(0, 0, 1), Point(2, 2, 0.2), motion=motion)
    with simulation(engine, pad) as physics:
        body = vehicle(physics, (0, 0, 1.26))
        run(physics, 3)
        offset = Point(*body.state()[0]).minus(pose_at(pad, 3.0)[0])
        run(physics, 20)
        later = Point(*body.state()[0]).minus(pose_at(pad, 23.0)[0])
        assert dist(later, offset) < 0.002
        assert all(dist(body.state()[2], each.velocity) < 1e-3 for each in body.contacts())
        assert body.contacts()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_push_moves_what_has_stood_for_long(engine: str) -> None:
    with simulation(engine) as physics:
        body = vehicle(physics, (0, 0, 0.06))
        run(physics, 10)
        for _ in range(120):
            body.push((0.0, 0.0, 1.5 * WEIGHT), (0, 0, 0))
            physics.step()
        (_, _, z), _, (_, _, speed), _ = body.state()
        assert speed == pytest.approx(0.5 * 9.80665 * 0.5, rel=0.01)
        assert z == pytest.approx(0.06 + speed * 0.25, abs=0.02)
        # Even where it hangs still in the air it does not stay there without a push.
        for _ in range(240 * 4):
            body.push((0.0, 0.0, WEIGHT - 0.436 * 20 * body.state()[2][2]), (0, 0, 0))
            physics.step()
        high = body.state()[0][2]
        run(physics, 0.25)
        assert body.state()[0][2] < high - 0.2


@pytest.mark.parametrize("engine", ENGINES)
def test_a_mover_pushes_what_has_stood_for_long(engine: str) -> None:
    motion = Motion((Point(-6, 0, 0), Point(6, 0, 0)), 1.0, False, False)
    cart = box("cart", Point(-6, 0, 0), Point(1, 1, 0.5), motion=motion)
    with simulation(engine, cart) as physics:
        body = vehicle(physics, (0, 0, 0.06))
        stood = body.state()[0]
        run(physics, 5)
        assert dist(body.state()[0], stood) < 0.1e-3
        run(physics, 3)
        assert body.state()[0][0] > 2.5


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_that_comes_down_on_another_rests_on_it(engine: str) -> None:
    with simulation(engine) as physics:
        below = vehicle(physics, (0, 0, 0.06), name="below")
        run(physics, 5)
        above = vehicle(physics, (0.1, 0, 0.6), yaw_quaternion(0.3), "above")
        run(physics, 5)
        assert above.state()[0][2] == pytest.approx(0.18, abs=0.002)
        for _ in range(240):
            below.push((0.0, 0.0, 3 * WEIGHT), (0, 0, 0))
            physics.step()
        assert dist(below.state()[0], (0, 0, 0.06)) > 0.1
        assert dist(above.state()[0], (0.1, 0, 0.18)) > 0.1


@pytest.mark.parametrize("engine", ENGINES)
def test_what_loses_its_support_falls(engine: str) -> None:
    """It stands on a pad that moves so slowly that it seems to stand still."""
    motion = Motion((Point(0, 0, 1), Point(0, 0, 0)), 0.0005, False, False)
    pad = box("pad", Point(0, 0, 1), Point(2, 2, 0.2), motion=motion)
    with simulation(engine, pad) as physics:
        body = vehicle(physics, (0, 0, 1.26))
        run(physics, 60)
        assert body.state()[0][2] == pytest.approx(1.26 - 0.03, abs=0.0005)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("speed", [0.5, 2.0, 5.0])
def test_what_slides_stays_on_the_ground_and_is_slowed_by_friction(
    engine: str, speed: float
) -> None:
    with simulation(engine) as physics:
        body, highest = vehicle(physics, (0, 0, 0.06)), 0.0
        body.withdraw()
        body.place(((0, 0, 0.06), UPRIGHT, (speed, 0, 0), (0, 0, 0)))
        for _ in range(240 * 2):
            physics.step()
            highest = max(highest, body.state()[0][2])
        assert highest < 0.061
        assert body.state()[0][0] == pytest.approx(speed**2 / (2 * 0.64 * 9.80665), rel=0.06)
        assert body.state()[2] == pytest.approx((0, 0, 0), abs=1e-3)


# Flights.


def test_a_vehicle_with_its_motors_off_stays_where_it_landed() -> None:
    with open_session(Options()) as session:
        drone = take_off(session, 1.0)
        finish(session, drone.land(), 10)
        wait(session, 1)
        landed = drone.observe()
        seen = wait(session, 60)
        assert {each.position for each in seen} == {landed.position}
        assert {each.attitude for each in seen} == {landed.attitude}
        take_off(session, 1.0)
        assert drone.observe().position.z == pytest.approx(1.0, abs=0.05)


def test_a_vehicle_hovers_for_as_long_as_it_likes_after_it_has_stood() -> None:
    with open_session(Options()) as session:
        wait(session, 5)
        take_off(session, 1.0)
        assert {round(each.position.z, 2) for each in wait(session, 10)} == {1.0}


def test_a_vehicle_that_was_stopped_in_the_air_comes_to_rest() -> None:
    with open_session(Options()) as session:
        drone = take_off(session, 1.0)
        drone.emergency_stop()
        wait(session, 3)
        seen = wait(session, 5)
        assert only(session).observe().mode == "landed"
        assert {each.position for each in seen} == {seen[0].position}
