"""The contacts of a vehicle: what supports it, what it collides with, whether it has settled."""

from __future__ import annotations

from hal.sim.contact_debouncer import ContactDebouncer
from hal.sim.obstacle_heights import ObstacleHeightGrid
from hal.sim.physics import Body, Physics, State, Triple
from vencejo.geometry import distance

REST = 0.1
"""Slower than this is standing still, m/s."""
_SETTLED, _SETTLED_ON_AN_EDGE = 10, 40
"""Mission periods at rest that end a landing: with ground below the middle, and without."""
_FARTHEST_GROUND = 1000.0
"""The ground is looked for this far down, metres."""


class ContactTracker:
    """A vehicle's contacts. A mission period is `plan`; `feel` after each step; `end_period`."""

    def __init__(
        self,
        physics: Physics,
        body: Body,
        height: float,
        obstacles: ObstacleHeightGrid | None,
    ) -> None:
        """``height`` is that of the centre of mass above the skids, metres.

        ``obstacles`` tells where there can be contacts; without it they are looked for everywhere.
        """
        self._physics = physics
        self._body = body
        self._height = height
        self._obstacles = obstacles
        self._support_velocity: Triple | None = None
        """Velocity of what supports the vehicle, m/s, world frame; None for nothing."""
        self._collisions = ContactDebouncer()
        self.beside = True
        """Whether there are things within reach in this mission period."""
        self.supported = True
        """Whether it stands on something."""
        self._still = 0
        """Mission periods at rest."""

    @property
    def touched(self) -> tuple[str, ...]:
        """Names of what it began to touch in the period that ended last."""
        return self._collisions.new

    def plan(self, state: State) -> None:
        """Begin a mission period."""
        obstacles = self._obstacles
        self.beside = obstacles is None or obstacles.thing_near(*state[0])
        self._support_velocity = None

    def feel(self) -> None:
        """Take in the contacts after a physics step."""
        self._support_velocity, beside = self._body.contacts()
        self._collisions.add(beside)

    def end_period(self, state: State, active: bool) -> None:
        """End a mission period; while it is not ``active``, support and rest stay as they are."""
        obstacles = self._obstacles
        if active and not self.beside and obstacles is not None and state[0][2] < obstacles.ground:
            self.feel()  # to touch the ground is no collision: to look for it once is enough
        self._collisions.end_period()
        if not active:
            return
        support = self._support_velocity
        self.supported = support is not None
        # On something that moves, to be at rest is to move with it.
        resting = support is not None and distance(state[2], support) < REST
        self._still = self._still + 1 if resting else 0

    def settled(self, on_an_edge: bool = False) -> bool:
        """Whether it has been at rest long enough to stay there."""
        return self._still >= (_SETTLED_ON_AN_EDGE if on_an_edge else _SETTLED)

    def stir(self) -> None:
        """Count the rest anew, since it is about to do something else."""
        self._still = 0

    def free_below(self, state: State) -> float:
        """Height of the skids above what is straight below them, metres."""
        x, y, z = state[0]
        below = self._physics.ray((x, y, z), (x, y, z - _FARTHEST_GROUND))
        return z - (below.z if below is not None else z - _FARTHEST_GROUND) - self._height
