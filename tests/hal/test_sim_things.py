"""Things in the engine: every one is solid, known by its name, and carries what stands on it."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, dist, inf, pi, sin
from pathlib import Path
from random import Random

import pytest

from hal.scene.surfaces import terrain_surface
from hal.sim import open_session
from hal.sim.contact_debouncer import ContactDebouncer
from hal.sim.obstacle_heights import ObstacleHeightGrid
from hal.sim.physics import GRAVITY, STEP, Body, Physics, Triple
from hal.vehicle import Options, Position, VehicleEvent, Velocity
from tests.hal.engines import ENGINES, mover_pose
from tests.hal.flying import LONG, finish, hovering, named, only, take_off, wait
from vencejo.geometry import Point, distance, yaw_of
from worlds import figures
from worlds.loader import read_world
from worlds.motion import pose_at
from worlds.solids import bounds_of
from worlds.terrain import height_at
from worlds.things import UPRIGHT, Cuboid, Cylinder, Motion, Part, Shape, Sphere, Terrain, Thing

GRAY = (128, 128, 128)
KEEP_AWAY = "world: w\nstart: {at: [90, 90]}\n"


@pytest.fixture(params=ENGINES)
def physics(request: pytest.FixtureRequest) -> Iterator[Physics]:
    engine = ENGINES[request.param]()
    yield engine
    engine.close()


def things(text: str) -> tuple[Thing, ...]:
    return read_world(KEEP_AWAY + text, "w.yaml").things


def box(name: str, at: Point, height: float = 1.0) -> Thing:
    return Thing(name, "box", at, UPRIGHT, figures.box(Point(1, 1, height), GRAY))


def drone(physics: Physics, at: Triple, name: str = "") -> Body:
    return physics.add_body(0.436, (2e-3, 3e-3, 5e-3), (0.5, 0.5, 0.12), at, UPRIGHT, name)


def run(physics: Physics, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        physics.step()


# What is hit.


@pytest.mark.parametrize("count", [1, 16, 17, 33, 200])
def test_every_box_is_hit_and_known(physics: Physics, count: int) -> None:
    boxes = [box(f"b{k}", Point(3.0 * (k % 20), 3.0 * (k // 20), 0)) for k in range(count)]
    physics.add_things(boxes)
    starts = [(each.at.x, each.at.y, 5.0) for each in boxes]
    hits = physics.rays(starts, [(x, y, -1.0) for x, y, _ in starts])
    assert hits.distances == pytest.approx([4.0] * count, abs=1e-6)
    assert [hits.name(ray) for ray in range(count)] == [each.name for each in boxes]
    last = boxes[-1].at
    falling = drone(physics, (last.x, last.y, 1.4))
    run(physics, 1)
    assert falling.state()[0][2] == pytest.approx(1.06, abs=0.002)


def test_a_touch_has_the_name_of_the_thing(physics: Physics) -> None:
    boxes = [box(f"b{k}", Point(3.0 * k, 0, 0), 3.0) for k in range(40)]
    physics.add_things(boxes)
    body = drone(physics, (3.0 * 16 - 0.749, 0, 1))
    physics.step()
    touches = body.contacts()
    assert [(each.name, each.normal, each.free) for each in touches] == [
        ("b16", pytest.approx((-1, 0, 0), abs=1e-6), False)
    ] * 4
    assert [each.place[0] for each in touches] == pytest.approx([3.0 * 16 - 0.5] * 4, abs=0.001)


def test_the_ground_has_no_name(physics: Physics) -> None:
    body = drone(physics, (0, 0, 0.06))
    physics.step()
    touches = body.contacts()
    assert touches and {(each.name, each.normal, each.velocity) for each in touches} == {
        ("", (0, 0, 1), (0, 0, 0))
    }
    hits = physics.rays([(5, 5, 2), (5, 5, 2)], [(5, 5, -1), (9, 9, 2)])
    assert list(hits.distances) == [pytest.approx(2), inf]
    assert (hits.name(0), hits.name(1)) == ("", None)


def test_vehicles_feel_each_other_by_name(physics: Physics) -> None:
    one, other = drone(physics, (0, 0, 5), "cat"), drone(physics, (0.499, 0, 5), "mouse")
    physics.step()
    assert {(each.name, each.free) for each in one.contacts()} == {("mouse", True)}
    assert {(each.name, each.free) for each in other.contacts()} == {("cat", True)}


SHAPES = (Cuboid(Point(2, 1, 3)), Cylinder(0.6, 3.0), Sphere(1.2))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
def test_shapes_are_solid_in_any_pose(physics: Physics, shape: Shape) -> None:
    random = Random(3)
    parts = []
    for k in range(18):
        q = [random.gauss(0, 1) for _ in range(4)]
        norm = dist(q, (0, 0, 0, 0))
        attitude = (q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm)
        parts.append(Part(shape, Point(6.0 * k, 0, 5), attitude, GRAY))
    physics.add_things(
        [Thing(f"t{k}", "x", Point(0, 0, 0), UPRIGHT, (part,)) for k, part in enumerate(parts)]
    )
    for k, part in enumerate(parts):
        low, high = bounds_of(part.shape, part.at, part.attitude)
        # Rays down on a fine grid meet its highest point, and nothing beside its bounds.
        grid = [
            (low.x + (high.x - low.x) * i / 40, low.y + (high.y - low.y) * j / 40)
            for i in range(41)
            for j in range(41)
        ]
        hits = physics.rays([(x, y, 12) for x, y in grid], [(x, y, 0.1) for x, y in grid])
        nearest = min(range(len(grid)), key=lambda ray: hits.distances[ray])
        assert 12 - hits.distances[nearest] == pytest.approx(high.z, abs=0.1)
        assert hits.name(nearest) == f"t{k}"


def test_markers_and_beacons_are_no_obstacles(physics: Physics) -> None:
    physics.add_things(
        things("markers: {m: {at: [0, 0, 2], id: 1, size: 1}}\nbeacons: {b: {at: [0, 0, 3]}}")
    )
    assert physics.rays([(0, 0, 5)], [(0, 0, 0.1)]).distances == [inf]


def test_a_mesh_is_solid_as_it_is(physics: Physics, tmp_path: Path) -> None:
    # A roof: a prism whose ridge runs along y at a height of 1 m.
    (tmp_path / "roof.obj").write_text(
        "v -1 -2 0\nv 1 -2 0\nv 0 -2 1\nv -1 2 0\nv 1 2 0\nv 0 2 1\n"
        "f 1 2 3\nf 6 5 4\nf 2 5 6 3\nf 4 1 3 6\nf 1 4 5 2\n"
    )
    (mesh,) = read_world(
        KEEP_AWAY + "meshes: {roof: {at: [3, 0, 1], file: roof.obj, heading: 90 deg}}",
        str(tmp_path / "w.yaml"),
    ).things
    physics.add_things([mesh])
    spots = [(3, 0), (3, 0.5), (4.9, 0), (3, 1.1)]
    hits = physics.rays([(x, y, 5) for x, y in spots], [(x, y, -1) for x, y in spots])
    assert [5 - d for d in hits.distances] == pytest.approx([2, 1.5, 2, 0], abs=1e-3)
    assert [hits.name(k) for k in range(4)] == ["roof", "roof", "roof", ""]


def test_a_model_is_solid_as_it_looks(physics: Physics, tmp_path: Path) -> None:
    (tmp_path / "lamp.urdf").write_text(
        '<robot name="lamp"><link name="foot"><visual><geometry>'
        '<cylinder radius="0.5" length="2"/></geometry></visual></link>'
        '<joint name="j" type="fixed"><parent link="foot"/><child link="arm"/>'
        '<origin xyz="0 0 2"/></joint><link name="arm"><visual><geometry>'
        '<box size="3 0.2 0.2"/></geometry></visual></link></robot>'
    )
    (lamp,) = read_world(
        KEEP_AWAY + "models: {lamp: {at: [5, 0, 1], file: lamp.urdf, heading: 90 deg}}",
        str(tmp_path / "w.yaml"),
    ).things
    physics.add_things([lamp])
    spots = [(5.3, 0), (5, 1.4), (6.4, 0)]
    hits = physics.rays([(x, y, 9) for x, y in spots], [(x, y, -1) for x, y in spots])
    assert [9 - d for d in hits.distances] == pytest.approx([2, 3.1, 0], abs=1e-6)
    assert [hits.name(ray) for ray in range(3)] == ["lamp", "lamp", ""]


def test_hills_are_ground(physics: Physics) -> None:
    heights = ((0.0,) * 4, (0.0, 1.0, 3.0, 0.0), (0.0, 0.0, 2.0, 0.0), (0.0,) * 4)
    physics.add_things([], Terrain(heights, 30.0))
    spots = [(-5, -5), (5, -5), (5, 5), (-5, 5), (0, -5), (14, 14), (20, 0)]
    hits = physics.rays([(x, y, 9) for x, y in spots], [(x, y, -1) for x, y in spots])
    assert [9 - d for d in hits.distances] == pytest.approx([1, 3, 2, 0, 2, 0, 0], abs=1e-3)
    assert {hits.name(ray) for ray in range(len(spots))} == {""}
    body = drone(physics, (5, -5, 3.3))
    run(physics, 0.3)
    assert any(each.normal[2] > 0.5 for each in body.contacts())


def test_hills_are_as_high_in_physics_pictures_and_for_what_stands_on_them(
    physics: Physics,
) -> None:
    draw = Random(5)
    inner = range(1, 5)
    rows = [[draw.uniform(0, 4) if {i, j} <= {*inner} else 0.0 for j in range(6)] for i in range(6)]
    terrain = Terrain(tuple(map(tuple, rows)), 20.0)
    physics.add_things([], terrain)
    surface = terrain_surface(terrain, GRAY)
    middles = [surface.vertices[list(face.corners)].mean(0) for face in surface.faces]
    for x, y, z in middles:
        (hit,) = physics.rays([(x, y, 9)], [(x, y, -1)]).distances
        assert (height_at(terrain, x, y), 9 - hit) == pytest.approx((z, z), abs=1e-5)


# What moves.

SQUARE = (Point(0, 0, 1), Point(6, 0, 1), Point(6, 6, 2), Point(0, 6, 1))


def pad(speed: float, points: tuple[Point, ...] = SQUARE, turns: bool = True) -> Thing:
    motion = Motion(points, speed, True, turns)
    return Thing(
        "pad", "box", points[0], UPRIGHT, figures.box(Point(2, 2, 0.2), GRAY), True, motion
    )


@pytest.mark.slow
def test_a_mover_is_on_its_path_after_ten_minutes(physics: Physics) -> None:
    _on_path(physics, 600)


def test_a_mover_is_on_its_path(physics: Physics) -> None:
    _on_path(physics, 20)


def _on_path(physics: Physics, seconds: float) -> None:
    moving = pad(1.7)
    physics.add_things([moving])
    drone(physics, (0, 0, 1.3))
    run(physics, seconds)
    at, attitude = mover_pose(physics)
    there, heading = pose_at(moving, seconds)
    assert at == pytest.approx(there, abs=1e-6)
    assert yaw_of(attitude) == pytest.approx(yaw_of(heading), abs=1e-6)


@pytest.mark.parametrize("smooth_corner", [True, False])
def test_a_mover_is_where_pictures_show_it_at_every_step(
    physics: Physics, smooth_corner: bool
) -> None:
    """Cameras of 30 Hz look between mission periods; corners and curves differ most there."""
    corners = tuple(Point(3 * cos(k), 3 * sin(k), 1) for k in range(6)) if smooth_corner else SQUARE
    moving = pad(9.0, corners)
    physics.add_things([moving])
    for steps in range(1, 600):
        physics.step()
        at, attitude = mover_pose(physics)
        there, heading = pose_at(moving, steps * STEP)
        assert at == pytest.approx(there, abs=1e-6)
        assert yaw_of(attitude) == pytest.approx(yaw_of(heading), abs=1e-6)


def test_what_stands_on_a_moving_pad_is_carried(physics: Physics) -> None:
    points = (Point(0, 0, 1), Point(40, 0, 1))
    moving = pad(0.5, points, turns=False)
    physics.add_things([moving])
    body = drone(physics, (0, 0, 1.26))
    run(physics, 30)
    (x, y, z), attitude, velocity, _ = body.state()
    there, _ = pose_at(moving, 30)
    # It slides a little before it has the pad's speed.
    assert (x, y, z) == pytest.approx((there.x, 0, 1.26), abs=0.03)
    assert velocity == pytest.approx((0.5, 0, 0), abs=1e-3)
    touches = body.contacts()
    assert {each.name for each in touches} == {"pad"}
    for each in touches:
        assert each.velocity == pytest.approx((0.5, 0, 0), abs=1e-6)
        assert each.normal == pytest.approx((0, 0, 1), abs=1e-6)
    assert yaw_of(attitude) == pytest.approx(0, abs=0.01)


def test_a_turning_pad_turns_what_stands_on_it(physics: Physics) -> None:
    round_way = tuple(Point(4 * cos(k * pi / 30), 4 * sin(k * pi / 30), 1) for k in range(60))
    moving = pad(0.8, round_way)
    physics.add_things([moving])
    at, heading = pose_at(moving, 0)
    body = physics.add_body(
        0.436, (2e-3, 3e-3, 5e-3), (0.5, 0.5, 0.12), (at.x, at.y, 1.26), heading
    )
    run(physics, 31.4)
    there, now = pose_at(moving, 31.4)
    (x, y, _), attitude, _, _ = body.state()
    assert dist((x, y), there[:2]) < 0.1
    assert yaw_of(attitude) == pytest.approx(yaw_of(now), abs=0.1)


def test_a_mover_is_met_by_rays_and_bodies(physics: Physics) -> None:
    moving = pad(1.0, (Point(0, 0, 1), Point(10, 0, 1)), turns=False)
    physics.add_things([moving])
    body = drone(physics, (5, 0, 1.1), "d")
    felt = set()
    for _ in range(round(4 / STEP)):
        body.push((0.0, 0.0, 0.436 * GRAVITY), (0, 0, 0))
        physics.step()
        felt |= {each.name for each in body.contacts()}
    assert felt == {"pad"}
    assert body.state()[0][0] > 5.0, "it was pushed"
    hits = physics.rays([(4, 0, 5)], [(4, 0, 0)])
    assert (hits.distances[0], hits.name(0)) == (pytest.approx(3.8, abs=1e-6), "pad")


# Obstacle heights and contact debouncing.


def test_obstacle_heights_miss_nothing_that_can_be_touched() -> None:
    random = Random(5)
    text = "boxes:\n" + "".join(
        f"  b{k}: {{at: [{random.uniform(-30, 30):.1f}, {random.uniform(-30, 30):.1f}],"
        f" size: [{random.uniform(0.2, 9):.1f}, 1, {random.uniform(0.2, 5):.1f}],"
        f" heading: {random.uniform(0, 3):.1f}}}\n"
        for k in range(60)
    )
    solid = things(text)
    obstacles = ObstacleHeightGrid(solid, None, 0.45)
    free = 0
    for _ in range(800):
        place = Point(random.uniform(-35, 35), random.uniform(-35, 35), random.uniform(0, 7))
        if not obstacles.thing_near(*place):
            free += 1
            for thing in solid:
                low, high = bounds_of(thing.parts[0].shape, thing.at, thing.attitude)
                aside = max(low.x - place.x, place.x - high.x, low.y - place.y, place.y - high.y)
                assert aside > 0.5 or place.z > thing.at.z + thing.parts[0].at.z * 2 + 0.5
    assert free > 200


def test_obstacle_heights_follow_what_moves() -> None:
    obstacles = ObstacleHeightGrid([pad(1.0)], None, 0.45)
    assert obstacles.thing_near(6, 3, 2.4) and obstacles.thing_near(0, 0, 1.5)
    assert not obstacles.thing_near(6, 3, 3.0) and not obstacles.thing_near(30, 3, 1.0)


def test_what_is_very_long_counts_everywhere() -> None:
    wall = things("walls: {w: {through: [[0, 0], [900, 0]], height: 3}}")
    hut = things("boxes: {b: {at: [5, 5], size: [1, 1, 1]}}")
    for order in ((*wall, *hut), (*hut, *wall)):
        obstacles = ObstacleHeightGrid(order, None, 0.45)
        assert obstacles.thing_near(5, 5, 3.5) and obstacles.thing_near(-700, 3, 3.5)
        assert not obstacles.thing_near(5, 5, 3.7)


def test_the_ground_ends_above_what_it_is_below() -> None:
    flat = ObstacleHeightGrid([], None, 0.45)
    assert flat.ground_near(3, 3, 0.59) and not flat.ground_near(3, 3, 0.61)
    hill = ObstacleHeightGrid([], Terrain(((0.0, 0, 0), (0, 4, 0), (0, 0, 0)), 40.0), 0.45)
    assert hill.ground_near(0, 0, 4.5) and not hill.ground_near(0, 0, 4.61)
    assert hill.ground_near(-19, 0, 0.7) and not hill.ground_near(-19, 0, 2.0)


def test_a_touch_is_new_once_until_it_is_over() -> None:
    debouncer = ContactDebouncer()
    seen = []
    for period in range(100):
        if period in (3, 4, 10, 60) or 20 < period < 30:
            debouncer.add("wall", True)
            debouncer.add("wall", False)
        if period == 60:
            debouncer.add("tree", True)
        debouncer.end_period()
        seen += [(period, name) for name in debouncer.new]
    assert seen == [(3, "wall"), (60, "wall"), (60, "tree")]


def test_what_a_vehicle_stands_on_is_hit_only_after_it_has_left() -> None:
    debouncer = ContactDebouncer()
    seen = []
    for period in range(100):
        if period < 10 or period in (20, 50):
            debouncer.add("table", hit=period >= 20)
        debouncer.end_period()
        seen += [(period, name) for name in debouncer.new]
    assert seen == [(50, "table")]


# A flight.


def test_a_collision_is_told_once_with_its_name() -> None:
    with hovering(Point(0.0, 9.0, 1.2), world="yard") as (session, vehicle):
        vehicle.command(Velocity(y=1.0), LONG)
        told = [seen.events for seen in wait(session, 6) if seen.events]
        assert told == [(VehicleEvent("vehicle.collision", {"thing": "wall"}),)]
        vehicle.command(Position(Point(0.0, 9.0, 1.2)), LONG)
        wait(session, 3)
        vehicle.command(Velocity(y=1.0), LONG)
        assert [seen.events for seen in wait(session, 6) if seen.events] == told


def test_standing_on_something_is_no_collision() -> None:
    with hovering(Point(3.0, -4.0, 2.0), world="yard") as (session, vehicle):
        order = vehicle.land()
        while not order.ended:
            session.wait()
            assert vehicle.observe().events == ()


def test_vehicles_collide_by_name() -> None:
    with open_session(Options(vehicles=named("cat", "mouse"))) as session:
        cat, mouse = session.vehicles["cat"], session.vehicles["mouse"]
        cat.takeoff(2)
        mouse.takeoff(2)
        wait(session, 4)
        cat.command(Velocity(x=0.5), LONG)
        touched: dict[str, list[str]] = {"cat": [], "mouse": []}
        for _ in range(160):
            session.wait()
            for name, vehicle in session.vehicles.items():
                touched[name] += [event.fields["thing"] for event in vehicle.observe().events]
        assert touched["cat"][:1] == ["mouse"] and touched["mouse"][:1] == ["cat"]


def test_a_vehicle_takes_off_from_a_moving_pad_and_lands_on_it(tmp_path: Path) -> None:
    file = tmp_path / "pad.yaml"
    file.write_text(
        "world: pad\nstart: {at: [0, 0, 0.3]}\n"
        "boxes: {pad: {size: [3, 3, 0.3], moves: {through: [[0, 0], [60, 0]], speed: 20 cm/s}}}\n"
    )
    with open_session(Options(world=str(file))) as session:
        vehicle = only(session)
        wait(session, 5)
        assert vehicle.observe().position == pytest.approx((1, 0, 0.3), abs=0.02)
        take_off(session, 2.0)
        vehicle.command(Velocity(x=0.2), LONG)
        wait(session, 2)
        finish(session, vehicle.land(), 15)
        landed = vehicle.observe()
        assert not landed.armed and landed.position.z == pytest.approx(0.3, abs=0.03)
        wait(session, 10)
        later = vehicle.observe()
        assert later.position.z == pytest.approx(0.3, abs=0.002)
        assert distance(later.position, landed.position) == pytest.approx(2.0, abs=0.05)
