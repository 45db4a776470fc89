"""Bounds of solid things, distances to them, and room to start beside them. Metres."""

from __future__ import annotations

from collections.abc import Iterable
from math import hypot, inf, sqrt

from vencejo.geometry import Point, Pose, Quaternion, product, rotate_xy, turned, yaw_of
from worlds.motion import pose_at
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Part, Plate, Shape, Sphere, Thing

START_CLEARANCE = 0.4
"""A vehicle needs this much free room beside its start."""
_TOLERANCE = 1e-6
"""A start this much below a thing's top still counts as on top of it."""
Bounds = tuple[Point, Point]
"""The lowest and highest x, y and z."""


def solid_parts(thing: Thing) -> tuple[Part, ...]:
    """The parts of a thing that can be touched."""
    if not thing.solid:
        return ()
    return tuple(part for part in thing.parts if not isinstance(part.shape, Plate))


def part_pose(part: Part, at: Point, attitude: Quaternion) -> Pose:
    """The pose of a part of a thing, where ``at`` and ``attitude`` are the thing's own."""
    return at.plus(turned(part.at, attitude)), product(attitude, part.attitude)


def bounds_of(shape: Shape, at: Point, attitude: Quaternion) -> Bounds:
    """The axis-aligned bounding box of a shape in a pose."""
    x, y, z = (turned(axis, attitude) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    if isinstance(shape, Mesh):
        along = [shape.vertices @ [x[k], y[k], z[k]] for k in range(3)]
        low = Point(*(float(values.min()) for values in along))
        return at.plus(low), at.plus(Point(*(float(values.max()) for values in along)))
    if isinstance(shape, Sphere):
        reach = [shape.radius] * 3
    elif isinstance(shape, Cylinder):
        rim = [shape.radius * sqrt(max(0.0, 1 - part * part)) for part in z]
        reach = [r + shape.height / 2 * abs(part) for r, part in zip(rim, z, strict=True)]
    else:
        sides = shape.size if isinstance(shape, Cuboid) else (shape.width, shape.height, 0.0)
        halves = [side / 2 for side in sides]
        reach = [
            sum(h * abs(axis[k]) for h, axis in zip(halves, (x, y, z), strict=True))
            for k in range(3)
        ]
    return at.minus(Point(*reach)), at.plus(Point(*reach))


def top_of(thing: Thing) -> float:
    """The height of a thing's highest solid point along all of its path; −∞ for none."""
    at = thing.at
    if thing.motion is not None:
        at = max(thing.motion.points, key=lambda point: point.z)
    tops = [
        bounds_of(part.shape, *part_pose(part, at, thing.attitude))[1].z
        for part in solid_parts(thing)
    ]
    return max(tops, default=-inf)


def thing_near(things: Iterable[Thing], start: Point) -> Thing | None:
    """A thing that leaves no room for a vehicle to start at a place; None for none.

    Beside a thing there has to be START_CLEARANCE; on top of it and above there is room.
    """
    for thing in things:
        pose = pose_at(thing, 0.0)
        if any(_is_near(part, *part_pose(part, *pose), start) for part in solid_parts(thing)):
            return thing
    return None


def _is_near(part: Part, at: Point, attitude: Quaternion, start: Point) -> bool:
    low, high = bounds_of(part.shape, at, attitude)
    if not low.z - START_CLEARANCE < start.z < high.z - _TOLERANCE:
        return False
    east, north = start.x - at.x, start.y - at.y
    upright = abs(attitude[0]) + abs(attitude[1]) < 1e-9
    if upright and isinstance(part.shape, Cylinder):
        return hypot(east, north) < part.shape.radius + START_CLEARANCE
    if upright and isinstance(part.shape, Cuboid):
        along, across = rotate_xy(east, north, -yaw_of(attitude))
        size = part.shape.size
        return (
            abs(along) < size.x / 2 + START_CLEARANCE and abs(across) < size.y / 2 + START_CLEARANCE
        )
    return (
        low.x - START_CLEARANCE < start.x < high.x + START_CLEARANCE
        and low.y - START_CLEARANCE < start.y < high.y + START_CLEARANCE
    )


def holds(shape: Shape, place: Point) -> bool:
    """Whether a place of the shape's own frame is inside it; of a mesh its bounding box counts."""
    if isinstance(shape, Sphere):
        return place.norm() < shape.radius
    low, high = bounds_of(shape, Point(0.0, 0.0, 0.0), UPRIGHT)
    if isinstance(shape, Cylinder) and hypot(place.x, place.y) >= shape.radius:
        return False
    return all(a < v < b for a, v, b in zip(low, place, high, strict=True))


def distance_to(shape: Shape, place: Point) -> float:
    """The distance of a place from a shape's surface, in the shape's own frame.

    Of a mesh it is that from its bounding box.
    """
    return apart(shape, place) or -max(_beyond(shape, place))


def apart(shape: Shape, place: Point) -> float:
    """The distance of a place from a shape, in its own frame; 0 inside. Of a mesh as above."""
    return hypot(*(max(0.0, v) for v in _beyond(shape, place)))


def _beyond(shape: Shape, place: Point) -> list[float]:
    """How far a place is beyond a shape, in each of the directions at right angles that it has."""
    if isinstance(shape, Sphere):
        return [place.norm() - shape.radius]
    if isinstance(shape, Cylinder):
        about = hypot(place.x, place.y) - shape.radius
        return [about, abs(place.z) - shape.height / 2]
    if isinstance(shape, Cuboid):
        return [abs(v) - side / 2 for v, side in zip(place, shape.size, strict=True)]
    low, high = bounds_of(shape, Point(0.0, 0.0, 0.0), UPRIGHT)
    return [max(a - v, v - b) for a, v, b in zip(low, place, high, strict=True)]
