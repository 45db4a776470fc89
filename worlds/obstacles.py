"""How near a straight flight comes to the things of a world and to its ground. World frame, metres.

The distance of a moving point from a convex shape is a convex function of its way, so that a golden
section finds the least. A mesh is its triangles, each of which is convex.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from math import dist, hypot, inf
from typing import TYPE_CHECKING, NamedTuple

from vencejo.geometry import Point, Pose, turned
from worlds.motion import pose_at
from worlds.solids import Bounds, apart, bounds_of, part_pose, solid_parts
from worlds.terrain import height_at, on_ground
from worlds.things import Mesh, Motion, Shape, Thing
from worlds.world import World

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_GOLDEN = 0.6180339887498949
_PRECISION = 1e-5
"""Of a place on a way, metres."""
_TOUCHING = 1e-4
"""What is this near touches, metres."""


class Near(NamedTuple):
    """A thing that is near a way."""

    thing: Thing
    distance: float
    """The least, 0 where the way leads through it."""
    place: Point
    """The place on the way from which it is that far."""


class Below(NamedTuple):
    """What lies straight below a place."""

    height: float
    """Of its top."""
    thing: Thing | None
    """None for the ground."""


class _Solid(NamedTuple):
    """A part of a thing in its place."""

    thing: Thing
    shape: Shape
    pose: Pose
    bounds: Bounds


class Obstacles:
    """The solid things of a world that stand still, and its ground."""

    def __init__(self, world: World) -> None:
        self.terrain = world.ground.terrain
        self._moving = [
            (thing, _box_of_path(thing, thing.motion))
            for thing in world.things
            if thing.motion is not None and solid_parts(thing)
        ]
        self._solids = [
            _Solid(thing, part.shape, pose, bounds_of(part.shape, *pose))
            for thing in world.things
            if thing.motion is None
            for part in solid_parts(thing)
            for pose in (part_pose(part, thing.at, thing.attitude),)
        ]

    def __len__(self) -> int:
        """The number of solid parts, where each fifteen triangles of a mesh are one more."""
        meshes = (s.shape for s in self._solids if isinstance(s.shape, Mesh))
        return len(self._solids) + sum(len(mesh.faces) for mesh in meshes) // 15

    def near(self, a: Point, b: Point, within: float) -> list[Near]:
        """The things that are nearer than ``within`` to the straight way from ``a`` to ``b``."""
        found: dict[str, Near] = {}
        for solid in self._around(a, b, within):
            stretch = _stretch_in(solid.bounds, a, b, within)
            if stretch is None:
                continue
            distance, share = _least(solid, a, b, stretch, within)
            known = found.get(solid.thing.name)
            if distance < within and (known is None or distance < known.distance):
                found[solid.thing.name] = Near(solid.thing, distance, _between(a, b, share))
        return list(found.values())

    def _around(self, a: Point, b: Point, margin: float) -> Iterator[_Solid]:
        """The solids near the box about a way: most are far from it, so this is quick."""
        (west, east), (south, north), (low, high) = (
            (min(pair) - margin, max(pair) + margin) for pair in zip(a, b, strict=True)
        )
        for solid in self._solids:
            (x, y, z), (u, v, w) = solid.bounds
            if u >= west and x <= east and v >= south and y <= north and w >= low and z <= high:
                yield solid

    def moving_near(self, a: Point, b: Point, within: float) -> list[Thing]:
        """The solid things that move and may come near a way: it depends on the time."""
        return [thing for thing, box in self._moving if _stretch_in(box, a, b, within)]

    def moving_at(self, place: Point, time: float, within: float) -> list[Near]:
        """The things that move and are nearer than ``within`` to a place at a time, seconds.

        A mesh counts as the box about it.
        """
        found = []
        for thing, box in self._moving:
            if _stretch_in(box, place, place, within) is None:
                continue
            pose = pose_at(thing, time)
            distance = min(
                apart(part.shape, _in_frame(place, part_pose(part, *pose)))
                for part in solid_parts(thing)
            )
            if distance < within:
                found.append(Near(thing, distance, place))
        return found

    def height_above_ground(self, a: Point, b: Point) -> tuple[float, Point]:
        """The least height of a straight way above the ground, and the place that has it."""
        if self.terrain is None:
            lowest = min(a, b, key=lambda point: point.z)
            return lowest.z, lowest
        found = []
        for ground in on_ground(self.terrain, [a, b]) if a[:2] != b[:2] else []:
            place = _between(a, b, dist(a[:2], ground[:2]) / dist(a[:2], b[:2]))
            found.append((place.z - ground.z, place))
        ends = ((p.z - height_at(self.terrain, p.x, p.y), p) for p in (a, b))
        return min((*ends, *found), key=lambda height: height[0])

    def below(self, place: Point) -> Below:
        """What lies straight below a place: the ground, or a thing."""
        thing = None
        highest = min(place.z, height_at(self.terrain, place.x, place.y))
        for solid in self._around(place, place._replace(z=highest), _TOUCHING):
            if highest < solid.bounds[1].z:
                top = _top_below(solid, place, highest)
                if top > highest:
                    highest, thing = top, solid.thing
        return Below(highest, thing)


def _box_of_path(thing: Thing, motion: Motion) -> Bounds:
    """A box about all that a moving thing ever takes up."""
    boxes = [bounds_of(part.shape, part.at, part.attitude) for part in solid_parts(thing)]
    farthest = (hypot(*(max(-a, b) for a, b in zip(low, high, strict=True))) for low, high in boxes)
    reach = (max(farthest),) * 3  # however it is turned
    axes = list(zip(*motion.points, strict=True))
    return Point(*map(min, axes)).minus(reach), Point(*map(max, axes)).plus(reach)


def _top_below(solid: _Solid, place: Point, ground: float) -> float:
    """The height of a solid straight below a place; that of the ground where it is not below."""
    if isinstance(solid.shape, Mesh):
        return _top_of_mesh(solid.shape, solid.pose, place, ground)

    def touches(height: float) -> bool:
        way = place, place._replace(z=height)
        return _least(solid, *way, (0.0, 1.0), 2 * _TOUCHING)[0] < _TOUCHING

    if not touches(ground):
        return ground
    low, high = ground, place.z
    while high - low > _TOUCHING:
        middle = (low + high) / 2
        low, high = (middle, high) if touches(middle) else (low, middle)
    return low


def _in_frame(place: Point, pose: Pose) -> Point:
    """A place in the frame of a pose."""
    at, (x, y, z, w) = pose
    return turned(place.minus(at), (-x, -y, -z, w))


def _between(a: Point, b: Point, share: float) -> Point:
    way = b.minus(a)
    return a.plus((way.x * share, way.y * share, way.z * share))


def _stretch_in(bounds: Bounds, a: Point, b: Point, margin: float) -> tuple[float, float] | None:
    """The shares of a way between which it is in a box with a margin; None if it is nowhere."""
    first, last = 0.0, 1.0
    for begin, end, low, high in zip(a, b, *bounds, strict=True):
        low, high, length = low - margin, high + margin, end - begin
        if length == 0.0:
            if not low <= begin <= high:
                return None
            continue
        enter, leave = (low - begin) / length, (high - begin) / length
        if enter > leave:
            enter, leave = leave, enter
        first, last = max(first, enter), min(last, leave)
        if first > last:
            return None
    return first, last


def _least(
    solid: _Solid, a: Point, b: Point, stretch: tuple[float, float], within: float
) -> tuple[float, float]:
    """The least distance of a solid from a stretch of a way, and the share of the way there.

    Where it is not below ``within`` it may be any that is not.
    """
    a, b = _in_frame(a, solid.pose), _in_frame(b, solid.pose)
    shape, length = solid.shape, dist(a, b)
    if isinstance(shape, Mesh):
        begin, end = (_between(a, b, share) for share in stretch)
        distance, share = _least_of_triangles(shape, begin, end, within)
        return distance, stretch[0] + share * (stretch[1] - stretch[0])
    low, high = stretch
    return _golden(lambda share: apart(shape, _between(a, b, share)), low, high, length)


def _golden(
    function: Callable[[float], float], low: float, high: float, length: float
) -> tuple[float, float]:
    """The least value of a convex function of the share of a way, and that share."""
    one, two = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_one, at_two = function(one), function(two)
    while (high - low) * length > _PRECISION:
        if at_one <= at_two:
            high, two, at_two = two, one, at_one
            one = high - _GOLDEN * (high - low)
            at_one = function(one)
        else:
            low, one, at_one = one, two, at_two
            two = low + _GOLDEN * (high - low)
            at_two = function(two)
    return min((function(low), low), (at_one, one), (at_two, two), (function(high), high))


# Meshes: all triangles near a way at once.


@lru_cache(maxsize=100)
def _triangles(mesh: Mesh) -> tuple[NDArray[np.float64], ...]:
    """The corners of a mesh's triangles (m, 3, 3), and the bounds of each (m, 3)."""
    corners: NDArray[np.float64] = mesh.vertices[mesh.faces]
    return corners, corners.min(axis=1), corners.max(axis=1)


