"""The start poses of vehicles. World frame, metres, radians."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hal.vehicle import VehicleSpec
from vencejo.errors import UserError
from vencejo.geometry import Point
from worlds.starts import PlannedStart, bad_starts, overlapping, starts_for
from worlds.terrain import highest_under
from worlds.things import Terrain
from worlds.world import World


class StartPose(NamedTuple):
    """How a vehicle stands when the run begins: level, with no corner in a hill."""

    home: Point
    """The place of the start in the world."""
    heading: float
    raised: float
    """Height of its skids above home: on a slope it drops on its uphill side."""


def start_poses(
    world: World, vehicles: Sequence[VehicleSpec], size: tuple[float, float, float]
) -> list[StartPose]:
    """The start pose of each vehicle (see :func:`worlds.starts.starts_for`).

    ``size``: of the vehicles along their axes. Raises UserError (``bad-vehicles``,
    ``start-in-thing``, ``start-in-ground``, ``starts-overlap``).
    """
    names = [vehicle.name for vehicle in vehicles]
    if not names or len(set(names)) != len(names):
        raise UserError("bad-vehicles", f"vehicles need names that differ, not {names}")
    starts = starts_for(world, [vehicle.start for vehicle in vehicles])
    planned = [
        PlannedStart(start, None, f"'{name}'") for name, start in zip(names, starts, strict=True)
    ]
    terrain = world.ground.terrain
    faults = list(bad_starts(planned, world.things, terrain))
    faults += overlapping(planned, max(size[:2]), size[2])
    if faults:
        raise UserError.of(faults)
    return [
        StartPose(at, heading, _raised(terrain, at, heading, size))
        for at, heading in ((start.at, start.heading) for start in starts)
    ]


def _raised(
    terrain: Terrain | None, at: Point, heading: float, size: tuple[float, float, float]
) -> float:
    if terrain is None:
        return 0.0
    return max(0.0, highest_under(terrain, at, heading, size) - at.z)
