"""One contract for every backend that needs no radio."""

from __future__ import annotations

from collections.abc import Iterator
from math import nan, pi

import pytest

from hal.fake import FakeSession
from hal.sim import open_session
from hal.vehicle import (
    PERIOD,
    Hold,
    Limits,
    Options,
    Order,
    Position,
    Session,
    Unavailable,
    Vehicle,
    Velocity,
    VisionPose,
)
from tests.hal.flying import finish, only, take_off, wait, wait_until
from vencejo.errors import UserError
from vencejo.geometry import Point, distance, wrap

ORIGIN = Point(0.0, 0.0, 0.0)


@pytest.fixture(params=["fake", "sim"])
def session(request: pytest.FixtureRequest) -> Iterator[Session]:
    opened = FakeSession() if request.param == "fake" else open_session(Options())
    with opened as session:
        yield session


def verb(vehicle: Vehicle, name: str) -> Order:
    return vehicle.takeoff(2.0) if name == "takeoff" else getattr(vehicle, name)()


def near(place: Point, x: float, y: float, z: float, tolerance: float = 0.05) -> bool:
    return distance(place, (x, y, z)) < tolerance


# What is reported.


def test_starts_landed_and_disarmed_at_home(session: Session) -> None:
    seen = only(session).observe()
    assert (seen.mode, seen.armed, seen.flying, seen.health) == ("landed", False, False, ())
    assert (seen.time, seen.battery, seen.link_age) == (0.0, 1.0, 0.0)
    assert seen.position == seen.home == ORIGIN


def test_stays_where_it_stands(session: Session) -> None:
    seen = wait(session, 5)[-1]
    assert abs(seen.position.z) < 0.002
    assert near(seen.position, 0, 0, 0, 0.002)
    assert not seen.flying and seen.velocity.norm() < 0.01


def test_time_counts_periods_without_drift(session: Session) -> None:
    times = [seen.time for seen in wait(session, 10)]
    assert times == [count / 40 for count in range(1, 401)]


def test_an_observation_never_changes(session: Session) -> None:
    vehicle = take_off(session)
    seen = vehicle.observe()
    copy = seen._replace()
    vehicle.command(Velocity(x=2.0))
    wait(session, 1)
    assert seen == copy != vehicle.observe()
    with pytest.raises(AttributeError):
        seen.time = 3.0  # type: ignore[misc]


def test_satisfies_the_protocol(session: Session) -> None:
    vehicle = only(session)
    assert isinstance(vehicle, Vehicle)
    assert session.vehicles[vehicle.name] is vehicle
    assert {"position", "velocity", "yaw", "takeoff", "land"} <= vehicle.capabilities
    assert session.engine


def test_what_is_not_there_is_said_to_be_unavailable(session: Session) -> None:
    vehicle = only(session)
    with pytest.raises(Unavailable, match="camera 'rear'"):
        vehicle.camera("rear")
    with pytest.raises(Unavailable, match="sensor 'sonar'"):
        vehicle.sensor("sonar")
    with pytest.raises(Unavailable, match="vision"):
        vehicle.send_vision_pose(VisionPose(ORIGIN, (0, 0, 0, 1), [0.0] * 21, 0.0))


# Verbs.


def test_arm_and_disarm_on_the_ground(session: Session) -> None:
    vehicle = only(session)
    for _ in range(2):
        assert vehicle.arm().state == "done"
        assert vehicle.observe().armed
    wait(session, 1)
    assert vehicle.observe().mode == "landed" and near(vehicle.observe().position, 0, 0, 0)
    for _ in range(2):
        assert vehicle.disarm().state == "done"
        assert not vehicle.observe().armed


def test_takeoff_arms_rises_and_holds(session: Session) -> None:
    vehicle = only(session)
    order = vehicle.takeoff(2.5)
    assert (order.verb, order.state) == ("takeoff", "accepted")
    assert vehicle.observe().mode == "taking-off" and vehicle.observe().armed
    assert vehicle.observe().time == 0.0
    session.wait()
    assert vehicle.takeoff(2.5) is order
    finish(session, order, 6)
    assert vehicle.observe().mode == "flying" and vehicle.observe().flying
    assert abs(vehicle.observe().position.z - 2.5) < 0.06
    assert all(near(seen.position, 0, 0, 2.5, 0.06) for seen in wait(session, 3))
    assert vehicle.takeoff(9.0).state == "done"
    assert near(wait(session, 2)[-1].position, 0, 0, 2.5)


def test_land_ends_on_the_ground_with_the_motors_off(session: Session) -> None:
    vehicle = take_off(session)
    order = vehicle.land()
    assert order.state == "accepted" and vehicle.observe().mode == "landing"
    session.wait()
    assert vehicle.land() is order
    finish(session, order, 15)
    seen = vehicle.observe()
    assert (seen.mode, seen.armed, seen.flying) == ("landed", False, False)
    assert near(seen.position, 0, 0, 0)
    assert vehicle.land().state == "done"
    finish(session, vehicle.takeoff(1), 5)