def _least_of_triangles(mesh: Mesh, a: Point, b: Point, within: float) -> tuple[float, float]:
    import numpy as np

    corners, low, high = _triangles(mesh)
    begin, way = np.array(a), np.array(b) - np.array(a)
    # Those in whose boxes, with a margin, the way is for a part of it; a way of 0 counts as short.
    pace = np.where(np.abs(way) < 1e-9, 1e-9, way)
    one, two = (low - within - begin) / pace, (high + within - begin) / pace
    enter, leave = np.minimum(one, two).max(axis=1), np.maximum(one, two).min(axis=1)
    near = (enter <= leave) & (enter <= 1) & (leave >= 0)
    if not near.any():
        return inf, 0.0
    corners = corners[near]
    first, last = np.zeros(len(corners)), np.ones(len(corners))

    def distances(shares: NDArray[np.float64]) -> NDArray[np.float64]:
        return _from_triangles(corners, begin + shares[:, None] * way)

    one, two = 1 - _GOLDEN * (last - first), _GOLDEN * (last - first)
    length, width = float(np.linalg.norm(way)), 1.0
    while width * length > _PRECISION:
        left = distances(one) <= distances(two)
        first, last = np.where(left, first, one), np.where(left, two, last)
        one, two = last - _GOLDEN * (last - first), first + _GOLDEN * (last - first)
        width *= _GOLDEN
    shares = np.stack([first, (first + last) / 2, last])
    found = np.stack([distances(row) for row in shares])
    row, column = np.unravel_index(found.argmin(), found.shape)
    return float(found[row, column]), float(shares[row, column])


