"""The engine behind the seam, and what a vehicle does in the world it makes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from math import cos, pi, sin
from pathlib import Path

import pytest

import hal.engines
from hal.sim import open_session
from hal.sim.physics import GRAVITY, STEP, Body, Physics, Triple
from hal.sim.vehicle import SimVehicle
from hal.vehicle import Options, Position, VehicleSpec, Velocity
from tests.hal.engines import ENGINES
from tests.hal.flying import LONG, finish, hovering, named, only, take_off, wait
from vencejo.errors import UserError, VehicleError
from vencejo.geometry import Point, Quaternion, distance, yaw_quaternion
from worlds import figures
from worlds.things import Thing
from worlds.world import Start

LEVEL = (0.0, 0.0, 0.0, 1.0)
ROOT = Path(__file__).parents[2]


@pytest.fixture(params=ENGINES)
def physics(request: pytest.FixtureRequest) -> Iterator[Physics]:
    engine = ENGINES[request.param]()
    yield engine
    engine.close()


def box(name: str, at: Point, size: Point, heading: float = 0.0) -> Thing:
    parts = figures.box(size, (0, 0, 0))
    return Thing(name, "box", at, yaw_quaternion(heading), parts)


def cube(name: str, x: float, y: float, z: float = 0.0) -> Thing:
    return box(name, Point(x, y, z), Point(1.0, 1.0, 1.0))


def body(physics: Physics, at: Triple, attitude: Quaternion = LEVEL) -> Body:
    return physics.add_body(2.0, (0.1, 0.2, 0.3), (0.4, 0.4, 0.2), at, attitude)


def carried(thing: Body) -> bool:
    """Whether something touches a body from below."""
    return any(touch.normal[2] > 0.5 for touch in thing.contacts())


# The engine.


def test_nothing_slows_a_free_body_down(physics: Physics) -> None:
    thing = body(physics, (0, 0, 1000.0))
    for _ in range(240):
        physics.step()
    (_, _, z), _, (_, _, speed), _ = thing.state()
    assert speed == pytest.approx(-GRAVITY, rel=1e-9)
    assert z == pytest.approx(1000 - GRAVITY / 2, abs=0.03)


def test_a_push_is_along_the_bodys_own_axes(physics: Physics) -> None:
    on_its_side = (sin(pi / 4), 0.0, 0.0, cos(pi / 4))  # rolled by 90°: its z points to −y
    thing = body(physics, (0, 0, 50.0), on_its_side)
    thing.push((0.0, 0.0, 3.0), (0.1, 0.2, 0.3))
    physics.step()
    _, _, velocity, turning = thing.state()
    assert velocity == pytest.approx((0, -1.5 * STEP, -GRAVITY * STEP), abs=1e-9)
    assert turning == pytest.approx((STEP, STEP, STEP), rel=1e-3)
    before = thing.state()
    physics.step()
    assert thing.state()[2][1] == pytest.approx(before[2][1]), "a push lasts for one step"


def test_every_box_of_many_is_solid(physics: Physics) -> None:
    boxes = [cube(f"b{k}", 3.0 * k, 0) for k in range(40)]
    physics.add_things(boxes)
    things = [body(physics, (each.at.x, 0, 1.4)) for each in boxes]
    for _ in range(240):
        physics.step()
    for thing in things:
        assert thing.state()[0][2] == pytest.approx(1.1, abs=0.002)
        assert carried(thing)


def test_boxes_stand_where_their_headings_turn_them(physics: Physics) -> None:
    physics.add_things([box("b", Point(2, 0, 1), Point(4, 1, 2), pi / 2)])
    down = [physics.ray((x, y, 9), (x, y, -1)) for x, y in ((2, 1.9), (3.9, 0), (2, -1.9))]
    assert [round(hit.z, 3) if hit else None for hit in down] == [3.0, 0.0, 3.0]


def test_a_ray_meets_the_ground_and_boxes_but_no_body(physics: Physics) -> None:
    physics.add_things([cube("b", 5, 0)])
    body(physics, (0, 0, 3.0))
    physics.step()
    assert physics.ray((0, 0, 5), (0, 0, -5)) == pytest.approx((0, 0, 0), abs=1e-6)
    assert physics.ray((0, 0, 3), (0, 0, -5)) == pytest.approx((0, 0, 0), abs=1e-6)
    assert physics.ray((0, 0, 0.5), (9, 0, 0.5)) == pytest.approx((4.5, 0, 0.5), abs=1e-6)
    assert physics.ray((0, 0, 5), (9, 0, 5)) is None


def test_a_wall_beside_it_supports_nothing(physics: Physics) -> None:
    physics.add_things([cube("b", 0.6999, 0, 5)])
    thing = body(physics, (0, 0, 5.5))
    assert not carried(thing)
    for _ in range(5):
        thing.push((0.0, 0.0, 2 * GRAVITY), (0, 0, 0))
        physics.step()
    assert not carried(thing)


def test_simulations_do_not_know_each_other(physics: Physics) -> None:
    other = type(physics)()
    one, two = body(physics, (0, 0, 10.0)), body(other, (0, 0, 10.0))
    physics.step()
    assert one.state() != two.state() == ((0, 0, 10), LEVEL, (0, 0, 0), (0, 0, 0))
    other.close()
    physics.step()
    assert one.state()[2][2] == pytest.approx(-2 * GRAVITY * STEP)


def test_closing_twice_is_closing_once(physics: Physics) -> None:
    physics.close()
    physics.close()


@pytest.mark.parametrize("engine", ENGINES)
def test_the_engine_is_loaded_late_and_says_nothing(engine: str, tmp_path: Path) -> None:
    package = hal.engines.ENGINES[engine].package
    program = (
        "import sys, hal.sim as sim; from hal.vehicle import Options\n"
        "assert not {'pybullet', 'mujoco'} & set(sys.modules)\n"
        f"sim.open_session(Options(settings={{'engine': {engine!r}}})).wait()\n"
        f"assert {{'pybullet', 'mujoco'}} & set(sys.modules) == {{{package!r}}}; print('ours')"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "ours\n", "")
    assert not list(tmp_path.iterdir()), "it keeps no log of its own"


@pytest.fixture
def absent(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Makes a package one that is not installed."""

    def remove(package: str) -> None:
        monkeypatch.setitem(sys.modules, package, None)

    return remove


