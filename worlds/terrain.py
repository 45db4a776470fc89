"""Hills: the height of the ground."""

from __future__ import annotations

from worlds.things import Terrain
from worlds.values import COORDINATE, SIZE, Field, Misfit, array, record


def height_at(terrain: Terrain | None, x: float, y: float) -> float:
    """World height of the ground, metres: between four given heights, as a twisted plane."""
    if terrain is None:
        return 0.0
    rows, last = terrain.heights, len(terrain.heights) - 1
    column, row = ((v / terrain.size + 0.5) * last for v in (x, y))
    if not (0 <= column <= last and 0 <= row <= last):
        return rows[0][0]
    i, j = min(int(row), last - 1), min(int(column), last - 1)
    up, right = row - i, column - j
    south = rows[i][j] + (rows[i][j + 1] - rows[i][j]) * right
    north = rows[i + 1][j] + (rows[i + 1][j + 1] - rows[i + 1][j]) * right
    return south + (north - south) * up


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
