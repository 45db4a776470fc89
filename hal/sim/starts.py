"""The start poses of vehicles. World frame, metres, radians."""

from __future__ import annotations

from typing import NamedTuple

from vencejo.errors import UserError
from vencejo.geometry import Point
from worlds.solids import thing_near
from worlds.terrain import height_at, highest_under
from worlds.things import Terrain
from worlds.world import Start, World

_ABREAST = 2.0
"""Distance along x between vehicles for which the world has no start of its own, metres."""


class StartPose(NamedTuple):
    """How a vehicle stands when the run begins: level, with no corner in a hill."""

    home: Point
    """The place of the start in the world."""
    heading: float
    raised: float
    """Height of its skids above home: on a slope it drops on its uphill side."""


def start_poses(
    world: World, names: tuple[str, ...], size: tuple[float, float, float]
) -> list[StartPose]:
    """The start pose of each vehicle: the world's starts, then further ones beside the last.

    ``size``: of the vehicles along their axes. Raises UserError (``bad-vehicles``,
    ``start-in-thing``).
    """
    if not names or len(set(names)) != len(names):
        raise UserError("bad-vehicles", f"vehicles need names that differ, not {list(names)}")
    terrain = world.ground.terrain
    starts = list(world.starts[: len(names)])
    while len(starts) < len(names):
        starts.append(_beside(starts[-1], terrain))
    for name, start in zip(names, starts, strict=True):
        thing = thing_near(world.things, start.at)
        if thing is not None:
            raise UserError(
                "start-in-thing",
                f"'{name}' would start in the {thing.kind} '{thing.name}' of '{world.name}'",
                hint=f"give the world {len(names)} starts",
            )
    return [
        StartPose(at, heading, _raised(terrain, at, heading, size))
        for at, heading in ((start.at, start.heading) for start in starts)
    ]


def _beside(start: Start, terrain: Terrain | None) -> Start:
    """A start beside another, as high above the ground."""
    x, y, z = start.at
    above = z - height_at(terrain, x, y)
    return Start(Point(x + _ABREAST, y, height_at(terrain, x + _ABREAST, y) + above), start.heading)


def _raised(
    terrain: Terrain | None, at: Point, heading: float, size: tuple[float, float, float]
) -> float:
    if terrain is None:
        return 0.0
    return max(0.0, highest_under(terrain, at, heading, size) - at.z)