@pytest.mark.parametrize(
    ("engine", "package", "hint"),
    [
        ("bullet", "pybullet", 'pip install "vencejo[bullet]"'),
        ("mujoco", "mujoco", 'pip install "vencejo[mujoco]"'),
    ],
)
def test_without_the_engine_it_says_what_to_install(
    engine: str, package: str, hint: str, absent: Callable[[str], None]
) -> None:
    absent(package)
    with pytest.raises(VehicleError, match="not installed") as caught:
        open_session(Options(settings={"engine": engine}))
    assert (caught.value.exit_code, caught.value.code) == (3, "no-physics")
    assert hint in str(caught.value)


def test_without_pybullet_it_is_mujoco(absent: Callable[[str], None]) -> None:
    absent("pybullet")
    with open_session(Options()) as session:
        assert session.engine.startswith("mujoco ")
        assert session.settings["engine"] == "mujoco"
    absent("mujoco")
    with pytest.raises(VehicleError, match="MuJoCo"):
        open_session(Options())


# A session.


@pytest.mark.parametrize("engine", ENGINES)
def test_the_engine_has_a_version(engine: str) -> None:
    with open_session(Options(settings={"engine": engine})) as session:
        name, number = session.engine.split()
        assert name == hal.engines.ENGINES[engine].package and number[0].isdigit()
        assert session.settings["engine"] == engine


