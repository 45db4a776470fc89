"""A height grid of obstacles: above these heights contacts are impossible."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise, product
from math import ceil, dist, hypot, inf
from typing import NamedTuple

from vencejo.geometry import Point
from worlds.motion import track_of
from worlds.solids import bounds_of, part_pose, solid_parts
from worlds.terrain import highest_under
from worlds.things import Terrain, Thing

_CELL = 2.0
"""Side of a cell, metres."""
_WAY = 0.15
"""Most by which a vehicle leaves the straight way of a mission period, and engines tell of a
contact before it is one, metres."""
_LARGEST = 200.0
"""Length above which an obstacle counts in every cell, metres."""


class ObstacleHeightGrid:
    """The obstacles in each cell over the ground, with a margin for the vehicle.

    World frame, metres. Moving things count along their whole path.
    """

    def __init__(self, things: Iterable[Thing], terrain: Terrain | None, reach: float) -> None:
        """``reach``: how far a vehicle reaches from its centre, metres."""
        self._terrain = terrain
        self._margin = margin = reach + _WAY
        self._highest = margin + (max(map(max, terrain.heights)) if terrain else 0.0)
        """Height above which no vehicle touches the ground, metres."""
        self._ground: dict[tuple[int, int], float] = {}
        """The same in the cells that have been asked for."""
        self._everywhere = -inf
        """Height of the highest obstacle that counts in every cell."""
        self._cells: dict[tuple[int, int], list[_Obstacle]] = {}
        for thing in things:
            for obstacle in _obstacles(thing, margin):
                self._add(obstacle)

    def _add(self, obstacle: _Obstacle) -> None:
        low_x, low_y, high_x, high_y, top = obstacle
        if max(high_x - low_x, high_y - low_y) > _LARGEST:
            self._everywhere = max(self._everywhere, top)
            return
        columns = range(int(low_x // _CELL), int(high_x // _CELL) + 1)
        rows = range(int(low_y // _CELL), int(high_y // _CELL) + 1)
        for cell in product(columns, rows):
            self._cells.setdefault(cell, []).append(obstacle)

    def thing_near(self, x: float, y: float, z: float) -> bool:
        """Whether a vehicle at a place can touch a thing in this mission period."""
        if z < self._everywhere:
            return True
        for low_x, low_y, high_x, high_y, top in self._cells.get(
            (int(x // _CELL), int(y // _CELL)), ()
        ):
            if low_x < x < high_x and low_y < y < high_y and z < top:
                return True
        return False

    def ground_near(self, x: float, y: float, z: float) -> bool:
        """Whether a vehicle at a place can touch the ground in this mission period."""
        if z >= self._highest:
            return False
        if self._terrain is None:
            return True
        cell = int(x // _CELL), int(y // _CELL)
        top = self._ground.get(cell)
        if top is None:
            middle = Point((cell[0] + 0.5) * _CELL, (cell[1] + 0.5) * _CELL, 0.0)
            side = _CELL + 2 * self._margin
            top = self._margin + highest_under(self._terrain, middle, 0.0, (side, side, 0.0))
            self._ground[cell] = top
        return z < top


class _Obstacle(NamedTuple):
    """A rectangle over the ground, and the height up to which contacts are possible in it."""

    low_x: float
    low_y: float
    high_x: float
    high_y: float
    top: float


def _obstacles(thing: Thing, margin: float) -> Iterator[_Obstacle]:
    """The obstacle of each solid part of a thing, with a margin for the vehicle."""
    origin = Point(0.0, 0.0, 0.0)
    for part in solid_parts(thing):
        if thing.motion is None:
            pose = part_pose(part, thing.at, thing.attitude)
            low, high = bounds_of(part.shape, *pose)
            yield _Obstacle(
                low.x - margin, low.y - margin, high.x + margin, high.y + margin, high.z + margin
            )
            continue
        low, high = bounds_of(part.shape, *part_pose(part, origin, thing.attitude))
        reach = margin + max(hypot(x, y) for x, y in product((low.x, high.x), (low.y, high.y)))
        for x, y, z in _along(track_of(thing.motion).corners):
            yield _Obstacle(x - reach, y - reach, x + reach, y + reach, z + high.z + margin)


def _along(corners: tuple[Point, ...]) -> Iterator[Point]:
    """Places along a path, less than half a cell apart."""
    for a, b in pairwise(corners):
        count = ceil(2 * dist(a, b) / _CELL)
        step = b.minus(a)
        for k in range(count + 1):
            share = k / count
            yield a.plus((step.x * share, step.y * share, step.z * share))
