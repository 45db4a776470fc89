"""Outlines of areas: what a person may draw as one."""

from __future__ import annotations

from collections.abc import Sequence

from behaviors.params import Area, Areas
from behaviors.plan import Unflyable
from vencejo.geometry import Point
from vencejo.polylines import XY, crossing_of


def require_simple(outline: Sequence[Point], parameter: str = "area") -> None:
    """Raises Unflyable for an outline that crosses or touches itself, or has under 3 corners.

    ``parameter`` is the name of the one that holds it.
    """
    corners = list(dict.fromkeys((corner.x, corner.y) for corner in outline))
    if len(corners) < 3:
        raise Unflyable("an area has 3 different corners or more", parameter)
    crossed = crossing_of([*corners, corners[0]])
    if crossed is not None:
        where = f"[{crossed[0]:.4g}, {crossed[1]:.4g}]"
        hint = "name its corners in order, as one walks round it"
        message = f"the outline of this area crosses or touches itself near {where}"
        raise Unflyable(message, parameter, hint)


def outlines_of(area: Area, holes: Areas) -> tuple[list[XY], list[list[XY]]]:
    """The outlines of an area and of its holes on the map. Raises as :func:`require_simple`."""
    require_simple(area)
    for hole in holes:
        require_simple(hole, "holes")
    outer, *inner = [[(corner.x, corner.y) for corner in each] for each in (area, *holes)]
    return outer, inner
