"""The start poses of vehicles. World frame, metres, radians."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hal.vehicle import VehicleSpec
from vencejo.errors import UserError
from vencejo.geometry import Point
from worlds.starts import PlannedStart, bad_starts, overlapping, starts_for
from worlds.terrain import highest_under
from worlds.things import Color, Terrain
from worlds.world import Start, World


class StartPose(NamedTuple):
    """How a vehicle stands when the run begins: level, with no corner in a hill."""

    home: Point
    """The place of the start in the world."""
    heading: float
    color: Color | None
    """That the world gives to a vehicle that starts here."""
    raised: float
    """Height of its skids above home: on a slope it drops on its uphill side."""


def start_poses(
    world: World, vehicles: Sequence[VehicleSpec], sizes: Sequence[tuple[float, float, float]]
) -> list[StartPose]:
    """The start pose of each vehicle (see :func:`worlds.starts.starts_for`).

    ``sizes``: of each along its axes. Raises UserError (``bad-vehicles``,
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
    widest, highest = max(max(size[:2]) for size in sizes), max(size[2] for size in sizes)
    faults += overlapping(planned, widest, highest)
    if faults:
        raise UserError.of(faults)
    return [
        StartPose(start.at, start.heading, start.color, _raised(terrain, start, size))
        for start, size in zip(starts, sizes, strict=True)
    ]


def _raised(terrain: Terrain | None, start: Start, size: tuple[float, float, float]) -> float:
    if terrain is None:
        return 0.0
    return max(0.0, highest_under(terrain, start.at, start.heading, size) - start.at.z)
