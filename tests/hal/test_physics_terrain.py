"""Terrain is solid, in every engine: nothing sinks into it, and nothing falls through."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import dist, radians, tan
from pathlib import Path
from random import Random
from typing import NamedTuple

import pytest

from hal.sim import open_session
from hal.sim.physics import STEP, BodyState, Triple
from hal.vehicle import Options, Position
from tests.hal.engines import ENGINES, SIZE, run, simulation, vehicle
from tests.hal.flying import LONG, finish, named, only, take_off, wait
from vencejo.geometry import Point, Quaternion, about_x, turned, yaw_quaternion
from vencejo.geometry import product as rotation
from worlds.terrain import height_at, highest_under
from worlds.things import Terrain

CELLS = (1.0, 2.0, 5.0, 10.0)
SLOPES = (5, 10, 15, 20, 25, 30, 35, 40, 45)
"""Degrees."""
PLACES = ("face", "face", "edge", "edge", "tip", "tip", "crest", "crest", "top", "foot")
"""Where on the terrain: anywhere, on an edge or at a corner of cells, on a diagonal, …"""
LEVEL = yaw_quaternion(0.3)
_COUNT = 9
"""Heights along a side."""
_SHARES = [k / 8 - 0.5 for k in range(9)]


class Fall(NamedTuple):
    """A body that begins above a place of a terrain, and what became of it."""

    lowest: float
    """Least height of its centre above the ground straight below, metres."""
    deepest: float
    """Greatest depth of its surface below the ground when it had come to rest, metres."""
    speed: float
    """In the end, m/s."""


def pyramid(cell: float, slope: float) -> Terrain:
    """Four slopes; their ridges are diagonals of cells, two along and two across the triangles."""
    rise, last = tan(radians(slope)) * cell, _COUNT - 1
    indices = range(_COUNT)
    return Terrain(
        tuple(tuple(rise * min(i, j, last - i, last - j) for j in indices) for i in indices),
        cell * last,
    )


def rough(cell: float, slope: float, draw: Random) -> Terrain:
    """Peaks, ridges, saddles and pits, up to the slope along the sides of cells."""
    rise, inner = tan(radians(slope)) * cell, range(1, _COUNT - 1)
    indices = range(_COUNT)
    return Terrain(
        tuple(
            tuple(draw.uniform(0, rise) if i in inner and j in inner else 0.0 for j in indices)
            for i in indices
        ),
        cell * (_COUNT - 1),
    )


def place_on(terrain: Terrain, kind: str, draw: Random) -> tuple[float, float]:
    cell = terrain.size / (_COUNT - 1)
    reach = terrain.size / 2 - cell
    x, y = draw.uniform(-reach, reach), draw.uniform(-reach, reach)
    if kind in ("edge", "tip"):
        x = round(x / cell) * cell + (draw.choice((0.0, 0.125, -0.2)) if kind == "edge" else 0.0)
    if kind == "tip":
        y = round(y / cell) * cell
    if kind == "crest":
        y = x * draw.choice((1, -1))
    if kind == "top":
        x = y = 0.0
    if kind == "foot":
        x = -terrain.size / 2
    return x, y


def surface_depth(terrain: Terrain, state: BodyState, size: Triple = SIZE) -> float:
    """How deep the deepest of many points on a body's surface lies below the ground, metres."""
    at, attitude = Point(*state[0]), state[1]
    points = (
        at.plus(turned((a * size[0], b * size[1], c * size[2]), attitude))
        for a, b, c in product(_SHARES, _SHARES, (-0.5, 0.5))
    )
    return max(height_at(terrain, x, y) - z for x, y, z in points)


