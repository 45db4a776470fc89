"""The physics engine Bullet by way of pybullet, in this process and without a window."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from importlib.metadata import version
from math import cos, sin
from typing import Any

from hal.sim.physics import GRAVITY, STEP, State, Triple
from vencejo.errors import VehicleError
from vencejo.geometry import Point, Quaternion
from worlds.model import Box

_RAY, _FIXED, _FREE = 1, 2, 4
"""Groups that meet or not; Bullet's rays are of the group 1."""
_BOXES_PER_SHAPE = 16
"""createCollisionShapeArray silently drops every shape after the sixteenth."""


def load_pybullet() -> Any:
    """The pybullet module, imported without the banner it prints. Raises VehicleError."""
    module = sys.modules.get("pybullet")
    if module is None:
        with stderr_shut():
            try:
                module = import_module("pybullet")
            except ImportError as error:
                raise VehicleError(
                    "no-physics",
                    f"the simulator needs pybullet, which is not installed ({error})",
                    hint='run: pip install "vencejo[sim]" (ready-made up to CPython 3.11 on Linux '
                    "x86-64; elsewhere it compiles for about seven minutes)",
                ) from None
    return module


@contextmanager
def stderr_shut() -> Iterator[None]:
    """Send what C code complains to nowhere; replacing Python's own stream does not reach it."""
    try:
        kept = os.dup(2)
    except OSError:  # closed already
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


class Bullet:
    """A world of its own in Bullet (see :class:`hal.sim.physics.Physics`)."""

    def __init__(self) -> None:
        p = load_pybullet()
        self._p = p
        self._client: int = p.connect(p.DIRECT)
        if self._client < 0:
            raise VehicleError("no-physics", "pybullet has no room for another simulation")
        p.setTimeStep(STEP, self._client)
        p.setGravity(0, 0, -GRAVITY, self._client)
        # Contacts come in an order of their own; without this it may differ from run to run.
        p.setPhysicsEngineParameter(deterministicOverlappingPairs=1, physicsClientId=self._client)
        self._fix(p.createCollisionShape(p.GEOM_PLANE, physicsClientId=self._client))

    @property
    def name(self) -> str:
        return f"pybullet {version('pybullet')}"

    def _fix(self, shape: int) -> None:
        p = self._p
        # As a plain rigid body (maximal coordinates) a static body costs next to nothing.
        body = p.createMultiBody(0, shape, useMaximalCoordinates=1, physicsClientId=self._client)
        p.setCollisionFilterGroupMask(body, -1, _FIXED, _FREE | _RAY, physicsClientId=self._client)
        p.changeDynamics(body, -1, lateralFriction=0.8, physicsClientId=self._client)

    def add_boxes(self, boxes: Sequence[Box]) -> None:
        # One body per sixteen boxes: each static body by itself would cost time at every step.
        p = self._p
        for first in range(0, len(boxes), _BOXES_PER_SHAPE):
            chunk = boxes[first : first + _BOXES_PER_SHAPE]
            self._fix(
                p.createCollisionShapeArray(
                    shapeTypes=[p.GEOM_BOX] * len(chunk),
                    halfExtents=[[side / 2 for side in box.size] for box in chunk],
                    collisionFramePositions=[
                        [box.at.x, box.at.y, box.at.z + box.size.z / 2] for box in chunk
                    ],
                    collisionFrameOrientations=[
                        [0, 0, sin(box.heading / 2), cos(box.heading / 2)] for box in chunk
                    ],
                    physicsClientId=self._client,
                )
            )

    def add_body(
        self, mass: float, inertia: Triple, size: Triple, position: Triple, attitude: Quaternion
    ) -> BulletBody:
        p = self._p
        shape = p.createCollisionShape(
            p.GEOM_BOX, halfExtents=[side / 2 for side in size], physicsClientId=self._client
        )
        body: int = p.createMultiBody(
            mass, shape, -1, position, attitude, physicsClientId=self._client
        )
        p.setCollisionFilterGroupMask(body, -1, _FREE, _FIXED | _FREE, physicsClientId=self._client)
        p.changeDynamics(
            body,
            -1,
            localInertiaDiagonal=inertia,
            linearDamping=0,  # Bullet's own 0.04 takes 4 % of the speed each second
            angularDamping=0,
            lateralFriction=0.8,
            restitution=0,
            physicsClientId=self._client,
        )
        return BulletBody(p, self._client, body)

    def step(self) -> None:
        self._p.stepSimulation(self._client)

    def ray(self, start: Triple, end: Triple) -> Point | None:
        hit = self._p.rayTestBatch(
            [start], [end], collisionFilterMask=_FIXED, physicsClientId=self._client
        )[0]
        return Point(*hit[3]) if hit[0] >= 0 else None

    def close(self) -> None:
        if self._client >= 0:
            self._p.disconnect(self._client)
            self._client = -1


class BulletBody:
    """A body of that world (see :class:`hal.sim.physics.Body`)."""

    def __init__(self, p: Any, client: int, body: int) -> None:
        # Bound once, since these run at every step.
        self._position = partial(p.getBasePositionAndOrientation, body, client)
        self._velocity = partial(p.getBaseVelocity, body, client)
        self._force = partial(p.applyExternalForce, body, -1)
        self._torque = partial(p.applyExternalTorque, body, -1)
        self._contacts = partial(p.getContactPoints, body, physicsClientId=client)
        self._own_axes = p.LINK_FRAME
        self._client = client

    def state(self) -> State:
        position, attitude = self._position()
        velocity, turning = self._velocity()
        return position, attitude, velocity, turning

    def push(self, thrust: float, x: float, y: float, z: float) -> None:
        axes, client = self._own_axes, self._client
        self._force((0.0, 0.0, thrust), (0.0, 0.0, 0.0), axes, client)
        self._torque((x, y, z), axes, client)

    def supported(self) -> bool:
        # Field 7: the contact's normal, from the other body towards this one; field 8: the gap.
        return any(contact[7][2] > 0.5 and contact[8] < 0.005 for contact in self._contacts())