@pytest.mark.parametrize("height", [0.4, 3, 30])
def test_lands_from_any_height(session: Session, height: float) -> None:
    vehicle = take_off(session, height)
    finish(session, vehicle.land(), 8 + height)
    assert abs(vehicle.observe().position.z) < 0.002


def test_lands_out_of_full_speed_without_harm(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Velocity(x=5.0, y=-2.0))
    wait(session, 3)
    finish(session, vehicle.land(), 15)
    assert vehicle.observe().health == ()


def test_a_landing_on_the_ground_disarms(session: Session) -> None:
    vehicle = only(session)
    vehicle.arm()
    assert vehicle.land().state == "done"
    assert not vehicle.observe().armed


def test_takeoff_ends_a_landing(session: Session) -> None:
    vehicle = take_off(session, 4)
    landing = vehicle.land()
    wait(session, 0.8)
    assert vehicle.observe().flying
    order = vehicle.takeoff(3.5)
    assert (landing.state, landing.reason) == ("refused", "ended by: takeoff")
    finish(session, order, 6)
    assert near(wait(session, 2)[-1].position, 0, 0, 3.5)


def test_takes_off_again_after_flying_into_the_ground(session: Session) -> None:
    vehicle = take_off(session, 1)
    vehicle.command(Velocity(z=-1.0))
    seen = wait(session, 3)[-1]
    assert (seen.mode, seen.flying) == ("flying", False)
    finish(session, vehicle.takeoff(2.0), 6)
    assert near(wait(session, 1)[-1].position, 0, 0, 2)


def test_returns_home_and_lands(session: Session) -> None:
    vehicle = take_off(session, 2)
    vehicle.command(Position(Point(8.0, -6.0, 2.0)))
    wait(session, 8)
    order = vehicle.return_home()
    assert vehicle.return_home() is order and vehicle.observe().mode == "returning"
    highest = 0.0
    for _ in range(1600):
        session.wait()
        highest = max(highest, vehicle.observe().position.z)
        if order.ended:
            break
    assert order.state == "done"
    assert 4.9 < highest < 5.2
    seen = vehicle.observe()
    assert (seen.mode, seen.armed) == ("landed", False) and near(seen.position, 0, 0, 0, 0.1)
    assert vehicle.return_home().state == "done"


def test_return_home_is_refused_on_the_ground_elsewhere(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Position(Point(3.0, 0.0, 3.0)))
    wait(session, 4)
    finish(session, vehicle.land(), 10)
    assert vehicle.return_home().state == "refused"


def test_disarm_is_refused_in_the_air(session: Session) -> None:
    vehicle = take_off(session)
    order = vehicle.disarm()
    assert (order.state, order.reason) == ("refused", "the vehicle is in the air")
    assert near(wait(session, 1)[-1].position, 0, 0, 3)


def test_emergency_stop_lets_it_fall(session: Session) -> None:
    vehicle = take_off(session, 6)
    order = vehicle.emergency_stop()
    assert order.state == "done" and vehicle.emergency_stop().state == "done"
    assert vehicle.observe().mode == "stopped" and not vehicle.observe().armed
    assert vehicle.takeoff(2).state == "refused"
    assert vehicle.land().state == "refused"
    wait_until(session, lambda: vehicle.observe().mode == "landed", 5)
    assert not vehicle.observe().flying


def test_emergency_stop_ends_what_is_under_way(session: Session) -> None:
    vehicle = only(session)
    order = vehicle.takeoff(3)
    wait(session, 1)
    vehicle.emergency_stop()
    assert (order.state, order.reason) == ("refused", "the motors were stopped")


@pytest.mark.parametrize("name", ["disarm", "land", "return_home", "emergency_stop"])
def test_what_is_so_already_is_done_at_once(session: Session, name: str) -> None:
    for _ in range(2):
        assert verb(only(session), name).state == "done"


@pytest.mark.parametrize("altitude", [0.0, -1.0, nan])
def test_an_altitude_that_is_none_is_refused(session: Session, altitude: float) -> None:
    assert only(session).takeoff(altitude).state == "refused"
    assert not only(session).observe().armed


@pytest.mark.parametrize("name", ["arm", "takeoff", "land", "return_home", "emergency_stop"])
def test_no_verb_takes_time(session: Session, name: str) -> None:
    vehicle = take_off(session)
    before = vehicle.observe()
    verb(vehicle, name)
    after = vehicle.observe()
    assert (after.time, after.position) == (before.time, before.position)


# Commands.


def test_a_command_is_ignored_on_the_ground(session: Session) -> None:
    vehicle = only(session)
    for prepare in (vehicle.disarm, vehicle.arm):
        prepare()
        vehicle.command(Velocity(z=2.0))
        seen = wait(session, 1)[-1]
        assert near(seen.position, 0, 0, 0) and seen.mode == "landed"
    order = vehicle.takeoff(2)
    vehicle.command(Velocity(x=1.0))
    finish(session, order, 5)
    assert near(vehicle.observe().position, 0, 0, 2, 0.1)


