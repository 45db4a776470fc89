"""Landings: done on what the vehicle can stand on, still or moving; it leaves everything else."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import cos, hypot, pi, radians, sin, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.engines import open_engine
from hal.orders import Order
from hal.sim import SimSession
from hal.vehicle import PERIOD, Observation, Options, Position, Vehicle
from tests.hal.engines import ENGINES
from tests.hal.flying import finish, named, only, session_of, take_off, told, wait, wait_until
from tests.hal.scenes import thing_of, turned, world_of
from vencejo.geometry import Point, distance, roll_pitch_of, rotate_xy, yaw_of
from worlds.motion import pose_at
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Motion, Shape, Sphere, Terrain, Thing
from worlds.world import Ground

SOUTH = Point(0.0, -8.0, 0.0)


def roof(slope: float, half: float = 2.0) -> Mesh:
    """A ridge along y, at z = 0 at its eaves; ``slope`` in degrees."""
    top = half * tan(radians(slope))
    corners = [[x, y, 0] for y in (-2, 2) for x in (-half, half)]
    faces = [[0, 1, 4], [3, 2, 5], [1, 3, 5], [1, 5, 4], [2, 0, 4], [2, 4, 5], [0, 2, 3], [0, 3, 1]]
    ridge = [[0, -2, top], [0, 2, top]]
    return Mesh(np.array(corners + ridge, float), np.array(faces, np.int32))


def sloping(slope: float, axis: tuple[float, float, float] = (0.0, 1.0, 0.0)) -> Thing:
    """A box of 6 × 6 m above the origin that leans by ``slope`` degrees."""
    return thing_of("slope", Cuboid(Point(6, 6, 0.5)), (0, 0, 3), turned(axis, radians(slope)))


def landing(session: SimSession, x: float, y: float, height: float = 6.0) -> list[Observation]:
    """Land at a place from a hover over it, until the order has ended; what was seen."""
    take_off(session, height)
    wait(session, 7, Position(Point(x, y, height)))
    order = only(session).land()
    seen: list[Observation] = []
    while not order.ended and len(seen) < 1600:
        seen += wait(session, 0.025)
    assert order.ended
    assert (order.state == "done") == (seen[-1].mode == "landed")
    return seen


def stays(session: SimSession) -> bool:
    """Whether the vehicle stands still for five seconds."""
    place = only(session).observe().position
    return distance(place, wait(session, 5)[-1].position) < 0.005


BOX = thing_of("box", Cuboid(Point(2, 2, 2)), (0, 0, 1))
STANDS = {
    "in the middle of a box": (BOX, 0.0, 0.0),
    "near the corner of a box": (BOX, 0.85, 0.85),
    "with a third of it over the edge": (BOX, 0.9, 0.0),
    "on a drum": (thing_of("drum", Cylinder(0.6, 2.0), (0, 0, 1)), 0.1, 0.2),
    "on a beam": (thing_of("beam", Cuboid(Point(3, 0.3, 1)), (0, 0, 0.5)), 0.2, 0.0),
    "on a flat roof": (thing_of("roof", roof(15), (0, 0, 0)), 0.9, 0.3),
    "beside a low box": (thing_of("low", Cuboid(Point(2, 2, 0.06)), (0, 0, 0.03)), 1.1, 0.0),
}


@pytest.mark.parametrize("case", STANDS)
def test_it_lands_on_what_it_can_stand_on(case: str) -> None:
    thing, x, y = STANDS[case]
    with session_of(world_of(thing, start=SOUTH)) as session:
        seen = landing(session, x, y)
        assert seen[-1].mode == "landed" and not seen[-1].armed and told(seen) == []
        assert distance(seen[-1].position[:2], (x, y)) < 0.1
        assert stays(session)
        vehicle = take_off(session, 1.5)
        rise = vehicle.observe().position.z - seen[-1].position.z
        assert rise == pytest.approx(1.5, abs=0.1)


@settings(max_examples=12, deadline=None)
@given(st.floats(0.5, 3.0), st.floats(0.05, 2.0), st.floats(0.0, 1.0), st.floats(-pi, pi))
def test_it_lands_wherever_it_comes_down_on_a_drum(
    radius: float, height: float, share: float, towards: float
) -> None:
    """The engine tells of few places where two flat faces meet, if one of them is round."""
    drum = thing_of("drum", Cylinder(radius, height), (0, 0, height / 2))
    away = share * (radius - 0.4)
    x, y = away * cos(towards), away * sin(towards)
    with session_of(world_of(drum, start=SOUTH)) as session:
        seen = landing(session, x, y, height + 1.0)
        assert seen[-1].mode == "landed" and told(seen) == []
        assert seen[-1].position.z == pytest.approx(height, abs=0.005)
        assert stays(session)


UNSTABLE = {
    "on top of a bigger ball": (thing_of("thing", Sphere(7.0), (0, 0, -2)), 0.0, 0.0),
    "on top of a ball": (thing_of("thing", Sphere(2.0), (0, 0, 2)), 0.0, 0.0),
    "on top of a big ball": (thing_of("thing", Sphere(5.0), (0, 0, 0)), 0.3, 0.0),
    "on top of a small ball": (thing_of("thing", Sphere(0.5), (0, 0, 0.5)), 0.1, 0.1),
    "on a ball": (thing_of("thing", Sphere(2.0), (0, 0, 2)), 0.5, 0.3),
    "on the side of a ball": (thing_of("thing", Sphere(2.0), (0, 0, 2)), 1.1, 0.3),
    "on a pole": (thing_of("thing", Cylinder(0.04, 3.0), (0, 0, 1.5)), 0.0, 0.0),
    "on a log": (
        thing_of("thing", Cylinder(0.5, 4.0), (0, 0, 1), turned((1.0, 0.0, 0.0), pi / 2)),
        *(0.1, 0.0),
    ),
    "half over an edge": (thing_of("thing", Cuboid(Point(2, 2, 2)), (0, 0, 1)), 1.0, 0.0),
    "a little over an edge": (
        thing_of("thing", Cuboid(Point(2, 2, 2)), (0, 0, 1)),
        *(1.05, 0.0),
    ),
    "over an edge": (thing_of("thing", Cuboid(Point(2, 2, 2)), (0, 0, 1)), 1.07, 0.2),
    "over a corner": (thing_of("thing", Cuboid(Point(2, 2, 2)), (0, 0, 1)), 1.1, 1.1),
    "on a ridge": (thing_of("thing", roof(30), (0, 0, 0)), 0.0, 0.0),
    "on a steep roof": (thing_of("thing", roof(45), (0, 0, 0)), 0.7, 0.0),
    "on a roof of 30°": (thing_of("thing", roof(30), (0, 0, 0)), 0.9, 0.5),
    "on a box that leans by 60°": (
        thing_of("thing", Cuboid(Point(3, 3, 1)), (0, 0, 2), turned((0.0, 1.0, 0.0), pi / 3)),
        *(0.2, 0.0),
    ),
}


@pytest.mark.parametrize("case", UNSTABLE)
def test_it_leaves_what_it_cannot_stand_on(case: str) -> None:
    thing, x, y = UNSTABLE[case]
    with session_of(world_of(thing, start=SOUTH)) as session:
        seen = landing(session, x, y, 7.0)
        assert seen[-1].mode == "flying" and seen[-1].armed
        assert told(seen[-1:]) == [("unstable", "thing")]
        assert told(seen[:-1]) in ([], [("collision", "thing")])
        assert told(wait(session, 5)) == []
        clear = only(session).observe()
        assert clear.flying and clear.velocity.norm() < 0.02
        assert clear.position.z > seen[-1].position.z + 0.4


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("slope", [28.0, 36.0, 40.0])
def test_a_landing_on_a_steep_slope_comes_to_an_end(slope: float, engine: str) -> None:
    """Also where it bounces on its edge again and again."""
    options = Options(named("drone"), settings={"engine": engine})
    world = world_of(sloping(slope), start=SOUTH)
    with SimSession(options, world, open_engine(engine)) as session:
        assert told(landing(session, 0.0, 0.0))[-1] == ("unstable", "slope")
        assert only(session).observe().mode == "flying"


@settings(max_examples=15, deadline=None)
@given(
    st.one_of(st.floats(0.0, 23.0), st.floats(27.0, 70.0)), st.floats(-pi, pi), st.floats(-1.0, 1.0)
)
def test_a_slope_carries_it_up_to_a_limit(slope: float, towards: float, aside: float) -> None:
    """Of any direction: it stands up to 25°, and lies along the slope then."""
    thing = sloping(slope, (cos(towards), sin(towards), 0.0))
    with session_of(world_of(thing, start=SOUTH)) as session:
        seen = landing(session, aside, 0.0, 9.0)
        if slope > 25.0:
            # From a very steep one it may slide to the ground.
            slid = seen[-1].mode == "landed" and seen[-1].position.z < 0.01
            assert told(seen)[-1] == ("collision" if slid else "unstable", "slope")
            return
        assert seen[-1].mode == "landed" and told(seen) == []
        roll, pitch = roll_pitch_of(seen[-1].attitude)
        assert hypot(roll, pitch) == pytest.approx(radians(slope), abs=0.03)
        assert stays(session)
        assert take_off(session, 1.0).observe().flying


def test_a_steep_hill_is_ground_on_which_it_does_not_stand() -> None:
    heights = ((0.0,) * 3, (0.0, 9.0, 0.0), (0.0,) * 3)
    hill = Ground((85, 130, 60), 100.0, terrain=Terrain(heights, 20.0))
    with session_of(world_of(ground=hill, start=Point(0, -20, 0))) as session:
        seen = landing(session, 5.0, 0.5, 14.0)
        assert told(seen) == [("unstable", "ground")]


def test_what_is_hit_on_the_way_down_is_told() -> None:
    """It comes down fast beside the edge, since the ground is far below."""
    tower = thing_of("tower", Cuboid(Point(2, 2, 6)), (0, 0, 3))
    with session_of(world_of(tower, start=SOUTH)) as session:
        assert told(landing(session, 1.15, 0.0, 8.0)) == [
            ("collision", "tower"),
            ("unstable", "tower"),
        ]


def test_a_return_ends_as_a_landing_does() -> None:
    """It begins on a ball, which it leaves at once."""
    ball = thing_of("ball", Sphere(0.8), (0, 0, 0.8))
    with session_of(world_of(ball, start=Point(0, 0, 1.6))) as session:
        vehicle = take_off(session, 2.0)
        wait(session, 4, Position(Point(3, 0, 4.0)))
        order = vehicle.return_home()
        seen: list[Observation] = []
        while not order.ended:
            seen += wait(session, 0.025)
        assert (order.state, order.reason) == ("refused", "it does not stand on the ball")
        assert told(seen) == told(seen[-1:]) == [("unstable", "ball")]
        assert seen[-1].mode == "flying"


# Pads that move.


SQUARE_PAD = Cuboid(Point(2, 2, 0.3))


def pad(
    speed: float,
    through: tuple[Point, ...],
    loop: bool = False,
    turns: bool = True,
    shape: Shape = SQUARE_PAD,
) -> Thing:
    still = thing_of("pad", shape, through[0])
    motion = Motion(through, speed, loop, turns)
    return Thing("pad", still.kind, still.at, UPRIGHT, still.parts, motion=motion)


STRAIGHT = (Point(0, 0, 0.15), Point(200, 0, 0.15))
ROUND = tuple(Point(6 * cos(k * pi / 18), 6 * sin(k * pi / 18), 0.15) for k in range(36))
THERE_AND_BACK = (Point(0, 0, 0.15), Point(20, 0, 0.15))
SQUARE = tuple(Point(x, y, 0.15) for x, y in ((0, 0), (12, 0), (12, 12), (0, 12)))
HOVER = 0.9
"""Height from which it lands on a pad, metres."""


@cache
def descent() -> float:
    """Seconds from the order to land, at the height of HOVER, until it is as low as a pad's top."""
    with session_of(world_of()) as session:
        vehicle = take_off(session, HOVER)
        began = vehicle.observe().time
        order = vehicle.land()
        while vehicle.observe().position.z > 0.3:
            session.wait()
        assert not order.ended
        return vehicle.observe().time - began


