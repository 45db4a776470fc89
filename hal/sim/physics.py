"""The interface to a physics engine: all that the simulator needs of one."""

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
GAP = 0.005
"""Bodies this near touch, metres: engines know of contacts a little before."""

Triple = tuple[float, float, float]
BodyState = tuple[Triple, Quaternion, Triple, Triple]
"""Position of the centre of mass (m), attitude (x, y, z, w), velocity (m/s), in the world frame;
angular velocity along the body's own axes (rad/s)."""


class Touch(NamedTuple):
    """A place at which the ground, a thing or another body touches a body."""

    name: str
    """Name of the thing or body; the ground has none."""
    place: Triple
    """World frame, metres."""
    normal: Triple
    """Unit normal of the surface there, towards the touched body, world frame."""
    velocity: Triple
    """The velocity that the touched body has when it is carried along, at its centre of mass, m/s,
    world frame."""
    free: bool = False
    """True for another free body, on which nothing stands."""


class RayHits(Protocol):
    """The first hit of each ray of a batch, by the number of the ray."""

    @property
    def distances(self) -> Sequence[float]:
        """Distance to the hit along each ray, metres; infinite for no hit."""

    def name(self, ray: int) -> str | None:
        """The name of the thing that a ray hit: empty for the ground, None for no hit."""


class Body(Protocol):
    """A rigid body that moves freely.

    One that stands still and is not pushed stays where it is, to 0.1 mm an hour, until it is pushed
    or something that moves touches it; what stands on a moving thing goes with it.
    """

    def state(self) -> BodyState:
        """Its pose and velocities after the last step."""

    def push(self, force: Triple, torque: Triple) -> None:
        """Apply a force (N) and a torque (N·m), both in its own axes, for one step."""

    def withdraw(self) -> None:
        """Take it out of the world: it moves nowhere, and nothing touches it, until it is placed.

        Something else integrates its motion meanwhile.
        """

    def place(self, state: BodyState) -> None:
        """Put it back, once it was withdrawn, with a pose and velocities."""

    def moor(self, moored: bool) -> None:
        """Let it keep its place on the moving thing on which it stands, or no longer.

        It is asked for every few steps, and ends where anything else touches the body.
        """

    def contacts(self) -> Sequence[Touch]:
        """The places at which it was touched in the last step, enough of them to span the area."""


class Physics(Protocol):
    """A world with flat ground at z = 0, solid things and free bodies.

    World frame; metres, newtons, seconds.
    """

    @property
    def name(self) -> str:
        """The engine and its version."""

    def add_things(self, things: Sequence[Thing], terrain: Terrain | None = None) -> None:
        """Add solid things; a moving one follows its path and carries bodies that stand on it.

        Terrain is solid too: however fast a body falls, its centre stays above the ground.
        """

    def add_body(
        self,
        mass: float,
        inertia: Triple,
        size: Triple,
        position: Triple,
        attitude: Quaternion,
        name: str = "",
    ) -> Body:
        """Add a freely moving cuboid, with the centre of mass in its centre.

        ``mass`` is in kg, ``inertia`` about its own axes in kg·m², ``size`` along them in metres.
        """

    def step(self) -> None:
        """Advance by :data:`STEP`."""

    def ray(self, start: Triple, end: Triple) -> Point | None:
        """The first hit of a ray with the ground or a thing; rays pass through free bodies."""

    def rays(self, starts: Sequence[Triple], ends: Sequence[Triple]) -> RayHits:
        """The first hit of each of many rays (see :meth:`ray`)."""

    def close(self) -> None:
        """Release the engine's memory."""


def in_body(vector: Triple, q: Quaternion) -> Point:
    """Rotate a vector from the world frame to the axes of a body (``q``: body to world)."""
    (a, b, c), (x, y, z, w) = vector, q
    # v + 2·w·(v × q) + 2·(v × q) × q: the rotation by the inverse of q.
    p, r, t = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
    return Point(
        a + w * p + r * z - t * y,
        b + w * r + t * x - p * z,
        c + w * t + p * y - r * x,
    )