def test_a_closed_session_advances_no_more() -> None:
    with open_session(Options()) as session:
        session.wait()
    with pytest.raises(VehicleError, match="closed"):
        session.wait()


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (Options(settings={"nois": 1}), "unknown-setting"),
        (Options(settings={"engine": "mujcoo"}), "unknown-engine"),
        (Options(settings={"engine": 2}), "unknown-engine"),
        (Options(settings={"noise": "loud"}), "bad-setting"),
        (Options(settings={"noise": -1}), "bad-setting"),
        (Options(settings={"shadows": "no"}), "bad-setting"),
        (Options(settings={"wind": 5}), "bad-setting"),
        (Options(settings={"wind": "5 m/s"}), "wrong-type"),
        (Options(settings={"wind": "5 m/s@270 deg,gusts=3 m/s"}), "bad-gusts"),
        (Options(settings={"noise": float("inf")}), "bad-setting"),
        (Options(world="yrad"), "unknown-world"),
        (Options(address="udp:14540"), "no-address"),
        (Options(vehicles=()), "bad-vehicles"),
        (Options(vehicles=named("a", "a")), "bad-vehicles"),
    ],
)
def test_what_cannot_be_opened_is_refused(options: Options, code: str) -> None:
    with pytest.raises(UserError) as caught:
        open_session(options)
    assert (caught.value.code, caught.value.exit_code) == (code, 2)


def test_no_vehicle_starts_in_a_box(tmp_path: Path) -> None:
    file = tmp_path / "tight.yaml"
    file.write_text("world: tight\nboxes: {hut: {at: [4, 1], size: [1, 2, 3]}}\n")
    open_session(Options(named("a", "b"), world=str(file))).__exit__()
    with pytest.raises(UserError, match="'c' would start in the box 'hut'") as caught:
        open_session(Options(named("a", "b", "c"), world=str(file)))
    assert caught.value.code == "start-in-thing"


