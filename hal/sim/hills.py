"""Terrain in Bullet: what bodies stand on, what rays meet, and no way through. World frame, metres.

Bullet's height field is a skin of triangles, which let through whatever has passed it in one step,
as a skid that touches down hard does. So bodies meet the earth under it instead: one convex solid
for each cell, or two.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import cos, hypot, pi
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from hal.sim.physics import STEP, Triple
from vencejo.geometry import Point
from worlds.terrain import height_at
from worlds.things import Terrain

_DEPTH = -1.0
"""Height of the solids' level undersides."""
_MARGIN = 0.001
"""Bullet keeps other bodies this far away from a convex solid."""
_LEVEL = cos(5 * pi / 180)
"""Cosine of the bend from which an edge is a ridge."""


def height_field(p: Any, client: int, terrain: Terrain) -> tuple[int, Point]:
    """Make a height field, for rays alone: its number in Bullet, and the place of its origin.

    Bullet puts the origin half-way between its lowest and its highest point.
    """
    rows, count = terrain.heights, len(terrain.heights)
    side = terrain.size / (count - 1)
    number: int = p.createCollisionShape(
        p.GEOM_HEIGHTFIELD,
        meshScale=[side, side, 1.0],
        heightfieldData=[height for row in rows for height in row],
        numHeightfieldRows=count,
        numHeightfieldColumns=count,
        physicsClientId=client,
    )
    low, high = min(map(min, rows)), max(map(max, rows))
    return number, Point(0.0, 0.0, (low + high) / 2)


def earth(p: Any, client: int, terrain: Terrain) -> int:
    """Add a static body of the terrain's solids, which is not level; its number in Bullet."""
    # The parts of a file are the only way to give one body many convex shapes. Bullet would keep
    # what it read until the process ends.
    p.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)
    with TemporaryDirectory(prefix="vencejo-") as folder:
        path = Path(folder) / "earth.obj"
        path.write_text("".join(map(_part, convex_tops(terrain))), "ascii")
        shape = p.createCollisionShape(p.GEOM_MESH, fileName=str(path), physicsClientId=client)
    # Without a visual shape of its own, Bullet would read the file again.
    visual = p.createVisualShape(p.GEOM_SPHERE, radius=1.0, physicsClientId=client)
    number: int = p.createMultiBody(
        0, shape, visual, (0.0, 0.0, -_MARGIN), useMaximalCoordinates=1, physicsClientId=client
    )
    return number


def convex_tops(terrain: Terrain) -> Iterator[Sequence[Point]]:
    """The corners of parts of the surface with convex solids under them, where it is above 0.

    A cell is one part where its diagonal (see :func:`worlds.terrain.height_at`) is a ridge, and one
    for each triangle where it is a valley.
    """
    rows, last = terrain.heights, len(terrain.heights) - 1
    side = terrain.size / last

    def corner(i: int, j: int) -> Point:
        return Point(j * side - terrain.size / 2, i * side - terrain.size / 2, rows[i][j])

    for i in range(last):
        for j in range(last):
            south_west, south_east = corner(i, j), corner(i, j + 1)
            north_west, north_east = corner(i + 1, j), corner(i + 1, j + 1)
            tops: list[Sequence[Point]]
            if south_east.z + north_west.z >= south_west.z + north_east.z:
                tops = [(south_west, south_east, north_east, north_west)]
            else:
                tops = [(south_west, south_east, north_west), (north_east, north_west, south_east)]
            yield from (top for top in tops if any(point.z > 0 for point in top))


def _part(top: Sequence[Point]) -> str:
    """The part of an OBJ file for the solid under a top; Bullet takes its convex hull."""
    points = [*top, *(Point(x, y, _DEPTH) for x, y, _ in top)]
    lines = ["o solid", *(f"v {x!r} {y!r} {z!r}" for x, y, z in points)]
    # Vertices count from the last one backwards; the hull needs each in some face.
    lines += [f"f -1 -2 -{k}" for k in range(3, len(points) + 1)]
    return "\n".join(lines) + "\n"


class Ridge(NamedTuple):
    """An edge at which the surface bends downwards."""

    begin: Point
    end: Point
    normal: Point
    """Unit vector half-way between the normals of the surface on both sides."""


def ridges(terrain: Terrain) -> Iterator[Ridge]:
    """The edges at which the surface bends downwards by more than a little."""
    last = len(terrain.heights) - 1

    def corner(place: tuple[int, int]) -> Point:
        i, j = place
        x, y = ((k / last - 0.5) * terrain.size for k in (j, i))
        return Point(x, y, terrain.heights[i][j])

    for i, j in product(range(last + 1), repeat=2):
        # Each edge from (i, j) or across its cell, and the corners of the triangles beside it.
        for places in (
            ((i, j), (i, j + 1), (i + 1, j), (i - 1, j + 1)),
            ((i + 1, j), (i, j), (i, j + 1), (i + 1, j - 1)),
            ((i + 1, j), (i, j + 1), (i + 1, j + 1), (i, j)),
        ):
            if all(0 <= k <= last for place in places for k in place):
                ridge = _ridge(*map(corner, places))
                if ridge is not None:
                    yield ridge


def _ridge(begin: Point, end: Point, left: Point, right: Point) -> Ridge | None:
    """The ridge between two places, with others to its left and right, if it is one."""
    along, across = end.minus(begin), right.minus(begin)
    one, other = _upright(along, left.minus(begin)), _upright(across, along)
    if _inner(one, across) >= 0 or _inner(one, other) > _LEVEL:
        return None
    middle = one.plus(other)
    length = middle.norm()
    return Ridge(begin, end, Point(middle.x / length, middle.y / length, middle.z / length))


def _inner(a: Point, b: Point) -> float:
    return a.x * b.x + a.y * b.y + a.z * b.z


def _upright(a: Point, b: Point) -> Point:
    """The unit vector at right angles to two others, as they turn."""
    x, y, z = a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x
    length = hypot(x, y, z)
    return Point(x / length, y / length, z / length)


def slowed_above(terrain: Terrain, at: Triple, velocity: Triple, least: float) -> Triple | None:
    """The velocity that brings a place in the next step as far down as it may go, m/s.

    ``least``: the height above the ground down to which it may. None where it stays above it.
    """
    x, y, z = at
    u, v, w = velocity
    end = z + w * STEP - height_at(terrain, x + u * STEP, y + v * STEP) - least
    if end >= 0.0:
        return None
    begin = z - height_at(terrain, x, y) - least
    if end >= begin:
        return None  # it is on its way out
    share = max(0.0, begin) / (begin - end)
    return u * share, v * share, w * share
