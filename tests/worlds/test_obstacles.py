"""Distances of straight ways from things: against samples of the way and of the things."""

from __future__ import annotations

from dataclasses import replace
from math import dist, pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from vencejo.geometry import Point, Quaternion, about_x, about_y, product, turned, yaw_quaternion
from worlds import find_world
from worlds.loader import load_world, read_world
from worlds.obstacles import Obstacles
from worlds.terrain import height_at
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Part, Shape, Sphere, Thing
from worlds.world import World

Array = NDArray[np.float64]
EMPTY = find_world("empty")
TETRAHEDRON = Mesh(
    np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.3, 0.2, 1.0]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32),
)


def world_with(shape: Shape, at: Point, attitude: Quaternion) -> World:
    part = Part(shape, Point(0.0, 0.0, 0.0), UPRIGHT, (0, 0, 0))
    return replace(EMPTY, things=(Thing("it", "box", at, attitude, (part,)),))


def filled(shape: Shape) -> Array:
    """Places that fill a shape densely, about 0.1 m apart, and places of its surface."""
    if isinstance(shape, Mesh):
        share = [(i / 14, j / 14) for i in range(15) for j in range(15 - i)]
        corners = shape.vertices[shape.faces]
        return np.concatenate(
            [
                corners[:, 0]
                + u * (corners[:, 1] - corners[:, 0])
                + v * (corners[:, 2] - corners[:, 0])
                for u, v in share
            ]
        )
    if isinstance(shape, Cuboid):
        axes = [np.linspace(-side / 2, side / 2, 15) for side in shape.size]
        return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    angles = np.linspace(0, 2 * pi, 24, endpoint=False)
    if isinstance(shape, Cylinder):
        levels = np.linspace(-shape.height / 2, shape.height / 2, 15)
        return np.array(
            [
                (r * np.cos(a), r * np.sin(a), z)
                for r in np.linspace(0, shape.radius, 8)
                for a in angles
                for z in levels
            ]
        )
    assert isinstance(shape, Sphere)
    return np.array(
        [
            (r * np.cos(a) * np.sin(b), r * np.sin(a) * np.sin(b), r * np.cos(b))
            for r in np.linspace(0, shape.radius, 8)
            for a in angles
            for b in np.linspace(0, pi, 13)
        ]
    )


coordinate = st.floats(-4, 4)
points = st.builds(Point, coordinate, coordinate, coordinate)
angle = st.floats(-pi, pi)
attitudes = st.builds(
    lambda yaw, pitch, roll: product(yaw_quaternion(yaw), product(about_y(pitch), about_x(roll))),
    angle,
    angle,
    angle,
)
size = st.floats(0.2, 1.5)
shapes = st.one_of(
    st.builds(Cuboid, st.builds(Point, size, size, size)),
    st.builds(Cylinder, size, size),
    st.builds(Sphere, size),
    st.just(TETRAHEDRON),
)


@settings(max_examples=150, deadline=None)
@given(shapes, points, attitudes, points, points)
def test_the_distance_of_a_way_from_a_solid_is_that_of_the_nearest_samples(
    shape: Shape, at: Point, attitude: Quaternion, a: Point, b: Point
) -> None:
    obstacles = Obstacles(world_with(shape, at, attitude))
    found = obstacles.near(a, b, 20.0)
    assert [near.thing.name for near in found] == ["it"]
    near = found[0]
    solid = np.array([turned(place, attitude) for place in filled(shape)]) + at
    way = np.linspace(a, b, 60)
    sampled = np.linalg.norm(solid[:, None] - way[None], axis=2).min()
    # Samples can only be farther away; how much is what lies between them.
    assert near.distance <= sampled + 1e-6
    assert near.distance >= sampled - 0.25
    off = np.linalg.norm(way - np.array(near.place), axis=1).min()
    assert off <= dist(a, b) / 59 + 1e-6, "the place lies on the way"
    nearest = np.linalg.norm(solid - np.array(near.place), axis=1).min()
    assert nearest <= near.distance + 0.25


@settings(max_examples=100, deadline=None)
@given(shapes, points, attitudes, points, points, st.floats(0.01, 3))
def test_only_what_is_nearer_than_asked_is_found_and_all_of_it(
    shape: Shape, at: Point, attitude: Quaternion, a: Point, b: Point, within: float
) -> None:
    obstacles = Obstacles(world_with(shape, at, attitude))
    (near,) = obstacles.near(a, b, 20.0)
    found = obstacles.near(a, b, within)
    if abs(near.distance - within) > 1e-4:
        assert bool(found) == (near.distance < within)
    for other in found:
        assert other.distance == pytest.approx(near.distance, abs=1e-4)


