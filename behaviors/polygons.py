"""Areas as polygons, of one part or several, with holes. Metres over the ground."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import shapely
from shapely import MultiPolygon, Polygon

from behaviors.plan import Unflyable
from vencejo.polylines import XY

SMALL = 1e-6
"""Lengths, m, and areas, m², below this are none."""
ROOM = 0.3
"""Distance that ways keep from the corners and edges of an area where there is room, metres."""


def area_of(corners: Sequence[XY], holes: Sequence[Sequence[XY]] = ()) -> Polygon | MultiPolygon:
    """The area inside corners without some holes; all outlines must be simple.

    Raises Unflyable for corners about nothing, and where the holes leave nothing.
    """
    area = Polygon(corners)
    if area.area <= SMALL:
        raise Unflyable("this area has no extent", "area")
    for hole in holes:
        area = area.difference(Polygon(hole))
    parts = [part for part in polygons(area) if part.area > SMALL]
    if not parts:
        raise Unflyable("the holes leave nothing of this area", "holes")
    return parts[0] if len(parts) == 1 else MultiPolygon(parts)


def polygons(geometry: Any) -> list[Polygon]:
    """The polygons in a geometry, without the points and lines."""
    return [part for part in shapely.get_parts(geometry) if isinstance(part, Polygon)]


def outlines(area: Polygon | MultiPolygon) -> Iterable[Any]:
    """The outer outlines of an area, and those of its holes."""
    for part in polygons(area):
        yield part.exterior
        yield from part.interiors