def on_pad(thing: Thing, seen: Observation) -> tuple[float, float]:
    """The place of the vehicle on a pad, in the pad's own axes."""
    at, attitude = pose_at(thing, seen.time)
    away = seen.position.minus(at)
    return rotate_xy(away.x, away.y, -yaw_of(attitude))


def at_a_corner(thing: Thing, time: float) -> bool:
    """Whether a pad turns about within 50 ms."""
    before, after = (yaw_of(pose_at(thing, time + each)[1]) for each in (-0.05, 0.05))
    return cos(after - before) < 0.9


def meet(session: SimSession, thing: Thing, time: float) -> tuple[Order, list[Observation]]:
    """Land where a pad passes, so as to touch it there; what was seen until the order ended."""
    vehicle = only(session)
    place, _ = pose_at(thing, time)
    finish(session, vehicle.takeoff(HOVER), 10)
    until = time - descent() - vehicle.observe().time
    wait(session, until, Position(Point(place.x, place.y, HOVER)))
    order = vehicle.land()
    seen: list[Observation] = []
    while not order.ended:
        seen += wait(session, 0.025)
    return order, seen


PADS = {
    "slow": pad(0.5, STRAIGHT),
    "at a walk": pad(1.0, STRAIGHT),
    "fast": pad(2.0, STRAIGHT),
    "fast, sideways": pad(2.0, STRAIGHT, turns=False),
    "fast, round": pad(2.0, STRAIGHT, shape=Cylinder(1.0, 0.3)),
    "in a circle": pad(1.0, ROUND, loop=True),
    "in a circle, fast": pad(2.0, ROUND, loop=True),
    "there and back": pad(0.5, THERE_AND_BACK),
    "there and back, fast": pad(2.0, THERE_AND_BACK),
    "in a square, fast": pad(2.0, SQUARE, loop=True),
}