def fall(
    engine: str,
    terrain: Terrain,
    place: tuple[float, float],
    drop: float = 0.0,
    attitude: Quaternion = LEVEL,
    seconds: float = 3.0,
) -> Fall:
    """Let a vehicle go above a place, clear of all ground, and watch it."""
    x, y = place
    ground = highest_under(terrain, Point(x, y, 0.0), 0.3, SIZE)
    with simulation(engine, terrain=terrain) as physics:
        body = vehicle(physics, (x, y, ground + SIZE[2] / 2 + drop), attitude)
        lowest = 9.0
        for _ in range(round(seconds / STEP)):
            physics.step()
            (x, y, z), *_ = body.state()
            lowest = min(lowest, z - height_at(terrain, x, y))
        speed = dist(body.state()[2], (0, 0, 0))
        return Fall(lowest, surface_depth(terrain, body.state()), speed)


def grid(
    places: tuple[str, ...], slopes: tuple[int, ...]
) -> Iterator[tuple[str, Terrain, tuple[float, float]]]:
    """Places on pyramids and on rough ground, for every cell size and slope."""
    draw = Random(4)
    for number, (cell, slope, kind) in enumerate(product(CELLS, slopes, places)):
        even = pyramid(cell, slope) if number % 3 else rough(cell, slope, draw)
        yield f"{kind} of {cell:g} m, {slope}°", even, place_on(even, kind, draw)


DEEPEST = {"bullet": 0.004, "mujoco": 0.006}
"""How deep in the ground a corner may lie at rest, metres."""


def check_solid(engine: str, places: tuple[str, ...], slopes: tuple[int, ...] = SLOPES) -> int:
    """Nothing that begins on these places, or falls onto them on its edge, is let in."""
    lean, count = rotation(yaw_quaternion(1.0), about_x(0.5)), 0
    for name, terrain, place in grid(places, slopes):
        stands = fall(engine, terrain, place)
        # A slope carries it, or it slides; it is nowhere deeper than it lies on flat ground.
        assert stands.lowest > 0.03, (name, place, stands)
        if stands.speed < 0.01:
            assert stands.deepest < DEEPEST[engine], (name, place, stands)
        falls = fall(engine, terrain, place, 2.0, lean)
        assert falls.lowest > 0.0, (name, place, falls)
        if falls.speed < 0.01:
            assert falls.deepest < DEEPEST[engine], (name, place, falls)
        count += 1
    return count


@pytest.mark.parametrize("engine", ENGINES)
def test_terrain_is_solid(engine: str) -> None:
    assert check_solid(engine, ("edge",), (15, 30, 45)) == 12


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_terrain_is_solid_at_hundreds_of_places(engine: str) -> None:
    assert check_solid(engine, (*PLACES, "face", "edge", "tip", "crest")) == 504


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("drop", [20.0, 100.0])
def test_a_long_fall_ends_on_the_terrain(engine: str, drop: float) -> None:
    """At up to 44 m/s it passes more than its thickness in a step."""
    draw, lean = Random(8), rotation(yaw_quaternion(1.0), about_x(0.4))
    for cell, slope in product((1.0, 5.0), (5, 30, 45)):
        terrain = rough(cell, slope, draw)
        place = place_on(terrain, draw.choice(("face", "edge", "tip")), draw)
        fallen = fall(engine, terrain, place, drop, lean, (2 * drop / 9.8) ** 0.5 + 1.5)
        assert fallen.lowest > 0.0, (cell, slope, place, fallen)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("size", [(0.1, 0.1, 0.05), (0.4, 0.4, 0.2), (2.0, 1.0, 0.3)])
def test_terrain_is_solid_for_bodies_of_other_sizes(engine: str, size: Triple) -> None:
    draw = Random(2)
    for cell, slope in product((1.0, 5.0), (10, 30)):
        terrain = rough(cell, slope, draw)
        x, y = place_on(terrain, "edge", draw)
        ground = highest_under(terrain, Point(x, y, 0.0), 0.0, size)
        with simulation(engine, terrain=terrain) as physics:
            at = x, y, ground + size[2] / 2 + 0.2
            body = physics.add_body(2.0, (0.1, 0.2, 0.3), size, at, (0.0, 0.0, 0.0, 1.0))
            run(physics, 3)
            (x, y, z), *_ = body.state()
            assert z > height_at(terrain, x, y) + 0.45 * size[2], (cell, slope, body.state())
            assert surface_depth(terrain, body.state(), size) < 0.01


