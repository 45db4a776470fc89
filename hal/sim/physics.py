"""The seam to a physics engine: what the simulator asks of one, and no more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from vencejo.geometry import Point, Quaternion
from worlds.things import Terrain, Thing

STEPS_PER_SECOND = 240
STEP = 1 / STEPS_PER_SECOND
"""Seconds of one physics step."""
GRAVITY = 9.80665
"""Standard gravity, m/s²."""

Triple = tuple[float, float, float]
State = tuple[Triple, Quaternion, Triple, Triple]
"""Position of the centre of mass, attitude (x, y, z, w), velocity, turn rates; world frame."""


class Contacts(NamedTuple):
    """The contacts of a body, split by whether they carry it."""

    support_velocity: Triple | None = None
    """Velocity of what is below the body, where they touch, m/s, world frame; None for nothing."""
    beside: tuple[str, ...] = ()
    """Names of the things and bodies it touches elsewhere; the ground has none."""


class RayHits(Protocol):
    """The first hit of each ray of a batch, by the number of the ray."""

    @property
    def distances(self) -> Sequence[float]:
        """Metres along each ray; infinite where it hit nothing."""

    def name(self, ray: int) -> str | None:
        """The name of the thing that was hit: empty for the ground, None for nothing."""


class Body(Protocol):
    """A rigid body that moves freely."""

    def state(self) -> State:
        """Its pose and velocities after the last step."""

    def push(self, thrust: float, x: float, y: float, z: float) -> None:
        """Apply a force (N) along its own z and torques (N·m) about its own axes for one step."""

    def contacts(self) -> Contacts:
        """Its contacts in the last step."""

    def supported(self) -> bool:
        """Whether it touches something below it."""


class Physics(Protocol):
    """A world with flat ground at z = 0, solid things and free bodies.

    World frame; metres, newtons, seconds.
    """

    @property
    def name(self) -> str:
        """The engine and its version."""

    def add_things(self, things: Sequence[Thing], terrain: Terrain | None = None) -> None:
        """Add what is solid; a thing that moves keeps to its path and carries what is on it."""

    def add_body(
        self,
        mass: float,
        inertia: Triple,
        size: Triple,
        position: Triple,
        attitude: Quaternion,
        name: str = "",
    ) -> Body:
        """Add a cuboid that moves freely, its centre of mass in its middle.

        ``mass`` is in kg, ``inertia`` about its own axes in kg·m², ``size`` along them in metres.
        """

    def step(self) -> None:
        """Advance by :data:`STEP`."""

    def ray(self, start: Triple, end: Triple) -> Point | None:
        """The place where a ray first hits the ground or a thing; it passes through free bodies."""

    def rays(self, starts: Sequence[Triple], ends: Sequence[Triple]) -> RayHits:
        """The first hits of many rays, as :meth:`ray`."""

    def close(self) -> None:
        """Give the engine's memory back."""


def in_body(vector: Triple, q: Quaternion) -> Point:
    """A vector of the world frame in the axes of a body of that attitude (body to world)."""
    (a, b, c), (x, y, z, w) = vector, q
    # v + 2·w·(v × q) + 2·(v × q) × q: the rotation by the inverse of q.
    p, r, t = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
    return Point(
        a + w * p + r * z - t * y,
        b + w * r + t * x - p * z,
        c + w * t + p * y - r * x,
    )
