"""The parts that each kind of thing is made of.

Each function gives them in the thing's own frame: x forward, y left, z up, metres; the thing stands
on z = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import hypot, pi

from vencejo.geometry import (
    Point,
    Quaternion,
    about_x,
    about_y,
    bearing,
    product,
    turned,
    yaw_quaternion,
)
from worlds.colors import COLORS
from worlds.things import (
    UPRIGHT,
    Charuco,
    Color,
    Cuboid,
    Cylinder,
    Fiducial,
    Image,
    Part,
    Plate,
    Shape,
    Sphere,
    Texture,
)

_STANDOFF = 0.01
"""Plates on a face stand out this far, metres: of two faces in one plane either could be seen."""
_WHITE = COLORS["white"]


def _part(shape: Shape, x: float, y: float, z: float, color: Color) -> Part:
    return Part(shape, Point(x, y, z), UPRIGHT, color)


def standing(faces: float, lean: float = 0.0, turn: float = 0.0) -> Quaternion:
    """The attitude of a plate that faces a direction, leans back and is turned in its own plane.

    Radians: ``faces`` counter-clockwise from east, ``lean`` from upright, ``turn``
    counter-clockwise as seen.
    """
    upright = product(yaw_quaternion(faces + pi / 2), about_x(pi / 2 - lean))
    return product(upright, yaw_quaternion(turn))


def box(size: Point, color: Color, texture: Image | None = None) -> tuple[Part, ...]:
    return (Part(Cuboid(size), Point(0, 0, size.z / 2), UPRIGHT, color, texture),)


def cylinder(radius: float, height: float, color: Color) -> tuple[Part, ...]:
    return (_part(Cylinder(radius, height), 0, 0, height / 2, color),)


def sphere(radius: float, color: Color) -> tuple[Part, ...]:
    return (_part(Sphere(radius), 0, 0, radius, color),)


def beacon(radius: float, color: Color) -> tuple[Part, ...]:
    """A sphere about the thing's origin."""
    return (_part(Sphere(radius), 0, 0, 0, color),)


def plate(
    width: float, height: float, attitude: Quaternion, texture: Texture, z: float = 0.0
) -> Part:
    return Part(Plate(width, height), Point(0, 0, z), attitude, _WHITE, texture)


def lying_marker(texture: Fiducial | Charuco, width: float, height: float, top: float) -> Part:
    """A marker that lies on an upper face at a height of ``top``."""
    return plate(width, height, UPRIGHT, texture, top + _STANDOFF)


def wall(
    through: Sequence[tuple[float, float]], height: float, thickness: float, color: Color
) -> tuple[Part, ...]:
    """Straight walls from point to point."""
    parts = []
    for a, b in pairwise(through):
        length = hypot(b[0] - a[0], b[1] - a[1])
        middle = Point((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, height / 2)
        # Half a thickness further at each end, so that corners close.
        size = Point(length + thickness, thickness, height)
        heading = bearing((*a, 0.0), (*b, 0.0))
        parts.append(Part(Cuboid(size), middle, yaw_quaternion(heading), color))
    return tuple(parts)


def house(size: Point, color: Color, roof: Color) -> tuple[Part, ...]:
    """Walls under a flat roof with eaves; a door in front, windows in front and at the back."""
    slab, eaves = 0.25, 0.3
    height = max(size.z - slab, size.z / 2)
    walls = Part(Cuboid(Point(size.x, size.y, height)), Point(0, 0, height / 2), UPRIGHT, color)
    lid = Cuboid(Point(size.x + 2 * eaves, size.y + 2 * eaves, size.z - height))
    front, back = size.x / 2 + _STANDOFF, -size.x / 2 - _STANDOFF
    pane, door_height = size.y / 5, min(2.0, height * 0.8)
    sill, dark, wood = height * 0.55, (45, 60, 80), COLORS["brown"]
    openings = [
        (front, 0.0, door_height / 2, min(1.0, pane), door_height, wood, 0.0),
        *(
            (x, y, sill, pane, height * 0.3, dark, faces)
            for x, faces in ((front, 0.0), (back, pi))
            for y in (-size.y * 0.3, size.y * 0.3)
        ),
    ]
    plates = (
        Part(Plate(width, tall), Point(x, y, z), standing(faces), hue)
        for x, y, z, width, tall, hue, faces in openings
    )
    return (walls, _part(lid, 0, 0, (size.z + height) / 2, roof), *plates)


def car(color: Color) -> tuple[Part, ...]:
    """A saloon of 4.2 m, 1.8 m wide and 1.45 m high."""
    axle, black = about_x(pi / 2), (25, 25, 28)
    wheels = (
        Part(Cylinder(0.32, 0.22), Point(x, y, 0.32), axle, black)
        for x in (-1.3, 1.3)
        for y in (-0.82, 0.82)
    )
    return (
        _part(Cuboid(Point(4.2, 1.8, 0.6)), 0, 0, 0.6, color),
        _part(Cuboid(Point(2.2, 1.6, 0.55)), -0.2, 0, 1.175, (60, 75, 90)),
        *wheels,
    )


def person(color: Color, lying: bool) -> tuple[Part, ...]:
    """A person 1.75 m tall; lying, the head is forward."""
    standing_parts = (
        _part(Cylinder(0.14, 0.85), 0, 0, 0.425, (50, 55, 85)),
        _part(Cylinder(0.2, 0.6), 0, 0, 1.15, color),
        _part(Sphere(0.15), 0, 0, 1.6, COLORS["skin"]),
    )
    if not lying:
        return standing_parts
    down, shift = about_y(pi / 2), Point(-0.875, 0.0, 0.2)
    return tuple(
        Part(part.shape, turned(part.at, down).plus(shift), down, part.color)
        for part in standing_parts
    )


def tree(height: float, color: Color) -> tuple[Part, ...]:
    """A trunk and a spherical crown."""
    crown = height * 0.25
    trunk = Cylinder(max(0.05, height * 0.03), height - crown)
    return (
        _part(trunk, 0, 0, (height - crown) / 2, COLORS["brown"]),
        _part(Sphere(crown, leafy=True), 0, 0, height - crown, color),
    )


def gate(width: float, height: float, color: Color) -> tuple[Part, ...]:
    """A frame to fly through along x; ``width`` and ``height`` are those of the opening."""
    bar = 0.1
    post = Cuboid(Point(bar, bar, height))
    side = (width + bar) / 2
    return (
        _part(post, 0, -side, height / 2, color),
        _part(post, 0, side, height / 2, color),
        _part(Cuboid(Point(bar, width + 2 * bar, bar)), 0, 0, height + bar / 2, color),
    )


def sign(
    width: float, board_height: float, top: float, color: Color, texture: Image | None
) -> tuple[Part, ...]:
    """A board on a post; an image is on its front only."""
    middle = top - board_height / 2
    board = Cuboid(Point(0.03, width, board_height))
    parts = (
        _part(Cylinder(0.04, top), 0, 0, top / 2, COLORS["silver"]),
        _part(board, 0.06, 0, middle, color),
    )
    if texture is None:
        return parts
    front = Point(0.075 + _STANDOFF, 0.0, middle)
    return (*parts, Part(Plate(width, board_height), front, standing(0.0), _WHITE, texture))
