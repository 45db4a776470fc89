"""Terrain: heights of the ground, and how they are written."""

from __future__ import annotations

from worlds.things import Terrain
from worlds.values import COORDINATE, SIZE, Field, Misfit, array, record


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
