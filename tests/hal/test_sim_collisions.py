"""Collisions: every hit on any side of anything is told once, with its name."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.sim import SimSession
from hal.vehicle import Hold, Observation, Position, Vehicle, Velocity
from tests.hal.flying import finish, only, session_of, take_off, told, wait
from tests.hal.scenes import thing_of, turned, world_of
from vencejo.geometry import Point, yaw_quaternion
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Motion, Shape, Sphere, Thing

CENTRE = Point(0.0, 0.0, 9.0)
ROOF = Mesh(
    np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [0, 0, 1]], float),
    np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [0, 2, 1], [0, 3, 2]], np.int32),
)
ON_ITS_SIDE = turned((1.0, 0.0, 0.0), pi / 2)
TILTED = turned((0.6, 0.8, 0.0), pi / 6)
STEEP = turned((0.0, 1.0, 0.0), pi / 3)
THINGS = {
    "box": thing_of("box", Cuboid(Point(2, 2, 2)), CENTRE),
    "tilted box": thing_of("tilted box", Cuboid(Point(2, 2, 2)), CENTRE, TILTED),
    "steep box": thing_of("steep box", Cuboid(Point(2, 3, 1)), CENTRE, STEEP),
    "plank": thing_of("plank", Cuboid(Point(3, 1, 0.05)), CENTRE),
    "ball": thing_of("ball", Sphere(1.0), CENTRE),
    "drum": thing_of("drum", Cylinder(0.8, 2.0), CENTRE),
    "log": thing_of("log", Cylinder(0.8, 3.0), CENTRE, ON_ITS_SIDE),
    "roof": thing_of("roof", ROOF, CENTRE),
}


def towards(azimuth: float, elevation: float) -> Point:
    return Point(cos(azimuth) * cos(elevation), sin(azimuth) * cos(elevation), sin(elevation))


@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from(sorted(THINGS)),
    st.floats(-pi, pi),
    st.floats(-pi / 2, pi / 2),
    st.floats(1.0, 4.0),
    st.floats(-pi, pi),
)
def test_a_hit_from_any_direction_is_told_once(
    name: str, azimuth: float, elevation: float, speed: float, yaw: float
) -> None:
    """It flies at the middle of a thing, and back as soon as it is told.

    It aims anew in each period, since horizontal and vertical speed build up differently.
    """
    way = towards(azimuth, elevation)
    speed = min(speed, 1.9 / max(abs(way.z), 1e-9))
    start = Point(-14 * cos(azimuth), -14 * sin(azimuth), 0.0)
    before = Point(*(middle - 6 * along for middle, along in zip(CENTRE, way, strict=True)))
    with session_of(world_of(THINGS[name], start=start)) as session:
        vehicle = take_off(session, before.z)
        assert told(wait(session, 7, Position(before, yaw=yaw))) == []
        seen: list[Observation] = []
        while not told(seen[-1:]) and len(seen) < 400:
            x, y, z = vehicle.observe().position
            aim = Point(CENTRE.x - x, CENTRE.y - y, CENTRE.z - z)
            share = speed / aim.norm()
            seen += wait(session, 0.025, Velocity(aim.x * share, aim.y * share, aim.z * share))
        seen += wait(session, 2, Velocity(-way.x * speed, -way.y * speed, -way.z * speed))
        assert told(seen) == [("collision", name)]
        assert vehicle.observe().mode == "flying"


def until_told(
    session: SimSession, vehicle: Vehicle, setpoint: Velocity, seconds: float
) -> list[Observation]:
    seen: list[Observation] = []
    while not told(seen[-1:]) and len(seen) < seconds * 40:
        seen += wait(session, 0.025, setpoint)
    return seen


@pytest.mark.parametrize("height", [0.3, 1.0, 1.6, 1.9, 2.2, 2.8, 3.2, 3.6, 3.9])
def test_a_ball_is_hit_at_any_height(height: float) -> None:
    """From a hit on the steep side to one that passes over its top."""
    ball = thing_of("ball", Sphere(2.0), (8, 0, 2))
    with session_of(world_of(ball)) as session:
        take_off(session, height)
        seen = until_told(session, only(session), Velocity(x=4.0), 4)
        assert told(seen + wait(session, 0.3, Hold())) == [("collision", "ball")]


@pytest.mark.parametrize("yaw", [0.0, pi / 4, 2.0])
@pytest.mark.parametrize("slant", [0.0, 0.7, 1.3])
def test_a_wall_is_hit_with_any_side_of_the_vehicle(yaw: float, slant: float) -> None:
    wall = thing_of("wall", Cuboid(Point(0.3, 60, 4)), (4, 0, 2))
    with session_of(world_of(wall)) as session:
        take_off(session, 2.0)
        wait(session, 3, Position(Point(0, 0, 2.0), yaw=yaw))
        ahead = Velocity(2 * cos(slant), 2 * sin(slant))
        assert told(wait(session, 9, ahead)) == [("collision", "wall")]


def test_a_ceiling_is_hit_while_it_takes_off() -> None:
    ceiling = thing_of("ceiling", Cuboid(Point(4, 4, 0.2)), (0, 0, 2.1))
    with session_of(world_of(ceiling)) as session:
        only(session).takeoff(3.0)
        assert told(wait(session, 4)) == [("collision", "ceiling")]


def test_a_table_is_hit_from_above_in_flight_but_not_in_a_landing() -> None:
    table = thing_of("table", Cuboid(Point(2, 2, 1)), (0, 0, 0.5))
    with session_of(world_of(table, start=Point(0, 0, 1.0))) as session:
        vehicle = take_off(session, 2.0)
        assert told(wait(session, 3, Velocity(z=-1.0))) == [("collision", "table")]
        assert told(wait(session, 3, Velocity(z=1.0))) == []
        order = vehicle.land()
        assert told(wait(session, 8)) == [] and order.state == "done"


@pytest.mark.parametrize("speed", [0.5, 1.0, 1.5, 2.0, 3.0])
def test_each_of_two_things_is_told(speed: float) -> None:
    """It hits both in a corner, and does not come back as from a spring."""
    corner = (
        thing_of("east", Cuboid(Point(0.2, 8, 4)), (3, 0, 2)),
        thing_of("north", Cuboid(Point(8, 0.2, 4)), (0, 3, 2)),
    )
    with session_of(world_of(*corner)) as session:
        take_off(session, 2.0)
        seen = wait(session, 3 / speed + 2, Velocity(speed, speed))
        assert sorted(told(seen)) == [("collision", "east"), ("collision", "north")]
        assert min(min(each.velocity.x, each.velocity.y) for each in seen) > -0.25


def test_a_second_contact_is_told_again() -> None:
    wall = thing_of("wall", Cuboid(Point(0.3, 6, 4)), (3, 0, 2))
    with session_of(world_of(wall)) as session:
        take_off(session, 2.0)
        for _ in range(3):
            assert told(wait(session, 4, Velocity(x=1.0))) == [("collision", "wall")]
            assert told(wait(session, 2, Velocity(x=-0.5))) == []


def moving(name: str, shape: Shape, *through: Point, speed: float = 1.0) -> Thing:
    still = thing_of(name, shape, through[0])
    motion = Motion(through, speed, False, False)
    return Thing(name, still.kind, still.at, UPRIGHT, still.parts, motion=motion)


@pytest.mark.parametrize("parked", [True, False])
def test_what_moves_and_hits_the_vehicle_is_told(parked: bool) -> None:
    cart = moving("cart", Cuboid(Point(1, 1, 4)), Point(-12, 0, 2), Point(40, 0, 2))
    with session_of(world_of(cart)) as session:
        if not parked:
            take_off(session, 1.0)
        assert told(wait(session, 16)) == [("collision", "cart")]


def test_a_lift_hits_the_hovering_vehicle_from_below() -> None:
    lift = moving("lift", Cuboid(Point(2, 2, 1)), Point(4, 0, -0.4), Point(4, 0, 8), speed=0.3)
    with session_of(world_of(lift)) as session:
        vehicle = take_off(session, 4.0)
        assert told(wait(session, 18, Position(Point(4, 0, 4)))) == [("collision", "lift")]
        assert vehicle.observe().position.z > 4.5


def test_vehicles_hit_each_other_and_none_lands_on_another() -> None:
    world = world_of(start=Point(0, 0, 0))
    with session_of(world, ("cat", "mouse")) as session:
        cat, mouse = session.vehicles["cat"], session.vehicles["mouse"]
        take_off(session, 2.0)
        wait(session, 4, Position(Point(2.0, 0.0, 2.0)))
        order, events = cat.land(), {"cat": [], "mouse": []}
        for _ in range(240):
            session.wait()
            for name, vehicle in (("cat", cat), ("mouse", mouse)):
                events[name] += told([vehicle.observe()])
        assert (order.state, order.reason) == ("refused", "it does not stand on the mouse")
        assert events == {
            "cat": [("collision", "mouse"), ("unstable", "mouse")],
            "mouse": [("collision", "cat")],
        }
        assert cat.observe().mode == "flying" and not mouse.observe().armed


def test_what_falls_on_a_table_hits_it() -> None:
    table = thing_of("table", Cuboid(Point(2, 2, 1)), (0, 0, 0.5))
    with session_of(world_of(table, start=Point(0, 0, 1.0))) as session:
        vehicle = take_off(session, 3.0)
        vehicle.emergency_stop()
        assert told(wait(session, 4)) == [("collision", "table"), ("crashed", "table")]
        assert vehicle.observe().mode == "landed"


def test_standing_through_a_quarter_turn_is_no_collision() -> None:
    """A pad carries the vehicle round a corner, and it takes off from there."""
    pad = moving("pad", Cuboid(Point(3, 3, 0.3)), Point(0, 0, 0.15), Point(4, 0, 0.15), speed=0.5)
    with session_of(world_of(pad, start=Point(0, 0, 0.3))) as session:
        assert told(wait(session, 12)) == []
        vehicle = only(session)
        finish(session, vehicle.takeoff(1.0), 6)
        assert told(wait(session, 2)) == []


def test_the_heading_of_a_thing_counts() -> None:
    turned_box = thing_of("box", Cuboid(Point(4, 0.4, 2)), (4, 0, 1), yaw_quaternion(pi / 3))
    with session_of(world_of(turned_box)) as session:
        take_off(session, 1.0)
        assert told(wait(session, 4, Velocity(x=2.0)))[:1] == [("collision", "box")]
