"""Worlds and views for the tests of cameras and renderers."""

from __future__ import annotations

from math import cos, hypot, pi, radians, sin, sqrt, tan
from pathlib import Path
from random import Random

import numpy as np
from numpy.typing import NDArray

from hal.vehicle import Intrinsics
from vencejo.geometry import Point, Pose, Quaternion, yaw_quaternion
from worlds.things import (
    UPRIGHT,
    Color,
    Cuboid,
    Cylinder,
    Fiducial,
    Part,
    Plate,
    Shape,
    Sphere,
    Stripe,
    Texture,
    Thing,
)
from worlds.world import Ground, Light, Start, World

GREEN = Ground((85, 130, 60), 200.0)
NOWHERE = Point(0.0, 0.0, 0.0)
ROAD = Ground(
    (85, 130, 60),
    200.0,
    stripes=(
        Stripe(((-50, -4), (0, -4), (10, 0), (50, 0)), 3.0, (70, 70, 75)),
        Stripe(((-50, -2.6), (0, -2.6), (9.6, 1.4), (50, 1.4)), 0.15, (255, 255, 255)),
    ),
)


def world_of(
    *things: Thing, ground: Ground = GREEN, light: Light | None = None, start: Point = NOWHERE
) -> World:
    """A world of things; without a light every face shows its colour as it is."""
    return World(
        name="test",
        description="",
        origin=None,
        ground=ground,
        starts=(Start(start, 0.0),),
        battery=1.0,
        places={},
        source=Path("test"),
        sha256="",
        things=things,
        light=light or Light(ambient=1.0),
    )


def thing_of(
    name: str,
    shape: Shape,
    at: tuple[float, float, float],
    attitude: Quaternion = UPRIGHT,
    color: Color = (200, 30, 30),
    texture: Texture | None = None,
) -> Thing:
    part = Part(shape, NOWHERE, UPRIGHT, color, texture)
    return Thing(name, "thing", Point(*at), attitude, (part,))


def marker(
    number: int, at: tuple[float, float, float], size: float, attitude: Quaternion = UPRIGHT
) -> Thing:
    """A 4 × 4 marker: ``size`` is that of its black square, without the white border."""
    side = size * 8 / 6
    texture = Fiducial("4X4_50", number)
    return thing_of(f"marker{number}", Plate(side, side), at, attitude, (255, 255, 255), texture)


def random_attitude(draw: Random) -> Quaternion:
    x, y, z, w = (draw.gauss(0, 1) for _ in range(4))
    length = sqrt(x * x + y * y + z * z + w * w)
    return x / length, y / length, z / length, w / length


def clutter(draw: Random, count: int = 20) -> World:
    """Boxes, cylinders and balls of different colours, some tilted, some inside each other."""
    things = []
    for number in range(count):
        size = Point(*(draw.uniform(0.3, 2.0) for _ in range(3)))
        kind = draw.choice(["box", "box", "box", "tilted", "cylinder", "sphere"])
        x, y = draw.uniform(-6, 6), draw.uniform(-6, 6)
        z, attitude = size.z / 2 + draw.choice([0.0, 0.0, 1.0]), yaw_quaternion(draw.uniform(0, pi))
        shape: Shape = Cuboid(size)
        if kind == "tilted":
            attitude, z = random_attitude(draw), 2.0
        elif kind == "cylinder":
            shape = Cylinder(size.x / 2, size.z)
        elif kind == "sphere":
            shape, z = Sphere(size.x / 2), draw.uniform(1.0, 3.0)
        color = (number * 10 + 5, 255 - number * 9, number * 77 % 251)
        things.append(thing_of(f"t{number}", shape, (x, y, z), attitude, color))
    return world_of(*things, ground=Ground((1, 2, 3), 100.0))


def town(count: int = 20, markers: int = 5) -> World:
    """The scene of the speed tests: boxes and markers that stand apart, beside a road."""
    draw = Random(3)
    things: list[Thing] = []
    while len(things) < count + markers:
        x, y = draw.uniform(-9, 9), draw.uniform(-9, 9)
        if any(hypot(x - other.at.x, y - other.at.y) < 1.9 for other in things):
            continue
        number = len(things)
        heading = yaw_quaternion(draw.uniform(0, pi))
        if number < markers:
            things.append(marker(number, (x, y, 0.001), 0.6, heading))
            continue
        size = Point(draw.uniform(0.4, 1.2), draw.uniform(0.4, 1.2), draw.uniform(0.4, 1.6))
        color = (draw.randrange(256), draw.randrange(256), draw.randrange(256))
        at = (x, y, size.z / 2)
        things.append(thing_of(f"box{number}", Cuboid(size), at, heading, color))
    return world_of(*things, ground=ROAD, light=Light())


def lens(width: int, height: int, field: float = 60.0) -> Intrinsics:
    """A camera with a horizontal field of view in degrees."""
    focal = width / 2 / tan(radians(field) / 2)
    return Intrinsics(width, height, focal, focal, (width - 1) / 2, (height - 1) / 2)


def look(
    at: tuple[float, float, float],
    to: tuple[float, float, float],
    up: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> Pose:
    """The pose of a camera that looks to a place."""
    forward = np.array(to, float) - at
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, up)
    if np.linalg.norm(right) < 1e-6:
        right = np.cross(forward, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    turn = np.column_stack([right, np.cross(forward, right), forward])
    return Point(*at), quaternion(turn)


def quaternion(turn: NDArray[np.float64]) -> Quaternion:
    """The quaternion of a rotation matrix: an eigenvector of Bar-Itzhack's matrix (2000)."""
    (a, b, c), (d, e, f), (g, h, i) = turn
    symmetric = np.array(
        [
            [a - e - i, b + d, c + g, h - f],
            [b + d, e - a - i, f + h, c - g],
            [c + g, f + h, i - a - e, d - b],
            [h - f, c - g, d - b, a + e + i],
        ]
    )
    x, y, z, w = np.linalg.eigh(symmetric)[1][:, -1].tolist()
    return x, y, z, w


def turned(axis: tuple[float, float, float], angle: float) -> Quaternion:
    s = sin(angle / 2)
    return axis[0] * s, axis[1] * s, axis[2] * s, cos(angle / 2)