@pytest.mark.parametrize("name", ["takeoff", "land", "return_home"])
def test_a_command_ends_what_is_under_way(session: Session, name: str) -> None:
    vehicle = only(session) if name == "takeoff" else take_off(session, 4)
    order = verb(vehicle, name)
    wait(session, 0.6)
    vehicle.command(Hold())
    assert (order.state, order.reason) == ("refused", "ended by a command")
    assert vehicle.observe().mode == "flying"
    wait(session, 2)
    height = vehicle.observe().position.z
    assert vehicle.observe().flying and abs(wait(session, 1)[-1].position.z - height) < 0.02


def test_a_velocity_is_in_the_world_frame(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Position(Point(0.0, 0.0, 3.0), yaw=2.0))
    wait(session, 3)
    vehicle.command(Velocity(x=1.0, y=-0.5, z=0.25))
    seen = wait(session, 3)[-1]
    assert distance(seen.velocity, (1.0, -0.5, 0.25)) < 0.02
    assert abs(seen.yaw - 2.0) < 0.02


def test_forward_with_a_heading_of_90_degrees_is_north(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Position(Point(0.0, 0.0, 3.0), yaw=pi / 2))
    wait(session, 3)
    vehicle.command(Velocity(x=1.0, frame="heading"))
    seen = wait(session, 3)[-1]
    assert distance(seen.velocity, (0.0, 1.0, 0.0)) < 0.03
    vehicle.command(Velocity(y=1.0, frame="heading"))
    assert distance(wait(session, 3)[-1].velocity, (-1.0, 0.0, 0.0)) < 0.03


def test_the_heading_frame_turns_with_the_vehicle(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Velocity(x=1.0, frame="heading", yaw_rate=0.5))
    seen = wait(session, 4)[-1]
    speed = seen.velocity
    assert abs(speed.norm() - 1) < 0.1
    assert 1.5 < seen.yaw < 2.1
    assert speed.y > 0.7
    assert abs(seen.rates.z - 0.5) < 0.05


def test_a_velocity_lasts_until_the_next_command(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Velocity(x=1.0))
    assert wait(session, 6)[-1].position.x > 5
    vehicle.command(Hold())
    there = wait(session, 2)[-1].position
    assert distance(wait(session, 3)[-1].position, there) < 0.02


def test_hold_again_and_again_is_one_hold(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Velocity(x=2.0))
    wait(session, 2)
    for _ in range(80):
        vehicle.command(Hold())
        session.wait()
    there = vehicle.observe().position
    for _ in range(80):
        vehicle.command(Hold())
        session.wait()
    assert distance(vehicle.observe().position, there) < 0.01


def test_a_position_is_reached_and_held(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Position(Point(3.0, -2.0, 4.0)))
    assert near(wait(session, 6)[-1].position, 3, -2, 4, 0.01)
    assert near(wait(session, 3)[-1].position, 3, -2, 4, 0.01)


def test_a_heading_is_turned_to_the_short_way(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Position(Point(0.0, 0.0, 3.0), yaw=3.0))
    wait(session, 4)
    vehicle.command(Position(Point(0.0, 0.0, 3.0), yaw=-3.0))
    seen = wait(session, 3)
    assert abs(wrap(seen[-1].yaw + 3.0)) < 0.02
    assert all(abs(each.yaw) > 2.9 for each in seen)
    assert all(-pi < each.yaw <= pi for each in seen)


def test_a_position_can_turn_at_a_rate(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Position(Point(0.0, 0.0, 3.0), yaw_rate=-0.5))
    seen = wait(session, 2)[-1]
    assert -1.2 < seen.yaw < -0.8 and near(seen.position, 0, 0, 3)
    vehicle.command(Position(Point(0.0, 0.0, 3.0)))
    yaw = wait(session, 1)[-1].yaw
    assert abs(wait(session, 1)[-1].yaw - yaw) < 0.01


# Limits.


def test_limits_change_in_flight_one_by_one(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.configure(Limits(max_speed=1.0))
    vehicle.configure(Limits(max_climb=0.5, max_yaw_rate=0.3))
    vehicle.command(Velocity(x=3.0, y=4.0, z=3.0, yaw_rate=2.0))
    seen = wait(session, 3)[-1]
    assert distance(seen.velocity, (0.6, 0.8, 0.5)) < 0.05
    assert abs(seen.rates.z - 0.3) < 0.02


def test_no_flight_above_the_largest_altitude(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.configure(Limits(max_altitude=4.0))
    vehicle.command(Velocity(z=2.0))
    assert max(seen.position.z for seen in wait(session, 4)) < 4.05
    vehicle.command(Position(Point(0.0, 0.0, 9.0)))
    assert abs(wait(session, 3)[-1].position.z - 4) < 0.05
    vehicle.land()
    finish(session, vehicle.land(), 10)
    assert vehicle.takeoff(5.0).state == "refused"


@pytest.mark.parametrize("value", [0.0, -1.0, nan])
def test_a_limit_that_is_none_is_refused(session: Session, value: float) -> None:
    with pytest.raises(UserError, match="max_speed") as caught:
        only(session).configure(Limits(max_speed=value))
    assert caught.value.code == "bad-limit"


def test_the_period_is_a_fortieth_of_a_second() -> None:
    assert PERIOD == 1 / 40