@settings(max_examples=60, deadline=None)
@given(shapes, attitudes, st.floats(-1, 1), st.floats(-1, 1))
def test_what_lies_below_is_the_top_of_the_thing_or_the_ground(
    shape: Shape, attitude: Quaternion, x: float, y: float
) -> None:
    at = Point(0.0, 0.0, 4.0)
    obstacles = Obstacles(world_with(shape, at, attitude))
    top = obstacles.below(Point(x, y, 9.0)).height
    solid = np.array([turned(place, attitude) for place in filled(shape)]) + at
    around = solid[np.hypot(solid[:, 0] - x, solid[:, 1] - y) < 0.2]
    assert 0.0 <= top <= solid[:, 2].max() + 0.05
    if top > 0.0:
        assert np.linalg.norm(solid - np.array([x, y, top]), axis=1).min() < 0.25
    elif len(around):
        assert not obstacles.near(Point(x, y, 9.0), Point(x, y, 0.0), 1e-8)


def test_the_wall_of_the_yard_is_met_where_it_stands() -> None:
    obstacles = Obstacles(find_world("yard"))
    (wall,) = obstacles.near(Point(0, 0, 1), Point(0, 20, 1), 0.5)
    assert wall.thing.name == "wall" and wall.distance == 0.0
    assert wall.place.y == pytest.approx(12.0, abs=0.16)
    assert obstacles.near(Point(0, 0, 2.6), Point(0, 20, 2.6), 0.5) == []
    (wall,) = obstacles.near(Point(0, 0, 2.3), Point(0, 20, 2.3), 0.5)
    assert wall.distance == pytest.approx(0.3, abs=1e-4)
    height, table = obstacles.below(Point(3, -4, 2))
    assert height == pytest.approx(0.8, abs=1e-3) and table is not None and table.name == "table"
    assert obstacles.below(Point(0, 0, 2)) == (0.0, None)


def test_a_thing_that_moves_is_told_apart_wherever_its_path_may_bring_it() -> None:
    world = read_world(
        "world: w\nspheres: {b: {radius: 0.5, moves: {through: [[5, 0, 2], [5, 9, 2]], speed: 1}}}",
        "w.yaml",
    )
    obstacles = Obstacles(world)
    assert obstacles.near(Point(0, 0, 2), Point(9, 0, 2), 0.5) == []
    assert [t.name for t in obstacles.moving_near(Point(0, 8, 2), Point(9, 8, 2), 0.5)] == ["b"]
    assert obstacles.moving_near(Point(0, 8, 9), Point(9, 8, 9), 0.5) == []


HILLS = """
world: hills
start: {at: [-29, -29]}
ground:
  terrain: {size: 60 m, heights: [[0, 0, 0, 0], [0, 5, 1, 0], [0, 2, 3, 0], [0, 0, 0, 0]]}
"""


@settings(max_examples=60, deadline=None)
@given(*[st.floats(-35, 35)] * 2, st.floats(0, 8), *[st.floats(-35, 35)] * 2, st.floats(0, 8))
def test_the_height_above_hills_is_the_least_of_all_samples(
    x: float, y: float, z: float, u: float, v: float, w: float
) -> None:
    world = read_world(HILLS, "w.yaml")
    a, b = Point(x, y, z), Point(u, v, w)
    height, place = Obstacles(world).height_above_ground(a, b)
    terrain = world.ground.terrain
    sampled = min(float(p[2]) - height_at(terrain, p[0], p[1]) for p in np.linspace(a, b, 200))
    assert height <= sampled + 1e-6 and height >= sampled - 0.6
    assert place.z - height_at(terrain, place.x, place.y) == pytest.approx(height, abs=1e-6)


def test_a_mesh_of_a_file_is_its_triangles_and_not_the_box_about_it(tmp_path: Path) -> None:
    (tmp_path / "ramp.obj").write_text(
        "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 4 0 4\nv 4 4 4\n"
        "f 1 2 5\nf 4 6 3\nf 1 5 6\nf 1 6 4\nf 2 3 6\nf 2 6 5\nf 1 3 2\nf 1 4 3\n"
    )
    (tmp_path / "w.yaml").write_text(
        "world: w\nstart: {at: [-9, 0]}\nmeshes: {m: {at: [0, 0], file: ramp.obj}}\n"
    )
    obstacles = Obstacles(load_world(tmp_path / "w.yaml"))
    assert len(obstacles) == 1
    above = Point(0.0, 2.0, 3.0), Point(0.5, 2.0, 3.5)  # inside the box, above the slope
    (near,) = obstacles.near(*above, 3.0)
    assert near.distance == pytest.approx(3 / 2**0.5, abs=0.5)
    assert obstacles.near(*above, 0.5) == []
    assert obstacles.below(Point(2.0, 2.0, 9.0)).height == pytest.approx(2.0, abs=0.01)
