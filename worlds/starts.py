"""The starts of vehicles in a world: where each stands, and what is wrong with a start."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

from vencejo.errors import Fault, Severity, Where
from vencejo.geometry import Point, horizontal_distance
from worlds.fence import surrounds
from worlds.solids import START_CLEARANCE, thing_near, top_of
from worlds.terrain import height_at
from worlds.things import Terrain, Thing
from worlds.world import Fence, Start, World

_ABREAST = 2.0
"""Distance along x between vehicles for which the world has no start of its own, metres."""


class PlannedStart(NamedTuple):
    """A start, with what messages say of it."""

    start: Start
    where: Where | None
    """The place that names it; None for none."""
    who: str = "a vehicle"


def starts_for(world: World, given: Sequence[Start | None]) -> list[Start]:
    """The start of each of several vehicles: the one ``given`` to it, or else the next of the
    world's own starts, or a further one beside the last of these, where none of the given ones is.
    """
    taken = [start.at for start in given if start is not None]
    own = (each for each in _own_starts(world) if not any(_overlap(each.at, at) for at in taken))
    return [start or next(own) for start in given]


def _overlap(a: Point, b: Point) -> bool:
    near = horizontal_distance(a, b) < 2 * START_CLEARANCE
    return near and abs(a.z - b.z) < START_CLEARANCE


def _own_starts(world: World) -> Iterator[Start]:
    yield from world.starts
    start, terrain = world.starts[-1], world.ground.terrain
    while True:
        start = _beside(start, terrain)
        yield start


def _beside(start: Start, terrain: Terrain | None) -> Start:
    """A start beside another, as high above the ground."""
    x, y, z = start.at
    above = z - height_at(terrain, x, y)
    return Start(Point(x + _ABREAST, y, height_at(terrain, x + _ABREAST, y) + above), start.heading)


def bad_starts(
    planned: Sequence[PlannedStart], things: Sequence[Thing], terrain: Terrain | None
) -> Iterator[Fault]:
    """Faults for starts in things or in the ground."""
    for start, where, who in planned:
        ground = height_at(terrain, start.at.x, start.at.y)
        thing = thing_near(things, start.at)
        if thing is not None:
            yield Fault(
                "start-in-thing",
                f"{who} would start in the {thing.kind} '{thing.name}'",
                where,
                f"keep {START_CLEARANCE:g} m away from it, or start on top with z = "
                f"{top_of(thing):g}",
            )
        elif start.at.z < ground:
            yield Fault(
                "start-in-ground",
                f"{who} would start below the ground, which is at {ground:g} m",
                where,
                "leave z out to start on the ground",
            )


def overlapping(
    planned: Sequence[PlannedStart],
    apart: float = 2 * START_CLEARANCE,
    height: float = START_CLEARANCE,
    severity: Severity = "error",
) -> Iterator[Fault]:
    """Faults for starts that are nearer to each other than ``apart`` on the map and ``height`` up,
    metres.
    """
    for one, other in combinations(planned, 2):
        a, b = one.start.at, other.start.at
        if horizontal_distance(a, b) < apart and abs(a.z - b.z) < height:
            earlier = one.who if one.who != other.who else "another"
            yield Fault(
                "starts-overlap",
                f"{other.who} would start {horizontal_distance(a, b):.2g} m from {earlier}",
                other.where or one.where,
                f"starts lie {apart:g} m apart or more",
                severity,
            )


def starts_outside(planned: Sequence[PlannedStart], fence: Fence | None) -> Iterator[Fault]:
    """Faults for starts outside the fence."""
    for start, where, who in planned:
        if fence is not None and not surrounds(fence, start.at.x, start.at.y):
            yield Fault(
                "start-outside-fence",
                f"{who} would start outside the fence",
                where,
                "draw the fence round the starts, or move the start",
            )
