"""The physics engine Bullet by way of pybullet, in this process and without a window."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from importlib.metadata import version
from math import dist, inf
from typing import Any

from hal.sim.body_registry import BodyPieces, BodyRegistry
from hal.sim.collision_shapes import boxed, chunks, compound, mesh, ray_mesh
from hal.sim.hills import earth, height_field, slowed_above
from hal.sim.mooring import Mooring
from hal.sim.movers import Mover
from hal.sim.physics import GAP, GRAVITY, STEP, BodyState, Touch, Triple, in_body
from hal.sim.pieces import Piece, pieces_of
from vencejo.errors import VehicleError
from vencejo.geometry import Point, Quaternion, turned
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Sphere, Terrain, Thing

_RAY, _FIXED, _FREE, _RAY_MESH = 1, 2, 4, 8
"""Collision groups. Two bodies collide when either's mask has the other's group; a ray, which is of
group 1, hits a body when both do.
"""
_FRICTION, _GRIP = 0.8, 2.5
"""Lateral friction of bodies, and of moving things, which have a landing net; that of two bodies in
contact is the product."""
_STILL, _STILL_TURNING = 1e-3, 5e-3
"""Speed, m/s, and angular speed, rad/s, below which a body stands still."""
_STEPS_BETWEEN_LOOKS = 24
"""A body that stands still at two looks, and was not pushed between them, falls asleep."""
_ORIGIN = Point(0.0, 0.0, 0.0)


def load_pybullet() -> Any:
    """The pybullet module, imported without the banner it prints. Raises VehicleError."""
    module = sys.modules.get("pybullet")
    if module is None:
        with silenced(2):
            try:
                module = import_module("pybullet")
            except ImportError as error:
                raise VehicleError(
                    "no-physics",
                    f"this needs pybullet, which is not installed ({error})",
                    hint='for flights leave --engine out, or run: pip install "vencejo[bullet]" '
                    "(ready-made up to CPython 3.11 on Linux x86-64; elsewhere it compiles for "
                    "about seven minutes)",
                ) from None
    return module


@contextmanager
def silenced(*streams: int) -> Iterator[None]:
    """Discard what C code writes to these file descriptors (1: standard output, 2: error).

    To replace Python's own streams does not reach it.
    """
    try:
        kept = [(stream, os.dup(stream)) for stream in streams]
    except OSError:  # closed already: nothing can be written
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream, _ in kept:
            os.dup2(nowhere, stream)
        yield
    finally:
        # What C has buffered would come out later.
        ctypes.CDLL(None).fflush(None)
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)
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
        # The order of contacts is Bullet's own; without this it may differ from run to run.
        p.setPhysicsEngineParameter(deterministicOverlappingPairs=1, physicsClientId=self._client)
        self._registry = BodyRegistry(p, self._client)
        self._steps = 0
        self._movers: list[Mover] = []
        self._bodies: list[BulletBody] = []
        self._terrain: Terrain | None = None
        self._fix(p.createCollisionShape(p.GEOM_PLANE, physicsClientId=self._client))

    @property
    def name(self) -> str:
        return f"pybullet {version('pybullet')}"

    def add_things(self, things: Sequence[Thing], terrain: Terrain | None = None) -> None:
        p, client = self._p, self._client
        if terrain is not None:
            shape, middle = height_field(p, client, terrain)
            self._fix(shape, at=middle, mask=_RAY)
            if any(map(any, terrain.heights)):
                self._register(earth(p, client, terrain), _FIXED, _FREE, BodyPieces())
            self._terrain = terrain
        pieces = [piece for each in things if each.motion is None for piece in pieces_of(each)]
        cuboids = [piece for piece in pieces if isinstance(piece.shape, Cuboid)]
        round_ones = [piece for piece in pieces if isinstance(piece.shape, Cylinder | Sphere)]
        # One body per sixteen shapes: each static body by itself would cost time at every step.
        for chunk in chunks(cuboids):
            self._fix(compound(p, client, chunk), chunk, mask=_FREE)
            self._fix(ray_mesh(p, client, chunk), chunk, group=_RAY_MESH, mask=_RAY)
        for chunk in chunks(round_ones):
            self._fix(compound(p, client, chunk), chunk)
        for piece in pieces:
            if isinstance(piece.shape, Mesh):
                self._fix(mesh(p, client, piece), [piece])
        for each in things:
            if each.motion is not None:
                for chunk in chunks([boxed(piece) for piece in pieces_of(each)]):
                    mover = Mover(p, client, each, chunk)
                    moving = BodyPieces(chunk, moves=True)
                    self._register(mover.body, _FIXED, _FREE | _RAY, moving, _GRIP)
                    self._movers.append(mover)

    def _fix(
        self,
        shape: int,
        pieces: Sequence[Piece] = (),
        *,
        at: Point = _ORIGIN,
        group: int = _FIXED,
        mask: int = _FREE | _RAY,
    ) -> None:
        """Add a static body; a plain rigid body (maximal coordinates) costs next to nothing."""
        body = self._p.createMultiBody(
            0, shape, -1, at, useMaximalCoordinates=1, physicsClientId=self._client
        )
        self._register(body, group, mask, BodyPieces(pieces))

    def _register(
        self, body: int, group: int, mask: int, pieces: BodyPieces, friction: float = _FRICTION
    ) -> None:
        """Set a new body's collision groups and friction, and remember what it consists of."""
        p, client = self._p, self._client
        p.setCollisionFilterGroupMask(body, -1, group, mask, physicsClientId=client)
        p.changeDynamics(body, -1, lateralFriction=friction, restitution=0, physicsClientId=client)
        self._registry.add(body, pieces)

    def add_body(
        self,
        mass: float,
        inertia: Triple,
        size: Triple,
        position: Triple,
        attitude: Quaternion,
        name: str = "",
    ) -> BulletBody:
        p = self._p
        shape = p.createCollisionShape(
            p.GEOM_BOX, halfExtents=[side / 2 for side in size], physicsClientId=self._client
        )
        body: int = p.createMultiBody(
            mass, shape, -1, position, attitude, physicsClientId=self._client
        )
        piece = Piece(name, Cuboid(Point(*size)), _ORIGIN, UPRIGHT)
        self._register(body, _FREE, _FIXED | _FREE, BodyPieces([piece], True, True))
        p.changeDynamics(
            body,
            -1,
            localInertiaDiagonal=inertia,
            linearDamping=0,  # Bullet's own 0.04 takes 4 % of the speed each second
            angularDamping=0,
            sleepThreshold=_STILL**2 + _STILL_TURNING**2,
            physicsClientId=self._client,
        )
        added = BulletBody(p, self._client, body, self._registry, min(size))
        self._bodies.append(added)
        return added

    def step(self) -> None:
        for mover in self._movers:
            mover.drive(self._steps)
        for body in self._bodies:
            if body.withdrawn:
                body.hold()
            elif self._terrain is not None:
                body.keep_above(self._terrain)
        self._steps += 1
        self._p.stepSimulation(self._client)
        if self._steps % _STEPS_BETWEEN_LOOKS == 0:
            for body in self._bodies:
                if not body.withdrawn:
                    body.settle()

    def ray(self, start: Triple, end: Triple) -> Point | None:
        hit = self._cast([start], [end])[0]
        return Point(*hit[3]) if hit[0] >= 0 else None

    def rays(self, starts: Sequence[Triple], ends: Sequence[Triple]) -> BulletRayHits:
        hits = self._cast(starts, ends)
        lengths = map(dist, starts, ends)
        distances = [
            hit[2] * length if hit[0] >= 0 else inf
            for hit, length in zip(hits, lengths, strict=True)
        ]
        return BulletRayHits(distances, hits, self._registry)

    def _cast(self, starts: Sequence[Triple], ends: Sequence[Triple]) -> Any:
        return self._p.rayTestBatch(
            starts, ends, collisionFilterMask=_FIXED | _RAY_MESH, physicsClientId=self._client
        )

    def close(self) -> None:
        if self._client >= 0:
            self._p.disconnect(self._client)
            self._client = -1