@pytest.mark.parametrize("engine", ENGINES)
def test_bodies_rest_at_the_height_that_rays_meet(engine: str) -> None:
    terrain = Terrain(((0.0,) * 4, (0.0, 2.0, 2.0, 0.0), (0.0, 2.0, 2.0, 0.0), (0.0,) * 4), 9.0)
    with simulation(engine, terrain=terrain) as physics:
        body = vehicle(physics, (0.3, -0.6, 2.1))
        run(physics, 2)
        (hit,) = physics.rays([(0.3, -0.6, 9.0)], [(0.3, -0.6, -1.0)]).distances
        assert 9 - hit == pytest.approx(2.0, abs=1e-6)
        assert body.state()[0][2] == pytest.approx(2.06, abs=0.0005)
        assert all(touch.normal[2] > 0.99 for touch in body.contacts()) and body.contacts()


# Flights.


def ridge_world(folder: Path, slope: float, starts: str) -> str:
    """A world file with a ridge along x at y = 0, and slopes of 20 m to its north and south."""
    rise = 5 * tan(radians(slope))
    rows = [[rise * min(i, 8 - i) * (0 < j < 8) for j in range(9)] for i in range(9)]
    file = folder / "ridge.yaml"
    file.write_text(
        f"world: ridge\nstart: {starts}\nground: {{terrain: {{size: 40 m, heights: {rows}}}}}\n"
    )
    return str(file)


@pytest.mark.parametrize("slope", [10, 20, 30])
@pytest.mark.parametrize("y", [-10.3, -0.02, 7.0])
def test_a_vehicle_stands_on_the_slope_where_it_starts(
    tmp_path: Path, slope: int, y: float
) -> None:
    world = ridge_world(tmp_path, slope, f"{{at: [1, {y}], heading: 40 deg}}")
    with open_session(Options(world=world)) as session:
        wait(session, 3)
        stood = only(session).observe()
        ground = (20 - abs(y)) * tan(radians(slope))
        assert stood.home == pytest.approx((1, y, ground))
        # It drops on its uphill side, and slides a little.
        assert dist(stood.position[:2], (1, y)) < 0.25
        assert wait(session, 10)[-1].position == stood.position
        take_off(session, 2.0)
        only(session).command(Position(Point(1.0, y, ground + 2.0)), LONG)
        wait(session, 4)
        assert dist(only(session).observe().position, (1, y, ground + 2)) < 0.01


def test_a_vehicle_lands_on_a_slope(tmp_path: Path) -> None:
    world = ridge_world(tmp_path, 20, "{at: [0, -30]}")
    with open_session(Options(world=world)) as session:
        vehicle = take_off(session, 8.0)
        vehicle.command(Position(Point(0.0, -10.0, 8.0)), LONG)
        wait(session, 12)
        finish(session, vehicle.land(), 20)
        x, y, z = wait(session, 2)[-1].position
        assert z == pytest.approx((20 + y) * tan(radians(20)), abs=0.02)
        assert dist((x, y), (0, -10)) < 0.3


def test_vehicles_without_a_start_of_their_own_stand_on_the_hill_too(tmp_path: Path) -> None:
    file = tmp_path / "east.yaml"
    rows = [[0, 0, 0, 0, 0], [0, 0, 2, 4, 0], [0, 0, 2, 4, 0], [0, 0, 2, 4, 0], [0, 0, 0, 0, 0]]
    file.write_text(
        "world: east\nstart: {at: [-3, 0.5]}\n"
        f"ground: {{terrain: {{size: 40 m, heights: {rows}}}}}\n"
    )
    with open_session(Options(named("a", "b", "c"), world=str(file))) as session:
        wait(session, 2)
        heights = [vehicle.observe().position.z for vehicle in session.vehicles.values()]
        assert heights == pytest.approx([1.4, 1.8, 2.2], abs=0.02)