@pytest.mark.parametrize("case", PADS)
def test_it_lands_on_a_moving_pad_and_is_carried(case: str) -> None:
    thing = PADS[case]
    with session_of(world_of(thing, start=Point(0, -3, 0))) as session:
        order, seen = meet(session, thing, 30.0)
        assert order.state == "done" and told(seen) == []
        touched = next(each for each in seen if not each.flying)
        assert seen[-1].time - touched.time < 0.8
        assert distance(on_pad(thing, touched), on_pad(thing, seen[-1])) < 0.3
        for later in wait(session, 30):
            assert not later.armed and later.position.z == pytest.approx(0.3, abs=0.005)
            if not at_a_corner(thing, later.time):  # there it is a physics step behind
                assert distance(on_pad(thing, later), on_pad(thing, seen[-1])) < 0.03
        vehicle = take_off(session, 1.0)
        assert vehicle.observe().flying


def test_what_stands_on_a_pad_from_the_start_keeps_its_place() -> None:
    thing = pad(2.0, ROUND, loop=True)
    with session_of(world_of(thing, start=Point(6.4, 0.3, 0.3))) as session:
        first, *later = wait(session, 40)
        assert max(distance(on_pad(thing, first), on_pad(thing, each)) for each in later) < 0.1
        assert told(later) == []


