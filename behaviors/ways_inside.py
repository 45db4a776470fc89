"""The shortest ways inside an area.

The visibility graph: T. Lozano-Pérez, M. Wesley, *An Algorithm for Planning Collision-Free Paths
Among Polyhedral Obstacles*, 1979.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import dist, hypot, inf
from typing import Any

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Polygon
from shapely.geometry.polygon import orient

from behaviors.polygons import ROOM, SMALL, polygons
from vencejo.polylines import XY


class WaysInside:
    """The shortest ways inside an area: straight, or round its inner corners."""

    def __init__(self, area: Polygon | MultiPolygon) -> None:
        self._area = area.buffer(1e-4, join_style="mitre")
        shapely.prepare(self._area)
        self._known: dict[XY, Any] = {}
        self._corners = [
            self._cleared(*corner)
            for part in polygons(area)
            for outline in (orient(part).exterior, *orient(part).interiors)
            for corner in _inner_corners([(x, y) for x, y in outline.coords[:-1]])
        ]
        count = len(self._corners)
        self._ways = np.full((count, count), inf)
        self._next = np.tile(np.arange(count), (count, 1))
        if not count:
            return
        np.fill_diagonal(self._ways, 0.0)
        for k, corner in enumerate(self._corners):
            self._ways[k] = np.minimum(self._ways[k], self._seen_from(corner))
        for k in range(count):  # Floyd and Warshall
            through = self._ways[:, k, None] + self._ways[None, k, :]
            shorter = through < self._ways - SMALL
            self._ways = np.where(shorter, through, self._ways)
            self._next = np.where(shorter, self._next[:, k, None], self._next)

    def _cleared(self, corner: XY, away: XY) -> XY:
        """A place beside a corner, with some room if the area has it there."""
        for clear in (ROOM, ROOM / 3):
            place = (corner[0] + clear * away[0], corner[1] + clear * away[1])
            if shapely.covers(self._area, LineString([corner, place])):
                return place
        return corner

    def _seen_from(self, place: XY) -> Any:
        """The straight distances from a place to all corners; infinite where none is inside."""
        if place not in self._known:
            self._known[place] = self._distances(place)
        return self._known[place]

    def _distances(self, place: XY) -> Any:
        ends = np.array(self._corners)
        lines = shapely.linestrings(np.stack([np.broadcast_to(place, ends.shape), ends], axis=1))
        straight = np.hypot(*(ends - place).T)
        return np.where(shapely.covers(self._area, lines), straight, inf)

    def way(self, a: XY, b: XY) -> list[XY]:
        """The corners between two places; none where the way is straight, or nothing helps."""
        if dist(a, b) < SMALL or shapely.covers(self._area, LineString([a, b])):
            return []
        if not self._corners:
            return []
        total = self._seen_from(a)[:, None] + self._ways + self._seen_from(b)[None, :]
        here, last = np.unravel_index(int(np.argmin(total)), total.shape)
        if total[here, last] == inf:
            return []
        found = [int(here)]
        while found[-1] != last:
            found.append(int(self._next[found[-1], last]))
        return [self._corners[k] for k in found]


def _inner_corners(outline: Sequence[XY]) -> Iterable[tuple[XY, XY]]:
    """The corners of an outline round which a way can lead, and the direction away from each.

    The area lies left of the outline.
    """
    for before, corner, after in zip(
        [outline[-1], *outline[:-1]], outline, [*outline[1:], outline[0]], strict=True
    ):
        ux, uy = _unit(before, corner)
        vx, vy = _unit(corner, after)
        if ux * vy - uy * vx < -SMALL:
            away = (ux - vx, uy - vy)
            size = hypot(*away)
            yield corner, (away[0] / size, away[1] / size)


def _unit(a: XY, b: XY) -> XY:
    length = dist(a, b) or 1.0
    return (b[0] - a[0]) / length, (b[1] - a[1]) / length
