"""The contacts of a vehicle: support, collisions, and rest after a landing."""

from __future__ import annotations

from hal.sim.contact_debouncer import ContactDebouncer
from hal.sim.obstacle_heights import ObstacleHeightGrid
from hal.sim.physics import Body, BodyState, Physics, Triple
from vencejo.geometry import distance

REST = 0.1
"""Speed below which a vehicle counts as at rest, m/s."""
_SETTLED, _SETTLED_ON_AN_EDGE = 10, 40
"""Mission periods at rest that end a landing: with ground below the centre, and without."""
_FARTHEST_GROUND = 1000.0
"""Range of the search for the ground below, metres."""


class ContactTracker:
    """A vehicle's contacts: `begin_period`; `update` after each physics step; `end_period`."""

    def __init__(
        self,
        physics: Physics,
        body: Body,
        height: float,
        obstacles: ObstacleHeightGrid | None,
    ) -> None:
        """``height``: of the centre of mass above the skids, metres.

        ``obstacles``: where contacts are possible; without it they are looked up always.
        """
        self._physics = physics
        self._body = body
        self._height = height
        self._obstacles = obstacles
        self._support_velocity: Triple | None = None
        """Velocity of the vehicle's support, m/s, world frame; None without support."""
        self._collisions = ContactDebouncer()
        self.near_things = True
        """True when the vehicle can touch a thing in this mission period."""
        self.supported = True
        """True when the vehicle stands on something."""
        self._still = 0
        """Number of mission periods at rest."""

    @property
    def touched(self) -> tuple[str, ...]:
        """Names of the things that it began to touch in the last period."""
        return self._collisions.new

    def begin_period(self, state: BodyState) -> None:
        """Begin a mission period."""
        obstacles = self._obstacles
        self.near_things = obstacles is None or obstacles.thing_near(*state[0])
        self._support_velocity = None

    def update(self) -> None:
        """Read the contacts after a physics step."""
        self._support_velocity, beside = self._body.contacts()
        self._collisions.add(beside)

    def end_period(self, state: BodyState, active: bool) -> None:
        """End a mission period; unless ``active``, support and rest stay as they are."""
        obstacles = self._obstacles
        near_ground = obstacles is not None and state[0][2] < obstacles.ground
        if active and near_ground and not self.near_things:
            self.update()  # touching the ground is no collision: once a period is enough
        self._collisions.end_period()
        if not active:
            return
        support = self._support_velocity
        self.supported = support is not None
        # On a moving support the vehicle rests when it moves along.
        resting = support is not None and distance(state[2], support) < REST
        self._still = self._still + 1 if resting else 0

    def settled(self, on_an_edge: bool = False) -> bool:
        """Whether it has been at rest for long enough to end a landing."""
        return self._still >= (_SETTLED_ON_AN_EDGE if on_an_edge else _SETTLED)

    def restart_rest(self) -> None:
        """Count the periods at rest anew, since the vehicle changes its mode."""
        self._still = 0

    def height_above_ground(self, state: BodyState) -> float:
        """Height of the skids above the ground or thing straight below, metres."""
        x, y, z = state[0]
        below = self._physics.ray((x, y, z), (x, y, z - _FARTHEST_GROUND))
        return z - (below.z if below is not None else z - _FARTHEST_GROUND) - self._height