class BulletRayHits:
    """Ray hits (see :class:`hal.sim.physics.RayHits`) whose names are found when asked for."""

    def __init__(self, distances: Sequence[float], hits: Any, registry: BodyRegistry) -> None:
        self.distances = distances
        self._hits, self._registry = hits, registry

    def name(self, ray: int) -> str | None:
        body, _, _, place, _ = self._hits[ray]
        return self._registry.name_at(body, place) if body >= 0 else None


class BulletBody:
    """A body of that world (see :class:`hal.sim.physics.Body`)."""

    def __init__(
        self, p: Any, client: int, body: int, registry: BodyRegistry, thickness: float
    ) -> None:
        """``thickness``: its least side, metres."""
        # Bound once, since these run at every step.
        self._position = partial(p.getBasePositionAndOrientation, body, client)
        self._velocity = partial(p.getBaseVelocity, body, client)
        self._force = partial(p.applyExternalForce, body, -1)
        self._torque = partial(p.applyExternalTorque, body, -1)
        self._contacts = partial(p.getContactPoints, body, physicsClientId=client)
        self._own_axes = p.LINK_FRAME
        self.moor = Mooring(p, client, body, registry).update
        self._client = client
        self._registry = registry
        self._thickness = thickness
        self._set_velocity = partial(p.resetBaseVelocity, body, physicsClientId=client)
        self._set_pose = partial(p.resetBasePositionAndOrientation, body, physicsClientId=client)
        self._set_groups = partial(p.setCollisionFilterGroupMask, body, -1, physicsClientId=client)
        self._activate = partial(p.changeDynamics, body, -1, physicsClientId=client)
        self._sleep = p.ACTIVATION_STATE_SLEEP | p.ACTIVATION_STATE_ENABLE_SLEEPING
        self._wake = p.ACTIVATION_STATE_WAKE_UP | p.ACTIVATION_STATE_DISABLE_SLEEPING
        self._pushed = self._still = False
        """Since the last look, and at it (see :meth:`settle`)."""
        self._may_sleep = False
        self.withdrawn = False
        """True while it is out of the world."""

    def state(self) -> BodyState:
        position, attitude = self._position()
        velocity, turning = self._velocity()
        return position, attitude, velocity, in_body(turning, attitude)

    def push(self, force: Triple, torque: Triple) -> None:
        axes, client = self._own_axes, self._client
        if not self._pushed:
            self._wake_up()
        self._force(force, (0.0, 0.0, 0.0), axes, client)
        self._torque(torque, axes, client)

    def withdraw(self) -> None:
        # Not put to sleep: Bullet takes a step to wake a body, in which it loses its velocity.
        self._wake_up()
        self.withdrawn = True
        self.moor(False)
        self._set_groups(0, 0)
        self.hold()

    def hold(self) -> None:
        """Before a step: let a withdrawn body stay where it is; a step adds gravity first."""
        self._set_velocity((0.0, 0.0, GRAVITY * STEP), (0.0, 0.0, 0.0))

    def place(self, state: BodyState) -> None:
        position, attitude, velocity, turning = state
        self.withdrawn = False
        self._set_groups(_FREE, _FIXED | _FREE)
        self._set_pose(position, attitude)
        self._set_velocity(velocity, turned(turning, attitude))

    def keep_above(self, terrain: Terrain) -> None:
        """Before a step: let it not come as deep into the terrain as it could in a hard fall.

        There Bullet would not know which way is out.
        """
        position, _ = self._position()
        velocity, turning = self._velocity()
        slowed = slowed_above(terrain, position, velocity, self._thickness / 4)
        if slowed is not None:
            self._set_velocity(slowed, turning)

    def settle(self) -> None:
        """Take a look at it: where nothing has moved it since the last one it falls asleep.

        Awake, it creeps by up to 0.2 mm/s on a slope. Bullet wakes what is touched by something
        that is awake, as everything that moves is; :meth:`push` wakes it, too.
        """
        (u, v, w), (a, b, c) = self._velocity()
        slow = u * u + v * v + w * w < _STILL**2 and a * a + b * b + c * c < _STILL_TURNING**2
        if slow and self._still and not self._pushed:
            self._may_sleep = True
            self._activate(activationState=self._sleep)
        self._still = slow and not self._pushed
        self._pushed = False

    def _wake_up(self) -> None:
        self._pushed = True
        if self._may_sleep:
            self._may_sleep = False
            self._activate(activationState=self._wake)

    def contacts(self) -> Sequence[Touch]:
        # Fields of a contact: 2 and 6 are the other body and the place on it, 7 the contact's
        # normal from the other towards this one, 8 the gap.
        found = [contact for contact in self._contacts() if contact[8] < GAP]
        if not found:
            return ()
        registry, (middle, _) = self._registry, self._position()
        return [
            Touch(
                registry.name_at(contact[2], contact[6]),
                contact[6],
                contact[7],
                registry.velocity_at(contact[2], middle),
                registry.is_free(contact[2]),
            )
            for contact in found
        ]
