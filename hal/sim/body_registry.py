"""What the bodies in Bullet are: whose surface is at a place, and how it moves there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from hal.sim.collision_shapes import Piece
from hal.sim.physics import Triple
from vencejo.geometry import Point, Quaternion, turned
from worlds.solids import distance_to

_CELLS = 50
"""A metre in cells of two centimetres."""


class Solid(NamedTuple):
    """What a body consists of; the ground has no pieces."""

    pieces: Sequence[Piece] = ()
    moves: bool = False


class Register:
    """The bodies by Bullet's numbers."""

    def __init__(self, p: Any, client: int) -> None:
        self._p, self._client = p, client
        self._solids: dict[int, Solid] = {}
        self._found: dict[tuple[int, ...], str] = {}
        """Names by body and cell."""

    def add(self, body: int, solid: Solid) -> None:
        self._solids[body] = solid

    def name_at(self, body: int, place: Triple) -> str:
        """The name of the thing whose surface is at a place; empty for the ground.

        A contact does not tell which shape of a body it is with, so its place has to. The pieces
        of a body that moves are all of one thing.
        """
        pieces, moves = self._solids[body]
        if len(pieces) <= 1 or moves:
            return pieces[0].name if pieces else ""
        # What presses against a thing touches it in the same places, step after step.
        cell = (body, *(round(v * _CELLS) for v in place))
        if cell not in self._found:
            there = Point(*place)
            self._found[cell] = min(pieces, key=lambda piece: _distance(piece, there)).name
        return self._found[cell]

    def velocity_at(self, body: int, place: Triple) -> Triple:
        """How a body moves at a place, m/s."""
        if not self._solids[body].moves:
            return 0.0, 0.0, 0.0
        (x, y, z), _ = self._p.getBasePositionAndOrientation(body, self._client)
        (u, v, w), (a, b, c) = self._p.getBaseVelocity(body, self._client)
        x, y, z = place[0] - x, place[1] - y, place[2] - z
        return u + b * z - c * y, v + c * x - a * z, w + a * y - b * x


def _distance(piece: Piece, place: Point) -> float:
    return distance_to(piece.shape, turned(place.minus(piece.at), _inverse(piece.attitude)))


def _inverse(attitude: Quaternion) -> Quaternion:
    x, y, z, w = attitude
    return -x, -y, -z, w
