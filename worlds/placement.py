"""The placement of things as world files write it: place and heading, or a path to follow."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi
from typing import Any

from vencejo.geometry import Point, yaw_quaternion
from worlds import curves
from worlds.terrain import on_ground, place_of
from worlds.things import Motion, Part, Terrain, Thing
from worlds.values import (
    ANGLE_VALUE,
    CHARGING,
    FLAG,
    SPEED_VALUE,
    SPOT,
    Field,
    Misfit,
    Spot,
    Value,
    array,
    record,
)

_MOST_BEND = pi / 60
"""Of a smooth path's samples, radians: a thing that follows it faces along it, but for half."""


@dataclass(frozen=True, slots=True)
class PathDraft:
    """A path as written; the world gives it heights."""

    through: tuple[Spot, ...]
    speed: float
    loop: bool
    smooth: bool
    turns: bool

    def motion(self, terrain: Terrain | None) -> Motion:
        """The motion along the path; a smooth one is sampled.

        A path without any height lies on the ground all along.
        """
        points: list[tuple[float, ...]] = [place_of(terrain, spot) for spot in self.through]
        if self.smooth:
            points = curves.smooth(points, self.loop, _MOST_BEND)
        elif self.loop:
            points.append(points[0])
        if terrain is not None and all(spot.z is None for spot in self.through):
            points = [*on_ground(terrain, points)]
        if self.loop:
            points.pop()
        return Motion(tuple(Point(*p) for p in points), self.speed, self.loop, self.turns)


@dataclass(frozen=True, slots=True)
class ThingDraft:
    """A thing as written; the world gives it a name and a height."""

    kind: str
    parts: tuple[Part, ...]
    solid: bool
    spot: Spot
    heading: float
    moves: PathDraft | None
    charges: float = 0.0

    def thing(self, name: str, terrain: Terrain | None) -> Thing:
        """The thing of that name; one that moves begins where its path begins."""
        motion = self.moves.motion(terrain) if self.moves else None
        at = motion.points[0] if motion else place_of(terrain, self.spot)
        attitude = yaw_quaternion(self.heading)
        return Thing(name, self.kind, at, attitude, self.parts, self.solid, motion, self.charges)


def _moves(**keys: Any) -> PathDraft:
    if len(curves.without_repeats(keys["through"])) < len(keys["through"]):
        raise Misfit("bad-path", "a point stands twice in a row in this path", "through")
    if keys["loop"] and keys["through"][0] == keys["through"][-1]:
        raise Misfit(
            "bad-path",
            "a loop leads back by itself; its last point is its first here",
            "through",
            "leave the last point out",
        )
    return PathDraft(**keys)


MOVES = record(
    "a path",
    {
        "through": Field(array("a path is a list of two places or more", SPOT, 2)),
        "speed": Field(SPEED_VALUE),
        "loop": Field(FLAG, False),
        "smooth": Field(FLAG, False),
        "turns": Field(FLAG, True),
    },
    _moves,
)


def placed(
    kind: str,
    keys: Mapping[str, Field],
    parts: Callable[..., tuple[Part, ...]],
    *,
    solid: bool = True,
    what: str = "",
    may_charge: bool = False,
) -> Value[ThingDraft]:
    """A kind of thing: its own keys, beside those of its placement.

    ``parts`` makes its parts of the values of its own keys; ``what`` names it in errors. One that
    ``may_charge`` has the key ``charges``.
    """
    what = what or f"a {kind}"

    def build(
        at: Spot | None,
        heading: float,
        moves: PathDraft | None,
        charges: float = 0.0,
        **own: Any,
    ) -> ThingDraft:
        if at is None and moves is None:
            raise Misfit("missing-key", f"{what} needs 'at'")
        if at is not None and moves is not None:
            raise Misfit(
                "two-places",
                f"{what} that moves has no 'at': it begins where its path begins",
                "at",
                "leave it out, or make it the first point of 'through'",
            )
        spot = at or Spot(0.0, 0.0)
        return ThingDraft(kind, parts(**own), solid, spot, heading, moves, charges)

    placement = {
        "at": Field(SPOT, None),
        "heading": Field(ANGLE_VALUE, 0.0),
        "moves": Field(MOVES, None),
        **({"charges": Field(CHARGING, 0.0)} if may_charge else {}),
    }
    value = record(what, {**placement, **keys}, build)
    either = {"oneOf": [{"required": ["at"]}, {"required": ["moves"]}]}
    return Value(value.read, {**value.schema, **either})
