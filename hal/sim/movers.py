"""Bodies in Bullet that follow the paths of moving things and carry bodies on top."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, copysign, hypot
from typing import Any

from hal.sim.collision_shapes import Piece, compound
from hal.sim.physics import GRAVITY, STEP
from vencejo.geometry import product
from worlds.motion import STRETCH, pose_at
from worlds.things import Thing

_MASS = 1e6
"""Mass in kg, and each moment of inertia in kg·m²: no vehicle pushes it off its path."""
_STRETCH_STEPS = round(STRETCH / STEP)
"""Physics steps of a stretch, on which the body moves in a straight line."""


class Mover:
    """A body that follows the path of a thing, too heavy for vehicles to push.

    Its velocity leads from its present pose to the next one on the path, so errors do not add up.
    Friction carries bodies on top along, which a body that is moved by its pose alone does not do.
    """

    def __init__(self, p: Any, client: int, thing: Thing, pieces: Sequence[Piece]) -> None:
        self._p, self._client, self._thing = p, client, thing
        self._velocity = self._turning = (0.0, 0.0, 0.0)
        self.body: int = p.createMultiBody(
            _MASS, compound(p, client, pieces), -1, *pose_at(thing, 0.0), physicsClientId=client
        )
        p.changeDynamics(
            self.body,
            -1,
            localInertiaDiagonal=(_MASS, _MASS, _MASS),
            linearDamping=0,
            angularDamping=0,
            physicsClientId=client,
        )

    def drive(self, steps: int) -> None:
        """Set the velocity for the next physics step; ``steps`` were made before it."""
        if steps % _STRETCH_STEPS == 0:
            self._aim((steps + _STRETCH_STEPS) * STEP)
        self._p.resetBaseVelocity(self.body, self._velocity, self._turning, self._client)

    def _aim(self, time: float) -> None:
        """Set the velocities that lead to the pose on the path at a time, one stretch ahead."""
        p, body, client = self._p, self.body, self._client
        (x, y, z), (i, j, k, w) = p.getBasePositionAndOrientation(body, client)
        target, attitude = pose_at(self._thing, time)
        turn = product(attitude, (-i, -j, -k, w))
        per_second = 1 / (_STRETCH_STEPS * STEP)
        # A step adds gravity before it moves the body.
        climb = (target.z - z) * per_second + GRAVITY * STEP
        self._velocity = ((target.x - x) * per_second, (target.y - y) * per_second, climb)
        sine = hypot(*turn[:3])
        angle = 2 * atan2(sine, abs(turn[3]))
        rate = copysign(angle / sine * per_second, turn[3]) if sine else 0.0
        self._turning = (turn[0] * rate, turn[1] * rate, turn[2] * rate)
