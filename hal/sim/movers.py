"""Things that move along their paths in Bullet, and carry what stands on them."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, copysign, hypot
from typing import Any

from hal.sim.collision_shapes import Piece, compound
from hal.sim.physics import GRAVITY, STEP
from vencejo.geometry import product
from worlds.motion import STRETCH, pose_at
from worlds.things import Thing

_HEAVY = 1e6
"""Kilograms (and kg·m²): no vehicle pushes it off its path."""
_STRETCH = round(STRETCH / STEP)
"""Steps that it moves straight."""


class Mover:
    """A body too heavy to be pushed, with a velocity that takes it to the next place of its path.

    The velocity is reckoned from where the body is, so no drift can grow. What stands on the body
    feels that velocity; put from place to place, the body would slide away below it.
    """

    def __init__(self, p: Any, client: int, thing: Thing, pieces: Sequence[Piece]) -> None:
        self._p, self._client, self._thing = p, client, thing
        self._velocity = self._turning = (0.0, 0.0, 0.0)
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

    def drive(self, steps: int) -> None:
        """Set the velocity for the next step; ``steps`` were taken before."""
        if steps % _STRETCH == 0:
            self._aim((steps + _STRETCH) * STEP)
        self._p.resetBaseVelocity(self.body, self._velocity, self._turning, self._client)

    def _aim(self, time: float) -> None:
        """Choose the velocity that leads to the place on the path at the end of the stretch."""
        p, body, client = self._p, self.body, self._client
        (x, y, z), (i, j, k, w) = p.getBasePositionAndOrientation(body, client)
        target, attitude = pose_at(self._thing, time)
        turn = product(attitude, (-i, -j, -k, w))
        pace = 1 / (_STRETCH * STEP)
        # A step adds gravity before it moves the body.
        rising = (target.z - z) * pace + GRAVITY * STEP
        self._velocity = ((target.x - x) * pace, (target.y - y) * pace, rising)
        sine = hypot(*turn[:3])
        angle = 2 * atan2(sine, abs(turn[3]))
        rate = copysign(angle / sine * pace, turn[3]) if sine else 0.0
        self._turning = (turn[0] * rate, turn[1] * rate, turn[2] * rate)
