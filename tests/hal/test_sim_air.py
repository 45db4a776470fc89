"""Vehicles in moving air: it leans them, carries them, and they estimate it; rotors blow down."""

from __future__ import annotations

from math import acos, atan, exp, hypot

import pytest

from hal.sim import open_session
from hal.sim.downwash import downwash
from hal.sim.model import AIR_DENSITY
from hal.sim.model_files import load_model
from hal.vehicle import PERIOD, Attitude, Observation, Options, Position, VehicleSpec
from tests.hal.flying import LONG, hovering, named, session_of, take_off, wait
from vencejo.geometry import Point, Quaternion, distance
from worlds.loader import read_world

WEST = "3m/s@270deg"
ARDRONE2 = load_model("ardrone2")
DRAG = "ideal,+drag"
STILL = Point(0.0, 0.0, 0.0)


def tilt(q: Quaternion) -> float:
    """The angle between the body's z axis and the vertical, radians."""
    x, y, _, _ = q
    return acos(1 - 2 * (x * x + y * y))


def closed_form_tilt(speed: float) -> float:
    """The tilt at which the weight's share holds against that much air from ahead."""
    drag = AIR_DENSITY / 2 * ARDRONE2.drag.area * speed * speed + ARDRONE2.drag.rotors * speed
    return atan(drag / ARDRONE2.weight)


@pytest.mark.parametrize("speed", [2.0, 4.0])
def test_a_hover_in_wind_leans_as_far_as_the_drag_asks(speed: float) -> None:
    with hovering(wind=f"{speed}@270", physics=DRAG) as (session, _):
        seen = wait(session, 1.0, Position(Point(0.0, 0.0, 5.0), yaw=0.0))[-1]
    assert tilt(seen.attitude) == pytest.approx(closed_form_tilt(speed), rel=0.05)
    # Heading east, into the wind: its nose is down, so that the thrust points to the west.
    x, y, z, w = seen.attitude
    assert 2 * (x * z + w * y) < -0.05 and abs(2 * (y * z - w * x)) < 1e-3
    assert distance(seen.position, Point(0.0, 0.0, 5.0)) < 0.01


@pytest.mark.parametrize(
    ("bearing", "direction"), [(270.0, (1, 0)), (0.0, (0, -1)), (45.0, (-0.7071, -0.7071))]
)
def test_a_level_vehicle_is_carried_along(bearing: float, direction: tuple[float, float]) -> None:
    with hovering(wind="none", physics=DRAG) as (_, vehicle):
        assert vehicle.observe().wind == STILL
    with open_session(Options(settings={"wind": f"2@{bearing}", "physics": DRAG})) as session:
        vehicle = take_off(session, 5.0)
        vehicle.command(Attitude(), valid_for=LONG)
        seen = wait(session, 20.0)[-1]
    expected = (2 * direction[0], 2 * direction[1], 0.0)
    assert seen.velocity == pytest.approx(expected, abs=0.05)


def test_without_drag_the_wind_moves_nothing() -> None:
    flights = []
    for wind in ("none", "9m/s@270deg,gusts=12m/s,turbulence=moderate"):
        with hovering(wind=wind, physics="ideal") as (_, vehicle):
            flights.append(vehicle.observe().position)
    assert flights[0] == flights[1]


def test_it_estimates_the_wind_behind_a_low_pass_of_a_second() -> None:
    with open_session(Options(settings={"wind": WEST})) as session:
        seen = wait(session, 8.0)
    for second in (0.5, 1.0, 2.0):
        wind = seen[round(second / PERIOD) - 1].wind
        assert wind == pytest.approx((3.0 * (1 - exp(-second)), 0.0, 0.0))
    assert seen[-1].wind == pytest.approx((3.0, 0.0, 0.0), abs=2e-3)


def test_a_model_that_estimates_none_tells_none_and_is_blown_at_all_the_same() -> None:
    drones = (VehicleSpec("drone", "crazyflie"),)
    with open_session(Options(drones, settings={"wind": WEST})) as session:
        vehicle = take_off(session)
        seen = vehicle.observe()
    assert seen.wind is None and "wind" not in vehicle.capabilities
    assert tilt(seen.attitude) > 0.03


def test_the_wind_of_a_run_takes_the_place_of_the_world_s() -> None:
    windy = read_world("world: w\nwind: 4 m/s@0\n", "w")
    for given, expected in (
        ({}, (0.0, -4.0, 0.0)),
        ({"wind": WEST}, (3.0, 0.0, 0.0)),
        ({"wind": "none"}, (0.0, 0.0, 0.0)),
    ):
        with session_of(windy, **given) as session:
            assert wait(session, 9.0)[-1].wind == pytest.approx(expected, abs=2e-3)


def pair(physics: str = "real") -> tuple[Observation, Observation]:
    """A vehicle at 2 m and one at 3.5 m above it, after a while."""
    below, above = Point(0.0, 0.0, 2.0), Point(0.0, 0.0, 3.5)
    with open_session(Options(named("a", "b"), settings={"physics": physics})) as session:
        low, high = session.vehicles.values()
        orders = low.takeoff(below.z), high.takeoff(above.z)
        while not all(order.ended for order in orders):
            session.wait()
        low.command(Position(below), valid_for=LONG)
        high.command(Position(above), valid_for=LONG)
        wait(session, 12.0)
        return low.observe(), high.observe()


def test_the_lower_of_two_feels_the_downwash_of_the_upper() -> None:
    low, high = pair()
    expected = downwash(ARDRONE2.rotors, ARDRONE2.weight, (0.0, 0.0, -1.5))
    assert low.wind is not None
    assert low.wind.z == pytest.approx(-expected, rel=0.05)
    assert hypot(low.wind.x, low.wind.y) == 0.0
    assert high.wind == STILL


def test_downwash_costs_the_lower_one_power_unless_it_is_left_out() -> None:
    (low, _), (without, _) = pair(), pair("real,-downwash")
    assert without.wind == STILL
    assert low.battery < without.battery - 0.002


def test_one_more_vehicle_changes_no_other_s_air() -> None:
    def flown(names: tuple[str, ...]) -> list[tuple[float, float, float]]:
        settings = {"wind": "3m/s@200deg,gusts=5m/s,turbulence=natural"}
        with open_session(Options(named(*names), seed=3, settings=settings)) as session:
            for vehicle in session.vehicles.values():
                vehicle.takeoff(3.0)
            wait(session, 6.0)
            return [tuple(session.vehicles[name].observe().position) for name in ("a", "b")]

    assert flown(("a", "b")) == flown(("a", "b", "c"))
    assert flown(("a", "b"))[0] != flown(("a", "b"))[1]


def test_equal_seeds_give_equal_flights_in_wind_and_others_do_not() -> None:
    def flown(seed: int) -> Point:
        settings = {"wind": "3m/s@200deg,gusts=5m/s,turbulence=natural"}
        with open_session(Options(seed=seed, settings=settings)) as session:
            return take_off(session).observe().position

    assert flown(1) == flown(1) != flown(2)
