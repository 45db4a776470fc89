"""Moorings in Bullet: what stands on a moving thing with its motors off keeps its place there."""

from __future__ import annotations

from math import dist
from typing import Any

from hal.sim.body_registry import BodyRegistry
from hal.sim.physics import GAP

_HOLD = 10_000.0
"""Largest force of a mooring, newtons: enough where its carrier turns about, at a corner."""
_SLIPS = 0.1
"""Speed over what carries it from which a body is not moored, m/s."""


class Mooring:
    """Ties a body to the moving thing on which it stands, as friction would.

    Bullet's friction lets it creep under a force that lasts, as in a bend.
    """

    def __init__(self, p: Any, client: int, body: int, registry: BodyRegistry) -> None:
        self._p, self._client, self._body = p, client, body
        self._registry = registry
        self._tie: int | None = None
        """Bullet's number of the constraint."""
        self._carrier = -1

    def update(self, moored: bool) -> None:
        """Tie or untie it; what anything else touches is free to move."""
        if not self._registry.has_movers:
            return
        if not moored:
            self._untie()
            return
        contacts = self._p.getContactPoints(self._body, physicsClientId=self._client)
        touching = {contact[2] for contact in contacts if contact[8] < GAP}
        if self._tie is not None:
            if touching - {self._carrier}:
                self._untie()
        elif len(touching) == 1:
            self._tie_to(touching.pop())

    def _tie_to(self, carrier: int) -> None:
        p, client, body = self._p, self._client, self._body
        place, attitude = p.getBasePositionAndOrientation(body, client)
        velocity, _ = p.getBaseVelocity(body, client)
        slips = dist(velocity, self._registry.velocity_at(carrier, place)) > _SLIPS
        if slips or not self._registry.is_mover(carrier):
            return
        back = p.invertTransform(*p.getBasePositionAndOrientation(carrier, client))
        place, attitude = p.multiplyTransforms(*back, place, attitude)
        middle, upright = (0, 0, 0), (0, 0, 0, 1)
        fixed = p.JOINT_FIXED
        self._tie = p.createConstraint(
            *(carrier, -1, body, -1, fixed, middle, place, middle, attitude, upright),
            physicsClientId=client,
        )
        p.changeConstraint(self._tie, maxForce=_HOLD, physicsClientId=client)
        self._carrier = carrier

    def _untie(self) -> None:
        if self._tie is not None:
            self._p.removeConstraint(self._tie, physicsClientId=self._client)
            self._tie = None