def test_the_world_gives_start_battery_and_places(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(
        "world: mine\nbattery: 40 %\nplaces: {gate: [1, 2, 3]}\n"
        "start: [{at: [4, 5], heading: 90 deg}, {at: [7, 5]}]\n"
    )
    with open_session(Options(world=str(file), vehicles=named("cat", "mouse", "dog"))) as session:
        session.wait()
        seen = {name: vehicle.observe() for name, vehicle in session.vehicles.items()}
        assert [seen[name].home for name in ("cat", "mouse", "dog")] == [
            (4, 5, 0),
            (7, 5, 0),
            (9, 5, 0),
        ]
        assert seen["cat"].yaw == pytest.approx(pi / 2, abs=1e-4)
        assert {round(each.battery, 4) for each in seen.values()} == {0.4}
        assert session.places == {"gate": (1, 2, 3)}


def test_a_vehicle_may_have_a_start_of_its_own() -> None:
    own = VehicleSpec("mouse", start=Start(Point(5.0, 6.0, 0.0), pi / 2))
    with open_session(Options((VehicleSpec("cat"), own, VehicleSpec("dog")))) as session:
        session.wait()
        seen = [vehicle.observe() for vehicle in session.vehicles.values()]
    assert [each.home for each in seen] == [(0, 0, 0), (5, 6, 0), (2, 0, 0)]
    assert [each.yaw for each in seen] == pytest.approx([0, pi / 2, 0], abs=1e-4)


def test_a_start_that_is_taken_is_given_to_nobody_else() -> None:
    taken = VehicleSpec("mouse", start=Start(Point(2.3, 0.0, 0.0), 0.0))
    with open_session(Options((VehicleSpec("cat"), VehicleSpec("dog"), taken))) as session:
        session.wait()
        seen = [vehicle.observe() for vehicle in session.vehicles.values()]
    assert [each.home for each in seen] == [(0, 0, 0), (4, 0, 0), (2.3, 0, 0)]


@pytest.mark.parametrize(
    ("places", "code"),
    [
        ([Point(0.0, 0.0, 0.0), Point(0.0, 0.5, 0.0)], "starts-overlap"),
        ([Point(9.0, 0.0, -1.0)], "start-in-ground"),
    ],
)
def test_starts_where_nothing_can_stand_are_refused(places: list[Point], code: str) -> None:
    vehicles = [VehicleSpec(f"v{n}", start=Start(at, 0.0)) for n, at in enumerate(places)]
    with pytest.raises(UserError) as caught:
        open_session(Options(tuple(vehicles)))
    assert [fault.code for fault in caught.value.faults] == [code]


def test_two_may_start_one_above_the_other() -> None:
    low, high = (VehicleSpec(n, start=Start(Point(0, 0, z), 0)) for n, z in (("a", 0), ("b", 2)))
    open_session(Options((low, high))).__exit__()


def test_the_world_may_say_where_on_the_earth_it_is(tmp_path: Path) -> None:
    nowhere = tmp_path / "nowhere.yaml"
    nowhere.write_text("world: nowhere\n")
    with open_session(Options(world="yard")) as session:
        assert session.geographic == (40.4168, -3.7038, 667.0)
    with open_session(Options(world=str(nowhere))) as session:
        assert session.geographic is None


def test_vehicles_fly_side_by_side() -> None:
    with open_session(Options(vehicles=named("cat", "mouse"))) as session:
        cat, mouse = session.vehicles["cat"], session.vehicles["mouse"]
        mouse.takeoff(2)
        wait(session, 4)
        assert cat.observe().position == pytest.approx((0, 0, 0), abs=0.002)
        assert mouse.observe().position == pytest.approx((2, 0, 2), abs=0.01)
        assert cat.observe().time == mouse.observe().time


# Touching things.


def test_lands_on_a_box() -> None:
    with hovering(Point(3.0, -4.0, 4.0), world="yard") as (session, vehicle):
        finish(session, vehicle.land(), 12)
        assert vehicle.observe().position == pytest.approx((3, -4, 0.8), abs=0.01)
        assert not vehicle.observe().flying
        order = vehicle.takeoff(1.5)
        finish(session, order, 6)
        assert vehicle.observe().position.z == pytest.approx(2.3, abs=0.06)


def test_touches_down_softly() -> None:
    with hovering(Point(0.0, 0.0, 8.0)) as (session, vehicle):
        order, sinking = vehicle.land(), 0.0
        while not order.ended:
            before = vehicle.observe()
            session.wait()
            if not vehicle.observe().flying and before.flying:
                sinking = -before.velocity.z
        assert 0.25 < sinking < 0.35
        assert vehicle.observe().time < 20


def test_a_wall_stops_it() -> None:
    with hovering(Point(0.0, 9.0, 1.2), world="yard") as (session, vehicle):
        vehicle.command(Velocity(y=1.0), LONG)
        seen = wait(session, 6)[-1]
        assert seen.position.y < 12 - 0.15 - 0.2
        assert seen.mode == "flying"


def test_a_vehicle_on_its_side_does_not_fly() -> None:
    with open_session(Options()) as session:
        vehicle = only(session)
        assert isinstance(vehicle, SimVehicle)
        position, _, velocity, turning = vehicle._state
        vehicle._state = (position, (sin(pi / 4), 0.0, 0.0, cos(pi / 4)), velocity, turning)
        orders = vehicle.arm(), vehicle.takeoff(1)
        session.wait()
        for order in orders:
            assert (order.state, order.reason) == ("refused", "the vehicle does not stand upright")


def test_return_home_over_a_box_flies_high() -> None:
    with open_session(Options(world="yard")) as session:
        vehicle = take_off(session, 1.0)
        vehicle.command(Position(Point(0.0, 8.0, 1.0)), LONG)
        wait(session, 6)
        vehicle.command(Velocity(x=2.0), LONG)
        wait(session, 1)
        order = vehicle.return_home()
        highest = max(seen.position.z for seen in wait(session, 6))
        assert highest == pytest.approx(5.0, abs=0.1)
        finish(session, order, 20)
        assert distance(only(session).observe().position, (0, 0, 0)) < 0.05


def test_a_set_point_that_is_no_number_is_our_mistake() -> None:
    with hovering() as (session, vehicle):
        for setpoint in (
            Velocity(x=float("nan")),
            Position(Point(0.0, float("inf"), 1.0)),
            Position(Point(0.0, 0.0, 1.0), yaw=float("nan")),
        ):
            with pytest.raises(ValueError, match="finite"):
                vehicle.command(setpoint)
        assert distance(wait(session, 1)[-1].position, (0, 0, 5)) < 0.001


def test_yaw_quaternion_is_what_the_engine_means(physics: Physics) -> None:
    thing = body(physics, (0, 0, 5), yaw_quaternion(0.7))
    assert thing.state()[1] == pytest.approx(yaw_quaternion(0.7))
