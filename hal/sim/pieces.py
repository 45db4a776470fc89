"""The solid pieces of things, of which every engine makes its collision shapes. Metres."""

from __future__ import annotations

from typing import NamedTuple

from vencejo.geometry import Point, Quaternion
from worlds.solids import part_pose, solid_parts
from worlds.things import Shape, Thing


class Piece(NamedTuple):
    """A shape in the frame of the body that it belongs to."""

    name: str
    """Name of the thing that it is part of."""
    shape: Shape
    at: Point
    attitude: Quaternion


def pieces_of(thing: Thing) -> list[Piece]:
    """The solid pieces of a thing: in the world frame, or in its own where it moves."""
    if thing.motion is None:
        return [
            Piece(thing.name, part.shape, *part_pose(part, thing.at, thing.attitude))
            for part in solid_parts(thing)
        ]
    return [Piece(thing.name, part.shape, part.at, part.attitude) for part in solid_parts(thing)]
