"""Outlines from above: of every shape, turned and moving."""

from __future__ import annotations

from itertools import pairwise
from math import cos, hypot, pi, sin
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vencejo.geometry import Point, Quaternion, about_x, about_y, product, turned, yaw_quaternion
from worlds import Outline, Thing, find_world, load_world, outlines_of, world_names
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Motion, Part, Plate, Shape, Sphere

ANGLES = st.floats(-pi, pi)
SIZES = st.floats(0.05, 20.0)
ATTITUDES = st.builds(
    lambda yaw, pitch, roll: product(yaw_quaternion(yaw), product(about_y(pitch), about_x(roll))),
    *(ANGLES, ANGLES, ANGLES),
)


def thing(shape: Shape, at: Point, attitude: Quaternion, **more: object) -> Thing:
    parts = (Part(shape, Point(0, 0, 0), UPRIGHT, (0, 0, 0)),)
    return Thing("it", "box", at, attitude, parts, **more)  # type: ignore[arg-type]


def outside(outline: Outline, x: float, y: float) -> float:
    """How far a place is outside a convex polygon; 0 inside."""
    beyond = 0.0
    for (ax, ay), (bx, by) in pairwise([*outline, outline[0]]):
        length = hypot(bx - ax, by - ay)
        if length > 1e-9:
            beyond = max(beyond, ((bx - ax) * (ay - y) - (by - ay) * (ax - x)) / length)
    return beyond


def area(outline: Outline) -> float:
    """Above 0 when its corners stand counter-clockwise."""
    corners = pairwise([*outline, outline[0]])
    return sum(ax * by - bx * ay for (ax, ay), (bx, by) in corners) / 2


def test_a_box_has_its_four_corners() -> None:
    (outline,) = outlines_of(thing(Cuboid(Point(4, 2, 9)), Point(10, 5, 1), yaw_quaternion(pi / 2)))
    assert sorted((round(x, 9), round(y, 9)) for x, y in outline) == [
        *((9, 3), (9, 7), (11, 3), (11, 7)),
    ]
    assert area(outline) == pytest.approx(8)


def test_round_things_are_round() -> None:
    for shape in (Sphere(2.0), Cylinder(2.0, 5.0)):
        (outline,) = outlines_of(thing(shape, Point(3, 4, 5), UPRIGHT))
        assert {round(hypot(x - 3, y - 4), 6) for x, y in outline} == {2.0}
        assert area(outline) == pytest.approx(pi * 4, rel=0.02)
    (lying,) = outlines_of(thing(Cylinder(1.0, 6.0), Point(0, 0, 1), about_y(pi / 2)))
    assert area(lying) == pytest.approx(12, rel=0.02)


@given(
    st.one_of(
        st.builds(lambda x, y, z: Cuboid(Point(x, y, z)), SIZES, SIZES, SIZES),
        st.builds(Cylinder, SIZES, SIZES),
        st.builds(Sphere, SIZES),
        st.builds(Plate, SIZES, SIZES),
    ),
    ATTITUDES,
    st.lists(st.tuples(*[st.floats(-1, 1)] * 3), min_size=20, max_size=20),
)
def test_every_point_of_a_shape_is_inside_its_outline(
    shape: Shape, attitude: Quaternion, shares: list[tuple[float, float, float]]
) -> None:
    (outline,) = outlines_of(thing(shape, Point(7, -3, 2), attitude))
    size = max(hypot(x - 7, y + 3) for x, y in outline)
    for a, b, c in shares:
        x, y, _ = turned(_inside(shape, a, b, c), attitude)
        # Circles are polygons of 24 corners here.
        assert outside(outline, 7 + x, -3 + y) <= 0.02 * size
    assert area(outline) >= -1e-9


def _inside(shape: Shape, a: float, b: float, c: float) -> tuple[float, float, float]:
    """A point of a shape, its own frame, by three shares from −1 to 1."""
    match shape:
        case Cuboid(size):
            return a * size.x / 2, b * size.y / 2, c * size.z / 2
        case Cylinder(radius, height):
            return a * radius * cos(pi * b), a * radius * sin(pi * b), c * height / 2
        case Sphere(radius):
            level = radius * (1 - c * c) ** 0.5
            return a * level * cos(pi * b), a * level * sin(pi * b), c * radius
        case Plate(width, height):
            return a * width / 2, b * height / 2, 0.0
    raise AssertionError(shape)


def test_a_mesh_has_the_outline_of_its_hull() -> None:
    rng = np.random.default_rng(3)
    vertices = rng.uniform(-1, 1, (5000, 3)) * (3, 2, 1)
    (outline,) = outlines_of(thing(Mesh(vertices, np.array([[0, 1, 2]])), Point(1, 1, 0), UPRIGHT))
    assert len(outline) <= 64
    assert max(outside(outline, x + 1, y + 1) for x, y, _ in vertices) < 0.05


def test_what_moves_is_where_it_is_at_that_time() -> None:
    way = Motion((Point(0, 0, 0), Point(10, 0, 0)), 2.0, loop=False, turns=True)
    mover = thing(Cuboid(Point(1, 1, 1)), Point(0, 0, 0), UPRIGHT, motion=way)
    (outline,) = outlines_of(mover, 3.0)
    assert [round(sum(axis) / len(outline), 6) for axis in zip(*outline, strict=True)] == [6, 0]


def test_of_solid_things_only_what_can_be_touched() -> None:
    """Markers and windows stand on faces; a marker by itself has an outline of its own."""
    world = {thing.name: thing for thing in find_world("marker_yard").things}
    assert len(outlines_of(world["table"])) == 1
    (home,) = outlines_of(world["home"])
    assert 0.5 < area(home) ** 0.5 < 0.8


@pytest.mark.parametrize("name", world_names())
def test_every_thing_of_the_shipped_worlds_has_outlines(name: str) -> None:
    for each in find_world(name).things:
        assert outlines_of(each)
        assert all(len(outline) >= 2 for outline in outlines_of(each, 12.0))


def test_walls_are_apart(tmp_path: Path) -> None:
    path = tmp_path / "w.yaml"
    path.write_text(
        "world: w\n"
        "walls: {wall: {through: [[0, 5], [4, 5], [4, 9]], height: 1, thickness: 20 cm}}\n"
    )
    (wall,) = load_world(path).things
    assert [round(area(outline), 6) for outline in outlines_of(wall)] == [0.84, 0.84]
