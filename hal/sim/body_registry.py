"""Bullet's bodies and the things that they stand for: names and velocities at contacts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from hal.sim.physics import Triple
from hal.sim.pieces import Piece
from vencejo.geometry import Point, Quaternion, turned
from worlds.solids import distance_to

_CELLS_PER_METRE = 50


class BodyPieces(NamedTuple):
    """The collision shapes of a body; the ground has none."""

    pieces: Sequence[Piece] = ()
    moves: bool = False
    """True for a moving body, whose pieces all belong to one thing."""
    free: bool = False
    """True for a free body, whose path nothing determines."""


class BodyRegistry:
    """The pieces of each body, by Bullet's body id."""

    def __init__(self, p: Any, client: int) -> None:
        self._p, self._client = p, client
        self._bodies: dict[int, BodyPieces] = {}
        self._names: dict[tuple[int, ...], str] = {}
        """Cache of names, by body and cell of space."""
        self.has_movers = False
        """True when a thing moves along a path."""

    def add(self, body: int, pieces: BodyPieces) -> None:
        self._bodies[body] = pieces
        self.has_movers = self.has_movers or self.is_mover(body)

    def name_at(self, body: int, place: Triple) -> str:
        """The name of the thing of a body that is touched at a place (world frame, metres).

        It is empty for the ground. Bullet does not report which shape of a body a contact is with:
        it is the nearest one.
        """
        pieces, moves, _ = self._bodies[body]
        if len(pieces) <= 1 or moves:
            return pieces[0].name if pieces else ""
        # A vehicle that presses against a thing touches it in the same cells, step after step.
        cell = (body, *(round(v * _CELLS_PER_METRE) for v in place))
        if cell not in self._names:
            there = Point(*place)
            self._names[cell] = min(pieces, key=lambda piece: _distance(piece, there)).name
        return self._names[cell]

    def is_mover(self, body: int) -> bool:
        """Whether it moves along a path."""
        pieces = self._bodies[body]
        return pieces.moves and not pieces.free

    def is_free(self, body: int) -> bool:
        """Whether it is a free body."""
        return self._bodies[body].free

    def velocity_at(self, body: int, place: Triple) -> Triple:
        """The velocity of a body at a place (world frame), m/s."""
        if not self._bodies[body].moves:
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