def _top_of_mesh(mesh: Mesh, pose: Pose, place: Point, ground: float) -> float:
    """The height at which the way straight down from a place meets a mesh, or that of the ground.

    All triangles at once, after T. Möller and B. Trumbore, *Fast, minimum storage ray/triangle
    intersection*, 1997.
    """
    import numpy as np

    corners, _, _ = _triangles(mesh)
    begin = np.array(_in_frame(place, pose))
    way = np.array(_in_frame(place._replace(z=ground), pose)) - begin
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal, out = np.cross(way, second), begin - corners[:, 0]
    across = np.cross(out, first)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1 / np.einsum("ij,ij->i", first, normal)
        u, v = np.einsum("ij,ij->i", out, normal) * scale, across @ way * scale
        shares = np.einsum("ij,ij->i", second, across) * scale
        met = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (shares >= 0) & (shares <= 1)
    return place.z - float(shares[met].min()) * (place.z - ground) if met.any() else ground


def _from_triangles(
    corners: NDArray[np.float64], places: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The distance of each place (m, 3) from its own triangle (m, 3, 3)."""
    import numpy as np

    def dot(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        products: NDArray[np.float64] = np.einsum("ij,ij->i", u, v)
        return products

    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    above = np.ones(len(corners), dtype=bool)
    nearest = np.full(len(corners), inf)
    for begin, end in ((0, 1), (1, 2), (2, 0)):
        origin, edge = corners[:, begin], corners[:, end] - corners[:, begin]
        out = places - origin
        above &= dot(np.cross(edge, out), normal) >= 0
        share = np.clip(dot(out, edge) / np.maximum(dot(edge, edge), 1e-300), 0.0, 1.0)
        rest = out - share[:, None] * edge
        nearest = np.minimum(nearest, np.sqrt(dot(rest, rest)))
    size = np.sqrt(dot(normal, normal))
    height = np.abs(dot(places - corners[:, 0], normal)) / np.maximum(size, 1e-300)
    found: NDArray[np.float64] = np.where(above & (size > 0), height, nearest)
    return found
