"""Bodies in Bullet that follow the paths of moving things and carry bodies on top."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hal.sim.collision_shapes import compound
from hal.sim.physics import GRAVITY, STEP
from hal.sim.pieces import Piece
from hal.sim.stretches import STRETCH_STEPS, STRETCH_TIME, velocities
from vencejo.geometry import Point
from worlds.motion import pose_at
from worlds.things import Thing

_MASS = 1e6
"""Mass in kg, and each moment of inertia in kg·m²: no vehicle pushes it off its path."""


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
        if steps % STRETCH_STEPS == 0:
            self._aim((steps + STRETCH_STEPS) * STEP)
        self._p.resetBaseVelocity(self.body, self._velocity, self._turning, self._client)

    def _aim(self, time: float) -> None:
        """Set the velocities that lead to the pose on the path at a time, one stretch ahead."""
        now = self._p.getBasePositionAndOrientation(self.body, self._client)
        begin = Point(*now[0]), now[1]
        (east, north, up), self._turning = velocities(
            begin, pose_at(self._thing, time), STRETCH_TIME
        )
        # A step adds gravity before it moves the body.
        self._velocity = east, north, up + GRAVITY * STEP
