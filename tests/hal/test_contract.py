"""One contract for every backend that needs no radio, the example of docs/backends.md included.

What a backend's vehicle does not have among its capabilities is not asked of it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from math import inf, nan, pi
from pathlib import Path
from typing import Any

import pytest

from hal import Lights, Limits, Order
from hal.fake import FakeSession, FakeVehicle
from hal.orders import ANSWER_WITHIN, DONE_WITHIN
from hal.sim import open_session
from hal.vehicle import (
    ACCEPTED,
    PERIOD,
    VALIDITY,
    Attitude,
    Hold,
    Options,
    Position,
    Session,
    Setpoint,
    Unavailable,
    Vehicle,
    Velocity,
    VisionPose,
)
from tests.hal.engines import ENGINES
from tests.hal.flying import decided, finish, named, only, take_off, wait, wait_until
from vencejo.errors import UserError
from vencejo.geometry import Point, distance, wrap

ORIGIN = Point(0.0, 0.0, 0.0)
GUIDE = Path(__file__).parents[2] / "docs" / "backends.md"
VERBS = ["arm", "disarm", "takeoff", "land", "return_home", "emergency_stop", "reset", "trim"]


def example_session(options: Options) -> Session:
    """The backend that docs/backends.md shows."""
    found = re.search(r"^```python\n# file: \S+\n(.*?)^```", GUIDE.read_text("utf-8"), re.M | re.S)
    assert found is not None
    written: dict[str, Any] = {"__name__": "example"}
    exec(compile(found[1], str(GUIDE), "exec"), written)
    opened: Session = written["open_session"](options)
    return opened


def open_with(engine: str, options: Options) -> Session:
    """The simulator with an engine."""
    return open_session(replace(options, settings={"engine": engine, **options.settings}))


OPENERS: dict[str, Callable[[Options], Session]] = {
    "fake": lambda options: FakeSession((each.name for each in options.vehicles), options=options),
    **{f"sim on {engine}": partial(open_with, engine) for engine in ENGINES},
    "example": example_session,
}


@pytest.fixture(params=OPENERS)
def backend(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def fresh(backend: str) -> Iterator[Session]:
    """A session that has not waited yet."""
    with OPENERS[backend](Options()) as session:
        yield session


@pytest.fixture
def session(fresh: Session) -> Session:
    fresh.wait()
    return fresh


def needs(session: Session, *capabilities: str) -> Vehicle:
    """The vehicle, which must have these capabilities for the test to mean anything."""
    vehicle = only(session)
    for capability in capabilities:
        if capability not in vehicle.capabilities:
            pytest.skip(f"this vehicle has no capability '{capability}'")
    return vehicle


def verb(vehicle: Vehicle, name: str) -> Order:
    return vehicle.takeoff(2.0) if name == "takeoff" else getattr(vehicle, name)()


def near(place: Point, x: float, y: float, z: float, tolerance: float = 0.05) -> bool:
    return distance(place, (x, y, z)) < tolerance


# Time, and the start.


def test_nothing_is_known_before_the_first_wait(fresh: Session) -> None:
    with pytest.raises(RuntimeError, match="before the first wait"):
        only(fresh).observe()
    assert fresh.wait() == PERIOD
    assert only(fresh).observe().time == PERIOD


def test_a_wait_returns_the_step_that_it_made(session: Session) -> None:
    before = only(session).observe().time
    step = session.wait()
    assert step == PERIOD
    assert only(session).observe().time - before == pytest.approx(step)


def test_time_counts_periods_without_drift(session: Session) -> None:
    times = [seen.time for seen in wait(session, 10)]
    assert times == [count / 40 for count in range(2, 402)]


def test_all_vehicles_have_one_clock(backend: str) -> None:
    with OPENERS[backend](Options(vehicles=named("a", "b", "c"))) as session:
        assert list(session.vehicles) == ["a", "b", "c"]
        for _ in range(40):
            session.wait()
            times = {vehicle.observe().time for vehicle in session.vehicles.values()}
            assert len(times) == 1
        homes = [vehicle.observe().home for vehicle in session.vehicles.values()]
        assert min(distance(homes[0], homes[1]), distance(homes[1], homes[2])) > 0.5


def test_the_period_is_a_fortieth_of_a_second() -> None:
    assert PERIOD == 1 / 40


# What is reported.


def test_starts_landed_and_disarmed_at_home(session: Session) -> None:
    seen = only(session).observe()
    assert (seen.mode, seen.armed, seen.flying, seen.health) == ("landed", False, False, ())
    assert (seen.link_age, seen.link, seen.authority) == (0.0, "alive", "mission")
    assert (seen.epoch, seen.origin_shift, seen.events) == (0, ORIGIN, ())
    assert seen.battery == pytest.approx(1.0, abs=1e-4)
    assert seen.home == ORIGIN and near(seen.position, 0, 0, 0, 0.002)


def test_stays_where_it_stands(session: Session) -> None:
    seen = wait(session, 5)[-1]
    assert abs(seen.position.z) < 0.002
    assert near(seen.position, 0, 0, 0, 0.002)
    assert not seen.flying and seen.velocity.norm() < 0.01


def test_an_observation_never_changes(session: Session) -> None:
    vehicle = take_off(session)
    seen = vehicle.observe()
    copy = seen._replace()
    wait(session, 1, Velocity(x=2.0))
    assert seen == copy != vehicle.observe()
    with pytest.raises(AttributeError):
        seen.time = 3.0  # type: ignore[misc]


def test_velocity_and_rates_are_how_place_and_heading_change(session: Session) -> None:
    standing = wait(session, 1)[-1]
    assert standing.rates.norm() < 0.01 and standing.velocity.norm() < 0.01
    take_off(session)
    hovering = wait(session, 2, Hold())[-1]
    assert hovering.rates.norm() < 0.02 and hovering.velocity.norm() < 0.02
    before, *_, after = wait(session, 3, Velocity(x=1.0, y=-0.5, z=0.25, yaw_rate=0.5))[-41:]
    assert after.time - before.time == pytest.approx(1.0)
    assert distance(after.position.minus(before.position), after.velocity) < 0.02
    assert wrap(after.yaw - before.yaw) == pytest.approx(after.rates.z, abs=0.02)
    assert after.rates.z == pytest.approx(0.5, abs=0.02)
    stopped = wait(session, 3, Hold())[-1]
    assert stopped.rates.norm() < 0.02 and stopped.velocity.norm() < 0.02


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


@pytest.mark.parametrize("name", VERBS)
def test_a_verb_it_does_not_have_is_unavailable(session: Session, name: str) -> None:
    vehicle = only(session)
    if name in vehicle.capabilities:
        assert verb(vehicle, name).verb == name
    else:
        with pytest.raises(Unavailable, match=name.split("_", maxsplit=1)[0]):
            verb(vehicle, name)


# Orders.


@pytest.mark.parametrize("name", VERBS)
def test_an_order_changes_only_inside_wait(session: Session, name: str) -> None:
    vehicle = needs(session, name)
    before = vehicle.observe()
    order = verb(vehicle, name)
    assert (order.verb, order.state, order.reason, order.ended) == (name, "sent", "", False)
    assert vehicle.observe() == before
    session.wait()
    assert order.state != "sent"


@pytest.mark.parametrize("name", ["takeoff", "land"])
def test_the_same_verb_again_is_the_same_order(session: Session, name: str) -> None:
    vehicle = only(session) if name == "takeoff" else take_off(session)
    order = verb(vehicle, name)
    assert verb(vehicle, name) is order
    session.wait()
    assert order.state == "accepted" and verb(vehicle, name) is order


@pytest.mark.parametrize("name", ["disarm", "land", "return_home", "emergency_stop"])
def test_what_is_so_already_is_done_in_the_next_wait(session: Session, name: str) -> None:
    needs(session, name)
    for _ in range(2):
        assert decided(session, verb(only(session), name)).state == "done"


def test_every_verb_has_a_time_in_which_it_must_be_done() -> None:
    assert set(DONE_WITHIN) == {*VERBS, "lights", "swap_battery"}
    assert all(seconds >= ANSWER_WITHIN for seconds in DONE_WITHIN.values())


def test_arm_and_disarm_on_the_ground(session: Session) -> None:
    vehicle = needs(session, "arm", "disarm")
    for _ in range(2):
        assert decided(session, vehicle.arm()).state == "done"
        assert vehicle.observe().armed
    wait(session, 1)
    assert vehicle.observe().mode == "landed" and near(vehicle.observe().position, 0, 0, 0)
    for _ in range(2):
        assert decided(session, vehicle.disarm()).state == "done"
        assert not vehicle.observe().armed


def test_takeoff_arms_rises_and_holds(session: Session) -> None:
    vehicle = only(session)
    order = decided(session, vehicle.takeoff(2.5))
    assert (order.verb, order.state) == ("takeoff", "accepted")
    assert vehicle.observe().mode == "taking-off" and vehicle.observe().armed
    finish(session, order, 6)
    assert vehicle.observe().mode == "flying" and vehicle.observe().flying
    assert abs(vehicle.observe().position.z - 2.5) < 0.06
    assert all(near(seen.position, 0, 0, 2.5, 0.06) for seen in wait(session, 3))
    assert decided(session, vehicle.takeoff(9.0)).state == "done"
    assert near(wait(session, 2)[-1].position, 0, 0, 2.5)


def test_land_ends_on_the_ground_with_the_motors_off(session: Session) -> None:
    vehicle = take_off(session)
    order = decided(session, vehicle.land())
    assert order.state == "accepted" and vehicle.observe().mode == "landing"
    finish(session, order, 15)
    seen = vehicle.observe()
    assert (seen.mode, seen.armed, seen.flying) == ("landed", False, False)
    assert near(seen.position, 0, 0, 0)
    assert decided(session, vehicle.land()).state == "done"
    finish(session, vehicle.takeoff(1), 5)


@pytest.mark.parametrize("height", [0.4, 3, 30])
def test_lands_from_any_height(session: Session, height: float) -> None:
    vehicle = take_off(session, height)
    finish(session, vehicle.land(), 8 + height)
    assert abs(vehicle.observe().position.z) < 0.002


def test_lands_out_of_full_speed_without_harm(session: Session) -> None:
    vehicle = take_off(session)
    wait(session, 3, Velocity(x=5.0, y=-2.0))
    finish(session, vehicle.land(), 15)
    assert vehicle.observe().health == ()


def test_comes_down_with_a_velocity_that_may_change(session: Session) -> None:
    needs(session, "land.moving")
    vehicle = take_off(session, 6.0)
    order = vehicle.land(Point(0.5, 0.0, 0.0))
    seen = wait(session, 1.5)[-1]
    assert order.state == "accepted" and seen.mode == "landing"
    assert (seen.velocity.x, seen.velocity.y) == pytest.approx((0.5, 0.0), abs=0.05)
    assert vehicle.land(Point(0.0, -0.4, 0.0)) is order
    seen = wait(session, 0.75)[-1]
    assert (seen.velocity.x, seen.velocity.y) == pytest.approx((0.0, -0.4), abs=0.05)
    assert vehicle.land() is order
    finish(session, order, 15)
    landed = vehicle.observe().position
    assert distance(landed, seen.position._replace(z=0.0)) < 0.25


def test_a_velocity_to_land_with_is_finite(session: Session) -> None:
    vehicle = needs(session, "land.moving")
    with pytest.raises(ValueError, match="finite"):
        vehicle.land(Point(float("nan"), 0.0, 0.0))


def test_a_vehicle_that_cannot_land_on_what_moves_says_so(session: Session) -> None:
    vehicle = only(session)
    if "land.moving" in vehicle.capabilities:
        pytest.skip("this vehicle can")
    with pytest.raises(Unavailable, match="cannot land on what moves"):
        vehicle.land(Point(1.0, 0.0, 0.0))


BALL = "world: w\nspheres: {ball: {at: [4, 0], radius: 1 m}}\n"
UNSTABLE = {"vehicle.unstable": {"thing": "ball"}}


@pytest.fixture
def over_a_ball(backend: str, tmp_path: Path) -> Iterator[Session]:
    """A session with a vehicle that does not stand where it lands for the first time."""
    world = tmp_path / "w.yaml"
    world.write_text(BALL)
    if backend == "example":
        pytest.skip("it never knows whether it stands")
    options = Options(world=str(world) if backend.startswith("sim") else None)
    with OPENERS[backend](options) as session:
        session.wait()
        vehicle = take_off(session, 4)
        if isinstance(vehicle, FakeVehicle):
            vehicle.unstable_on.append("ball")
        wait(session, 5, Position(Point(4.0, 0.0, 4.0)))
        yield session


def test_where_it_does_not_stand_a_landing_is_refused_and_told(over_a_ball: Session) -> None:
    vehicle, order = only(over_a_ball), only(over_a_ball).land()
    wait_until(over_a_ball, lambda: order.ended, 20)
    seen = vehicle.observe()
    assert (order.state, order.reason) == ("refused", "it does not stand on the ball")
    assert {event.name: event.fields for event in seen.events} == UNSTABLE
    assert (seen.mode, seen.armed, seen.authority) == ("flying", True, "mission")
    # It holds there, follows what it is told, and can land elsewhere.
    held = wait(over_a_ball, 3, Hold())[-1]
    assert held.velocity.norm() < 0.05 and held.events == ()
    assert distance(held.position, seen.position) < 1.0
    wait(over_a_ball, 4, Position(Point(4.0, 3.0, 4.0)))
    finish(over_a_ball, vehicle.land(), 15)
    assert near(vehicle.observe().position, 4, 3, 0)


def test_a_landing_on_the_ground_disarms(session: Session) -> None:
    vehicle = needs(session, "arm")
    vehicle.arm()
    assert decided(session, vehicle.land()).state == "done"
    assert not vehicle.observe().armed


def test_the_last_of_two_orders_counts(session: Session) -> None:
    vehicle = only(session)
    first, second = vehicle.takeoff(2.0), vehicle.land()
    session.wait()
    assert (first.state, first.reason) == ("refused", "ended by: land")
    if not second.ended:
        finish(session, second, 5)
    assert second.state == "done" and only(session).observe().mode == "landed"


def test_takeoff_ends_a_landing(session: Session) -> None:
    vehicle = take_off(session, 4)
    landing = vehicle.land()
    wait(session, 0.8)
    assert vehicle.observe().flying
    order = decided(session, vehicle.takeoff(3.5))
    assert (landing.state, landing.reason) == ("refused", "ended by: takeoff")
    finish(session, order, 6)
    assert near(wait(session, 2)[-1].position, 0, 0, 3.5)


def test_takes_off_again_after_flying_into_the_ground(session: Session) -> None:
    vehicle = take_off(session, 1)
    seen = wait(session, 3, Velocity(z=-1.0))[-1]
    assert (seen.mode, seen.flying) == ("flying", False)
    finish(session, vehicle.takeoff(2.0), 6)
    assert near(wait(session, 1)[-1].position, 0, 0, 2)


def test_returns_home_and_lands(session: Session) -> None:
    needs(session, "return_home")
    vehicle = take_off(session, 2)
    wait(session, 8, Position(Point(8.0, -6.0, 2.0)))
    order = decided(session, vehicle.return_home())
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
    assert decided(session, vehicle.return_home()).state == "done"


def test_return_home_is_refused_on_the_ground_elsewhere(session: Session) -> None:
    needs(session, "return_home")
    vehicle = take_off(session)
    wait(session, 4, Position(Point(3.0, 0.0, 3.0)))
    finish(session, vehicle.land(), 10)
    assert decided(session, vehicle.return_home()).state == "refused"


def test_disarm_is_refused_in_the_air(session: Session) -> None:
    needs(session, "disarm")
    vehicle = take_off(session)
    order = decided(session, vehicle.disarm())
    assert (order.state, order.reason) == ("refused", "the vehicle is in the air")
    assert near(wait(session, 1)[-1].position, 0, 0, 3)


def test_emergency_stop_lets_it_fall(session: Session) -> None:
    needs(session, "emergency_stop")
    vehicle = take_off(session, 6)
    assert decided(session, vehicle.emergency_stop()).state == "done"
    assert decided(session, vehicle.emergency_stop()).state == "done"
    assert vehicle.observe().mode == "stopped" and not vehicle.observe().armed
    assert decided(session, vehicle.takeoff(2)).state == "refused"
    assert decided(session, vehicle.land()).state == "refused"
    assert decided(session, vehicle.reset()).state == "refused"
    wait_until(session, lambda: vehicle.observe().mode == "landed", 5)
    assert not vehicle.observe().flying
    assert decided(session, vehicle.reset()).state == "done"


def test_emergency_stop_ends_what_is_under_way(session: Session) -> None:
    vehicle = needs(session, "emergency_stop")
    order = vehicle.takeoff(3)
    wait(session, 1)
    vehicle.emergency_stop()
    session.wait()
    assert (order.state, order.reason) == ("refused", "the motors were stopped")


def test_trim_is_for_the_ground(session: Session) -> None:
    vehicle = needs(session, "trim")
    assert decided(session, vehicle.trim()).state == "done"
    take_off(session, 1)
    order = decided(session, vehicle.trim())
    assert (order.state, order.reason) == ("refused", "the motors are running")


def test_the_wind_is_known_where_it_is_among_the_capabilities(session: Session) -> None:
    vehicle = take_off(session)
    wind = vehicle.observe().wind
    assert (wind is not None) == ("wind" in vehicle.capabilities)
    assert wind in (None, ORIGIN)


def test_lights_can_be_set_anywhere(session: Session) -> None:
    vehicle = needs(session, "lights")
    assert decided(session, vehicle.lights(Lights("blink", "red", 2.0))).state == "done"
    take_off(session, 1)
    first, second = vehicle.lights(Lights("solid")), vehicle.lights(Lights("off"))
    session.wait()
    assert first is not second and first.state == second.state == "done"


def test_a_battery_is_swapped_on_the_ground_with_the_motors_off(session: Session) -> None:
    vehicle = needs(session, "battery.swap", "arm", "disarm")
    decided(session, vehicle.arm())
    order = decided(session, vehicle.swap_battery())
    assert (order.state, order.reason) == ("refused", "the motors are running")
    take_off(session)
    wait(session, 2)
    order = decided(session, vehicle.swap_battery())
    assert (order.state, order.reason) == ("refused", "the vehicle is in the air")
    assert vehicle.observe().mode == "flying"
    finish(session, vehicle.land(), 20)
    assert decided(session, vehicle.swap_battery()).state == "done"
    assert vehicle.observe().battery == pytest.approx(1.0, abs=1e-4)
    assert vehicle.observe().mode == "landed"


def test_lights_come_between_no_orders_of_motion(session: Session) -> None:
    vehicle = needs(session, "lights")
    first = vehicle.takeoff(3.0)
    vehicle.lights(Lights("solid"))
    assert vehicle.takeoff(3.0) is first
    wait(session, 0.5)
    lights = vehicle.lights(Lights("off"))
    assert vehicle.takeoff(3.0) is first
    finish(session, first, 6)
    assert lights.state == "done" and vehicle.observe().mode == "flying"


@pytest.mark.parametrize("altitude", [0.0, -1.0, nan])
def test_an_altitude_that_is_none_is_refused(session: Session, altitude: float) -> None:
    assert decided(session, only(session).takeoff(altitude)).state == "refused"
    assert not only(session).observe().armed


# Set-points.


def test_a_command_is_refused_on_the_ground(session: Session) -> None:
    vehicle = only(session)
    for name in ({"disarm", "arm"} & vehicle.capabilities) or {"land"}:
        decided(session, verb(vehicle, name))
        answer = vehicle.command(Velocity(z=2.0))
        assert not answer.accepted and "ground" in answer.reason
        seen = wait(session, 1)[-1]
        assert near(seen.position, 0, 0, 0) and seen.mode == "landed"
    order = vehicle.takeoff(2)
    assert not vehicle.command(Velocity(x=1.0)).accepted
    finish(session, order, 5)
    assert near(vehicle.observe().position, 0, 0, 2, 0.1)


@pytest.mark.parametrize(
    "setpoint", [Velocity(x=nan), Position(Point(0, 0, nan)), Position(ORIGIN, yaw=nan)]
)
def test_a_command_needs_finite_numbers(session: Session, setpoint: Setpoint) -> None:
    vehicle = take_off(session)
    with pytest.raises(ValueError, match="finite"):
        vehicle.command(setpoint)
    assert near(wait(session, 1)[-1].position, 0, 0, 3)


@pytest.mark.parametrize("name", ["takeoff", "land", "return_home"])
def test_a_command_ends_what_is_under_way(session: Session, name: str) -> None:
    needs(session, name)
    vehicle = only(session) if name == "takeoff" else take_off(session, 4)
    order = verb(vehicle, name)
    wait(session, 0.6)
    assert vehicle.command(Hold()) == ACCEPTED and order.state == "accepted"
    session.wait()
    assert (order.state, order.reason) == ("refused", "ended by a command")
    assert vehicle.observe().mode == "flying"
    wait(session, 2)
    height = vehicle.observe().position.z
    assert vehicle.observe().flying and abs(wait(session, 1)[-1].position.z - height) < 0.02


def test_the_last_word_of_a_period_counts(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Velocity(x=5.0))
    landing = vehicle.land()
    vehicle.command(Velocity(z=1.0))
    session.wait()
    assert (landing.state, landing.reason) == ("refused", "ended by a command")
    vehicle.command(Velocity(z=1.0))
    landing = decided(session, vehicle.land())
    assert landing.state == "accepted" and vehicle.observe().mode == "landing"


def test_what_a_command_ends_is_told_in_wait(session: Session) -> None:
    vehicle = take_off(session)
    landing = vehicle.land()
    vehicle.command(Hold())
    assert (landing.state, landing.reason) == ("sent", "")
    session.wait()
    assert (landing.state, landing.reason) == ("refused", "ended by a command")


def test_an_order_after_a_command_is_a_new_one(session: Session) -> None:
    vehicle = take_off(session)
    first = decided(session, vehicle.land())
    vehicle.command(Velocity(z=1.0))
    second = decided(session, vehicle.land())
    assert (first.state, first.reason) == ("refused", "ended by a command")
    assert second.state == "accepted" and vehicle.observe().mode == "landing"
    finish(session, second, 10)


@pytest.mark.parametrize(
    ("setpoint", "capability"),
    [(Velocity(), "velocity"), (Position(ORIGIN), "position"), (Attitude(), "attitude")],
)
def test_a_kind_of_set_point_that_it_lacks_is_refused(
    session: Session, setpoint: Setpoint, capability: str
) -> None:
    vehicle = take_off(session)
    answer = vehicle.command(setpoint)
    assert answer.accepted == (capability in vehicle.capabilities)
    assert answer.accepted or f"'{capability}'" in answer.reason


@pytest.mark.parametrize("seconds", [nan, inf, 0.0, -1.0])
def test_a_set_point_needs_a_validity(session: Session, seconds: float) -> None:
    vehicle = take_off(session)
    with pytest.raises(ValueError, match="valid"):
        vehicle.command(Velocity(x=1.0), valid_for=seconds)
    assert wait(session, 0.5)[-1].velocity.norm() < 0.02


def test_a_set_point_is_valid_for_a_short_time(session: Session) -> None:
    vehicle = take_off(session)
    vehicle.command(Velocity(x=1.0))
    seen = wait(session, 4)
    assert seen[-1].velocity.norm() < 0.02
    assert seen[-1].position.x < 1.0 * VALIDITY + 0.4
    wait(session, 2, Velocity(x=1.0))
    vehicle.command(Velocity(x=1.0), valid_for=2.0)
    assert wait(session, 1.9)[-1].velocity.x > 0.9
    assert wait(session, 2)[-1].velocity.norm() < 0.02


def test_a_velocity_is_in_the_world_frame(session: Session) -> None:
    vehicle = take_off(session)
    wait(session, 3, Position(Point(0.0, 0.0, 3.0), yaw=2.0))
    seen = wait(session, 3, Velocity(x=1.0, y=-0.5, z=0.25))[-1]
    assert distance(seen.velocity, (1.0, -0.5, 0.25)) < 0.02
    assert abs(seen.yaw - 2.0) < 0.02
    assert vehicle.observe() == seen


def test_forward_with_a_heading_of_90_degrees_is_north(session: Session) -> None:
    take_off(session)
    wait(session, 3, Position(Point(0.0, 0.0, 3.0), yaw=pi / 2))
    seen = wait(session, 3, Velocity(x=1.0, frame="heading"))[-1]
    assert distance(seen.velocity, (0.0, 1.0, 0.0)) < 0.03
    seen = wait(session, 3, Velocity(y=1.0, frame="heading"))[-1]
    assert distance(seen.velocity, (-1.0, 0.0, 0.0)) < 0.03


def test_the_heading_frame_turns_with_the_vehicle(session: Session) -> None:
    take_off(session)
    seen = wait(session, 4, Velocity(x=1.0, frame="heading", yaw_rate=0.5))[-1]
    assert abs(seen.velocity.norm() - 1) < 0.1
    assert 1.5 < seen.yaw < 2.1
    assert seen.velocity.y > 0.7
    assert abs(seen.rates.z - 0.5) < 0.05


def test_hold_again_and_again_is_one_hold(session: Session) -> None:
    vehicle = take_off(session)
    wait(session, 2, Velocity(x=2.0))
    wait(session, 2, Hold())
    there = vehicle.observe().position
    assert distance(wait(session, 2, Hold())[-1].position, there) < 0.01


def test_a_position_is_reached_and_held(session: Session) -> None:
    take_off(session)
    place = Position(Point(3.0, -2.0, 4.0))
    assert near(wait(session, 6, place)[-1].position, 3, -2, 4, 0.01)
    assert near(wait(session, 3, place)[-1].position, 3, -2, 4, 0.01)


def test_a_heading_is_turned_to_the_short_way(session: Session) -> None:
    take_off(session)
    wait(session, 4, Position(Point(0.0, 0.0, 3.0), yaw=3.0))
    seen = wait(session, 3, Position(Point(0.0, 0.0, 3.0), yaw=-3.0))
    assert abs(wrap(seen[-1].yaw + 3.0)) < 0.02
    assert all(abs(each.yaw) > 2.9 for each in seen)
    assert all(-pi < each.yaw <= pi for each in seen)


def test_a_position_can_turn_at_a_rate(session: Session) -> None:
    take_off(session)
    seen = wait(session, 2, Position(Point(0.0, 0.0, 3.0), yaw_rate=-0.5))[-1]
    assert -1.2 < seen.yaw < -0.8 and near(seen.position, 0, 0, 3)
    still = Position(Point(0.0, 0.0, 3.0))
    yaw = wait(session, 1, still)[-1].yaw
    assert abs(wait(session, 1, still)[-1].yaw - yaw) < 0.01


def test_a_tilt_speeds_it_up_the_way_it_leans(session: Session) -> None:
    needs(session, "attitude")
    take_off(session)
    wait(session, 3, Position(Point(0.0, 0.0, 3.0), yaw=pi / 2))
    seen = wait(session, 1, Attitude(pitch=0.1))[-1]
    # Nose down flies forward, here north, at g·tan(tilt), less what drag takes in a second.
    assert 0.65 < seen.velocity.y / (9.81 * 0.1003) < 1.2
    assert abs(seen.velocity.x) < 0.05 and abs(seen.position.z - 3) < 0.1
    wait(session, 3, Hold())
    seen = wait(session, 1, Attitude(roll=0.1, climb=0.5))[-1]
    assert seen.velocity.x > 0.7 and seen.velocity.z == pytest.approx(0.5, abs=0.1)


def test_a_tilt_can_be_a_share_of_the_limits(session: Session) -> None:
    vehicle = needs(session, "attitude", "limits")
    take_off(session)
    vehicle.configure(Limits(max_tilt=0.2, max_climb=1.0, max_yaw_rate=1.0))
    seen = wait(session, 1, Attitude(pitch=0.5, climb=0.5, yaw_rate=-0.5, unit="share"))[-1]
    speed = (seen.velocity.x**2 + seen.velocity.y**2) ** 0.5
    assert 0.65 < speed / (9.81 * 0.1003) < 1.2
    assert seen.velocity.z == pytest.approx(0.5, abs=0.1)
    assert seen.rates.z == pytest.approx(-0.5, abs=0.05)
    wait(session, 4, Hold())
    steep = wait(session, 1, Attitude(pitch=1.0))[-1].velocity
    assert (steep.x**2 + steep.y**2) ** 0.5 < 9.81 * 0.21


@pytest.mark.parametrize("thrust", [0.0, -1.0])
def test_without_thrust_it_falls(thrust: float) -> None:
    with open_session(Options()) as session:
        take_off(session, 30)
        seen = wait(session, 1, Attitude(pitch=0.2, thrust=thrust))
        # Nearly free fall, and not pushed down: the rotors idle, and the air has drag.
        assert -9.81 < seen[-1].velocity.z < -8
        assert wait(session, 4, Hold())[-1].velocity.norm() < 0.05


# Limits.


def test_limits_change_in_flight_one_by_one(session: Session) -> None:
    needs(session, "limits")
    vehicle = take_off(session)
    assert vehicle.configure(Limits(max_speed=1.0)) == ACCEPTED
    assert vehicle.configure(Limits(max_climb=0.5, max_yaw_rate=0.3)) == ACCEPTED
    seen = wait(session, 3, Velocity(x=3.0, y=4.0, z=3.0, yaw_rate=2.0))[-1]
    assert distance(seen.velocity, (0.6, 0.8, 0.5)) < 0.05
    assert abs(seen.rates.z - 0.3) < 0.02


def test_no_flight_above_the_highest_altitude(session: Session) -> None:
    needs(session, "limits")
    vehicle = take_off(session)
    vehicle.configure(Limits(max_altitude=4.0))
    assert max(seen.position.z for seen in wait(session, 4, Velocity(z=2.0))) < 4.05
    assert abs(wait(session, 3, Position(Point(0, 0, 9.0)))[-1].position.z - 4) < 0.05
    finish(session, vehicle.land(), 10)
    assert decided(session, vehicle.takeoff(5.0)).state == "refused"


def test_the_lowest_altitude_binds_neither_takeoff_nor_landing(session: Session) -> None:
    vehicle = needs(session, "limits")
    vehicle.configure(Limits(min_altitude=2.0))
    take_off(session, 3)
    assert min(seen.position.z for seen in wait(session, 4, Velocity(z=-1.0))) > 1.95
    assert abs(wait(session, 3, Position(ORIGIN))[-1].position.z - 2) < 0.05
    finish(session, vehicle.land(), 10)
    assert abs(vehicle.observe().position.z) < 0.002
    finish(session, vehicle.takeoff(1.0), 6)
    assert near(wait(session, 1)[-1].position, 0, 0, 1)


def test_it_returns_below_a_ceiling_that_came_down(session: Session) -> None:
    needs(session, "limits", "return_home")
    vehicle = take_off(session, 3)
    wait(session, 5, Position(Point(3.0, 0.0, 3.0)))
    order = decided(session, vehicle.return_home())
    vehicle.configure(Limits(max_altitude=3.5))
    finish(session, order, 30)
    assert near(vehicle.observe().position, 0, 0, 0, 0.1)


def test_to_change_no_limit_is_accepted(session: Session) -> None:
    assert only(session).configure(Limits()) == ACCEPTED


@pytest.mark.parametrize("value", [0.0, -1.0, nan])
def test_a_limit_that_is_none_is_a_mistake(session: Session, value: float) -> None:
    with pytest.raises(UserError, match="max_speed") as caught:
        only(session).configure(Limits(max_speed=value))
    assert caught.value.code == "bad-limit"


def test_limits_that_contradict_are_refused(session: Session) -> None:
    vehicle = needs(session, "limits")
    vehicle.configure(Limits(max_altitude=4.0))
    answer = vehicle.configure(Limits(min_altitude=5.0, max_speed=0.1))
    assert not answer.accepted and "lowest altitude" in answer.reason
    # All or none: the speed is what it was.
    take_off(session)
    assert wait(session, 3, Velocity(x=1.0))[-1].velocity.x > 0.9


def test_profiles_are_limits_by_name(session: Session) -> None:
    vehicle = needs(session, "limits")
    assert {"indoor", "outdoor"} <= set(vehicle.profiles)
    assert vehicle.configure(vehicle.profiles["indoor"]) == ACCEPTED
