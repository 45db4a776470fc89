"""Things that move along their paths in Bullet, and carry what stands on them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hal.sim.physics import GRAVITY, STEP
from hal.sim.shapes import Piece, compound
from vencejo.geometry import product
from worlds.motion import pose_at
from worlds.things import Thing

_HEAVY = 1e6
"""Kilograms (and kg·m²): no vehicle pushes it off its path."""


class Mover:
    """A body too heavy to be pushed, with a velocity that takes it to the next place of its path.

    The velocity is reckoned from where the body is, so no drift can grow. What stands on the body
    feels that velocity; put from place to place, the body would slide away below it.
    """

    def __init__(self, p: Any, client: int, thing: Thing, pieces: Sequence[Piece]) -> None:
        self._p, self._client, self._thing = p, client, thing
        self.body: int = p.createMultiBody(
            _HEAVY, compound(p, client, pieces), -1, *pose_at(thing, 0.0), physicsClientId=client
        )
        p.changeDynamics(
            self.body,
            -1,
            localInertiaDiagonal=(_HEAVY, _HEAVY, _HEAVY),
            linearDamping=0,
            angularDamping=0,
            physicsClientId=client,
        )

    def aim(self, time: float) -> None:
        """Be where the path is at a time, after one step."""
        p, body, client = self._p, self.body, self._client
        (x, y, z), (i, j, k, w) = p.getBasePositionAndOrientation(body, client)
        target, attitude = pose_at(self._thing, time)
        turn = product(attitude, (-i, -j, -k, w))
        pace = 2 / STEP if turn[3] >= 0 else -2 / STEP
        p.resetBaseVelocity(
            body,
            # The step adds gravity before it moves the body.
            ((target.x - x) / STEP, (target.y - y) / STEP, (target.z - z) / STEP + GRAVITY * STEP),
            (turn[0] * pace, turn[1] * pace, turn[2] * pace),
            client,
        )
