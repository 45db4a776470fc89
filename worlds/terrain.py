"""Terrain: heights of the ground, and how they are written."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise
from math import ceil, dist, floor

from vencejo.geometry import Point, rotate_xy
from worlds.things import Terrain
from worlds.values import COORDINATE, SIZE, Field, Misfit, Spot, array, record

_SAME = 1e-6
"""Places on a way that are this near each other are one, metres."""


def height_at(terrain: Terrain | None, x: float, y: float) -> float:
    """The height of the ground at a place, world frame, metres.

    Four neighbouring heights span two triangles, whose common edge runs from the south-east to the
    north-west: the same as in Bullet's height field and in images.
    """
    if terrain is None:
        return 0.0
    rows, last = terrain.heights, len(terrain.heights) - 1
    column, row = ((v / terrain.size + 0.5) * last for v in (x, y))
    if not (0 <= column <= last and 0 <= row <= last):
        return rows[0][0]
    i, j = min(int(row), last - 1), min(int(column), last - 1)
    up, right = row - i, column - j
    (south_west, south_east), (north_west, north_east) = rows[i][j : j + 2], rows[i + 1][j : j + 2]
    if up + right <= 1:
        return south_west + (south_east - south_west) * right + (north_west - south_west) * up
    down, left = 1 - up, 1 - right
    return north_east + (north_west - north_east) * left + (south_east - north_east) * down


def place_of(terrain: Terrain | None, spot: Spot) -> Point:
    """The point of a spot: on the ground, where no height is written."""
    high = height_at(terrain, spot.x, spot.y) if spot.z is None else spot.z
    return Point(spot.x, spot.y, high)


def on_ground(terrain: Terrain, way: Sequence[tuple[float, ...]]) -> list[Point]:
    """The points of a way over the ground, x and y, and further ones where that has edges."""
    places = [way[0][:2]]
    for (x, y), end in pairwise((point[0], point[1]) for point in way):
        crossings = sorted(_crossings(terrain, (x, y), end), key=partial(dist, (x, y)))
        for place in (*crossings, end):
            if dist(places[-1], place) > _SAME:
                places.append(place)
    return [Point(x, y, height_at(terrain, x, y)) for x, y in places]


def highest_under(
    terrain: Terrain, at: Point, heading: float, size: tuple[float, float, float]
) -> float:
    """The height of the highest ground under a level cuboid at a place, metres.

    ``size``: along its axes, of which the first has the heading.
    """
    length, width, _ = size
    corners = []
    for along, across in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)):
        x, y = rotate_xy(along * length, across * width, heading)
        corners.append((at.x + x, at.y + y))
    # The ground is made of triangles: it is highest at a corner of the outline, where an edge of a
    # triangle crosses the outline, or at the tip of triangles within it.
    places = [*corners, *_tips(terrain, corners)]
    for a, b in pairwise(corners):
        places += _crossings(terrain, a, b)
    return max(height_at(terrain, x, y) for x, y in places)


_Place = tuple[float, float]


def _crossings(terrain: Terrain, a: _Place, b: _Place) -> Iterator[_Place]:
    """The places between two where the edges of triangles cross."""
    side = terrain.size / (len(terrain.heights) - 1)
    # In sides of a cell from the south-western corner: along x, y and the diagonals' x + y.
    (x, y), (u, v) = (((w + terrain.size / 2) / side for w in place) for place in (a, b))
    for begin, end in ((x, u), (y, v), (x + y, u + v)):
        low, high = sorted((begin, end))
        for line in range(ceil(low), floor(high) + 1):
            if low < line < high:
                share = (line - begin) / (end - begin)
                yield a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share


def _tips(terrain: Terrain, outline: list[_Place]) -> Iterator[_Place]:
    """The corners of cells within an outline, counter-clockwise and closed."""
    side, half = terrain.size / (len(terrain.heights) - 1), terrain.size / 2
    ranges = [
        range(ceil((min(axis) + half) / side), floor((max(axis) + half) / side) + 1)
        for axis in zip(*outline, strict=True)
    ]
    for column in ranges[0]:
        for row in ranges[1]:
            x, y = column * side - half, row * side - half
            if all((u - s) * (y - t) >= (v - t) * (x - s) for (s, t), (u, v) in pairwise(outline)):
                yield x, y


def _terrain(heights: tuple[tuple[float, ...], ...], size: float) -> Terrain:
    count = len(heights)
    if any(len(row) != count for row in heights):
        raise Misfit("bad-terrain", f"{count} rows of heights need {count} heights each", "heights")
    border = {*heights[0], *heights[-1], *(row[0] for row in heights), *(r[-1] for r in heights)}
    if border != {0.0}:
        raise Misfit(
            "bad-terrain",
            "the heights along the border must be 0, where the flat ground begins",
            "heights",
            "put a row and a column of 0 around them",
        )
    if min(map(min, heights)) < 0:
        raise Misfit("bad-terrain", "no height can be below 0, the flat ground's", "heights")
    return Terrain(heights[::-1], size)


TERRAIN = record(
    "the terrain",
    {
        "heights": Field(
            array(
                "heights are a list of three rows or more, the northern one first",
                array("a row is a list of three heights or more", COORDINATE, 3),
                3,
            )
        ),
        "size": Field(SIZE),
    },
    _terrain,
)
