"""What the simulator asks of a physics engine, and no more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from vencejo.geometry import Point, Quaternion
from worlds.things import Terrain, Thing

STEP = 1 / 240
"""Seconds of one physics step."""
GRAVITY = 9.80665
"""Standard gravity, m/s²."""

Triple = tuple[float, float, float]
State = tuple[Triple, Quaternion, Triple, Triple]
"""Position of the centre of mass, attitude (x, y, z, w), velocity, turn rates; world frame."""


class Touches(NamedTuple):
    """What a body is in contact with."""

    carrier: Triple | None = None
    """How what is below it moves where they touch, m/s, world frame; None for nothing below."""
    beside: tuple[str, ...] = ()
    """Names of the things and bodies it touches elsewhere; the ground has none."""


class Echoes(Protocol):
    """What a batch of rays met."""

    @property
    def distances(self) -> Sequence[float]:
        """Metres along each ray; infinite where it met nothing."""

    def name(self, ray: int) -> str | None:
        """Of what the ray met: empty for the ground, None for nothing."""


class Body(Protocol):
    """A rigid body that moves freely."""

    def state(self) -> State:
        """Where it is and how it moves."""

    def push(self, thrust: float, x: float, y: float, z: float) -> None:
        """A force along its own z and torques about its own axes, during the next step."""

    def touches(self) -> Touches:
        """What it is in contact with since the last step."""

    def supported(self) -> bool:
        """Whether it touches something below it."""


class Physics(Protocol):
    """A world with flat ground at z = 0, solid things and free bodies. Metres, newtons, seconds."""

    @property
    def name(self) -> str:
        """The engine and its version."""

    def add_things(self, things: Sequence[Thing], terrain: Terrain | None = None) -> None:
        """Put up what is solid; what moves follows its path exactly and carries what is on it."""

    def add_body(
        self,
        mass: float,
        inertia: Triple,
        size: Triple,
        position: Triple,
        attitude: Quaternion,
        name: str = "",
    ) -> Body:
        """A free cuboid; its centre of mass is its middle."""

    def step(self) -> None:
        """Advance by :data:`STEP`."""

    def ray(self, start: Triple, end: Triple) -> Point | None:
        """Where a ray first meets the ground or a thing; bodies are transparent to it."""

    def rays(self, starts: Sequence[Triple], ends: Sequence[Triple]) -> Echoes:
        """What many rays meet first, as :meth:`ray`."""

    def close(self) -> None:
        """Give the engine's memory back."""


def in_body(vector: Triple, q: Quaternion) -> Point:
    """A world-frame vector in the axes of a body of that attitude."""
    (a, b, c), (x, y, z, w) = vector, q
    # v + 2·w·(v × q) + 2·(v × q) × q: the rotation by the inverse of q.
    p, r, t = 2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)
    return Point(
        a + w * p + r * z - t * y,
        b + w * r + t * x - p * z,
        c + w * t + p * y - r * x,
    )
