"""What a vehicle stands on, and what it touches beside that."""

from __future__ import annotations

from hal.sim.contact_debouncer import Bumps
from hal.sim.obstacle_heights import Skyline
from hal.sim.physics import Body, Physics, State, Triple
from vencejo.geometry import distance

REST = 0.1
"""Slower than this is standing still, m/s."""
_SETTLED, _SETTLED_ON_AN_EDGE = 10, 40
"""Mission periods at rest that end a landing: with ground below the middle, and without."""
_SEEN_BELOW = 1000.0
"""How far down the ground is looked for, metres."""


class Footing:
    """A vehicle's contacts. A mission period is `plan`; `feel` after each step; `end_period`."""

    def __init__(
        self, physics: Physics, body: Body, height: float, skyline: Skyline | None
    ) -> None:
        """``height``: of the centre of mass above the skids, metres."""
        self._physics = physics
        self._body = body
        self._height = height
        self._skyline = skyline
        self._carrier: Triple | None = None
        """The velocity of what is below it and touches it."""
        self._bumps = Bumps()
        self.beside = True
        """Whether there are things to touch in this mission period."""
        self.supported = True
        """Whether it stands on something."""
        self._still = 0
        """Mission periods at rest."""

    @property
    def touched(self) -> tuple[str, ...]:
        """What was first touched in the period that ended last."""
        return self._bumps.new

    def plan(self, state: State) -> None:
        """Begin a mission period."""
        skyline = self._skyline
        self.beside = skyline is None or skyline.thing_near(*state[0])
        self._carrier = None

    def feel(self) -> None:
        """Take in what is touched after a physics step."""
        self._carrier, beside = self._body.touches()
        self._bumps.feel(beside)

    def end_period(self, state: State, active: bool) -> None:
        """End a mission period; one that is not ``active`` stays as it stands."""
        skyline = self._skyline
        if active and not self.beside and skyline is not None and state[0][2] < skyline.ground:
            self.feel()  # the ground is not bumped into: to look for it once is enough
        self._bumps.end_period()
        if not active:
            return
        carrier = self._carrier
        self.supported = carrier is not None
        # On something that moves, to be at rest is to move with it.
        resting = carrier is not None and distance(state[2], carrier) < REST
        self._still = self._still + 1 if resting else 0

    def settled(self, on_an_edge: bool = False) -> bool:
        """Whether it has been at rest long enough to stay there."""
        return self._still >= (_SETTLED_ON_AN_EDGE if on_an_edge else _SETTLED)

    def stir(self) -> None:
        """Count the rest anew: it is about to do something else."""
        self._still = 0

    def free_below(self, state: State) -> float:
        """Free air below the skids, metres."""
        x, y, z = state[0]
        below = self._physics.ray((x, y, z), (x, y, z - _SEEN_BELOW))
        return z - (below.z if below is not None else z - _SEEN_BELOW) - self._height