def test_what_rides_on_a_pad_is_held_up_by_what_it_hits() -> None:
    """The pad passes under a bar, which stops its rider."""
    bar = thing_of("bar", Cuboid(Point(0.2, 8, 1)), (6, 0, 0.85))
    world = world_of(pad(1.0, STRAIGHT), bar, start=Point(0, 0, 0.3))
    with session_of(world) as session:
        seen = wait(session, 15)
        assert told(seen) == [("collision", "bar")]
        # The pad has gone from under it.
        assert seen[-1].position.x < 6 and abs(seen[-1].position.z) < 0.01


@pytest.mark.parametrize("speed", [0.7, 2.0])
def test_what_a_pad_pushes_before_it_cannot_come_down_there(speed: float) -> None:
    thing = pad(speed, (Point(-12 * speed, 0, 0.15), Point(300, 0, 0.15)))
    with session_of(world_of(thing, start=Point(1, 0, 0))) as session:
        vehicle = take_off(session, HOVER)
        seen = wait(session, 16, Position(Point(1, 0, 0.15)))
        assert told(seen) == [("collision", "pad")]
        order = vehicle.land()
        wait_until(session, lambda: order.ended, 5)
        assert order.reason == "it does not stand on the pad"
        assert vehicle.observe().mode == "flying"


def test_what_has_capsized_stops_its_motors() -> None:
    """The pad runs into it, and it comes to lie on its back."""
    thing = pad(1.0, (Point(-13, 0, 0.15), Point(170, 0, 0.15)))
    with session_of(world_of(thing), physics="ideal") as session:
        vehicle = take_off(session, 2.5)
        place = Position(Point(10, 0, 2.5))
        wait(session, 19 - vehicle.observe().time, place)
        order = vehicle.land()
        wait_until(session, lambda: order.ended, 10)
        wait(session, 4)
        again = vehicle.land()
        wait_until(session, lambda: again.ended, 10)
        assert again.reason == "it has capsized on the pad"
        seen = wait(session, 5)[-1]
        assert seen.mode == "landed" and not seen.armed and not seen.flying
        assert seen.health == ("the vehicle does not stand upright",)


def test_beside_the_pad_it_lands_on_the_ground() -> None:
    """Before it touches the pad it knows nothing of it, and holds its place."""
    thing = pad(1.0, STRAIGHT)
    with session_of(world_of(thing, start=Point(0, -3, 0))) as session:
        vehicle: Vehicle = take_off(session, HOVER)
        wait(session, 8, Position(Point(5, 3, HOVER)))
        finish(session, vehicle.land(), 10)
        assert vehicle.observe().position == pytest.approx((5, 3, 0), abs=0.02)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("speed", [1.0, 2.0])
def test_it_stands_where_it_came_down_with_the_velocity_of_what_moves(
    engine: str, speed: float
) -> None:
    """Without a slip at the touch, and without a hit."""
    motion = Motion((Point(0.0, 4.0, 0.3), Point(200.0, 4.0, 0.3)), speed, False, False)
    pad = thing_of("pad", Cuboid(Point(1.2, 1.2, 0.3)), (0, 4, 0.15))
    pad = replace(pad, parts=(replace(pad.parts[0], at=Point(0, 0, -0.15)),), motion=motion)
    with session_of(world_of(pad), engine=engine) as session:
        vehicle = take_off(session, 2.0)

        def beside() -> Point:
            """The vehicle's place on the pad."""
            seen = vehicle.observe()
            return seen.position.minus(pose_at(pad, seen.time)[0])

        along = Point(speed, 0.0, 0.0)
        for _ in range(400):
            x, y, z = pose_at(pad, vehicle.observe().time + PERIOD)[0]
            vehicle.command(Position(Point(x, y, z + 0.4), along))
            session.wait()
        order, touched = vehicle.land(along), None
        while not order.ended:
            session.wait()
            assert not vehicle.observe().events
            touched = touched or (beside() if beside().z < 0.005 else None)
        assert order.state == "done" and touched is not None
        assert distance(touched[:2], (0, 0)) < 0.1
        assert distance(beside()[:2], touched[:2]) < 0.005
        wait(session, 5)
        assert distance(beside()[:2], touched[:2]) < 0.01 and abs(beside().z) < 0.005
