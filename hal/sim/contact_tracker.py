"""The contacts of a vehicle: collisions, what it stands on, and whether it is at rest there."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from math import cos, hypot, pi, sin

from hal.sim.contact_debouncer import ContactDebouncer
from hal.sim.model import Model
from hal.sim.obstacle_heights import ObstacleHeightGrid
from hal.sim.physics import Body, BodyState, Physics, Touch, Triple
from hal.vehicle import PERIOD
from vencejo.geometry import distance

REST = 0.1
"""Speed below which a vehicle counts as at rest, m/s."""
_ROCKING = 0.2
"""Rate of roll and pitch below which it is at rest, rad/s."""
_SOFT = 0.6
"""Closing speed up to which a vehicle touches down, m/s; a faster touch is a hit."""
_FROM_BELOW = 0.1
"""Least upward part of the unit normal of what touches from below."""
_SETTLED = 10
"""Mission periods at rest after which it has settled."""
_BASE = 0.05
"""Horizontal distance from the centre of mass to which what it stands on reaches at least, in every
direction, metres."""
_EVEN = 2e-4
"""Most height that an even surface loses beside a straight line, metres."""
_PROBE = 0.1
"""Horizontal distance from the centre of mass at which a surface is probed, metres."""
_LIES = 0.02
"""Most height above an even surface of a vehicle that lies on it, metres."""
_DIRECTIONS = tuple((cos(k * pi / 8), sin(k * pi / 8)) for k in range(16))
_FAST = 20.0
"""Speed above which it can touch anything soon, m/s."""
_FARTHEST_GROUND = 1000.0
"""Range of the search for the ground below, metres."""


class ContactTracker:
    """A vehicle's contacts: `begin_period`; `update` after each physics step; `end_period`."""

    def __init__(
        self,
        physics: Physics,
        body: Body,
        model: Model,
        obstacles: ObstacleHeightGrid,
        velocity_of: Callable[[str], Triple],
    ) -> None:
        """``obstacles``: where contacts with the world are possible; ``velocity_of``: the velocity
        of a vehicle before the last physics step, m/s, by its name.
        """
        self._physics = physics
        self._body = body
        self._height = model.height
        self._level = cos(model.steepest_ground)
        """Least upward part of the unit normal of a surface that it can stand on."""
        self._obstacles = obstacles
        self._velocity_of = velocity_of
        self._touches: Sequence[Touch] = ()
        """Of the last physics step."""
        self._collisions = ContactDebouncer()
        self._velocity: Triple = (0.0, 0.0, 0.0)
        """Before the next physics step, m/s, world frame."""
        self._may_stand = True
        """True in this period when it stands, rises or comes down: then it may touch the ground."""
        self._places: deque[tuple[float, float]] = deque(maxlen=40)
        """Places that hold it up, east and north of the centre of mass, metres, since it rests."""
        self.near_things = True
        """True when the vehicle can touch a thing or another vehicle in this mission period."""
        self.near_ground = True
        """True when it can touch the ground in this mission period."""
        self.impact = 0.0
        """Largest speed at which it was hit in this mission period, m/s."""
        self.hit_by = ""
        """Name of what hit it at that speed; the ground has none."""
        self.supported = True
        """True when the vehicle stands, or lies without thrust, on something."""
        self.still = 0
        """Number of mission periods at rest on what touches it from below."""
        self.untouched = 0
        """Number of mission periods since it was touched from below."""
        self.clear = 0
        """Number of mission periods since it was touched at all."""
        self.thing = ""
        """Name of what touched it last, from below if anything did; empty for the ground."""

    @property
    def touched(self) -> tuple[str, ...]:
        """Names of the things that it hit in the last period."""
        return self._collisions.new

    @property
    def settled(self) -> bool:
        """Whether it has been at rest for long enough to end a landing."""
        return self.still >= _SETTLED

    def look_below(self, state: BodyState) -> None:
        """Find out what it stands on before it has touched anything."""
        x, y, z = state[0]
        hits = self._physics.rays([(x, y, z)], [(x, y, z - 2 * self._height)])
        self.thing = hits.name(0) or ""

    def begin_period(self, state: BodyState, may_stand: bool, others_near: bool) -> None:
        """Begin a mission period.

        ``may_stand``: it stands, rises or comes down, and may touch what it can stand on.
        ``others_near``: it can touch another vehicle.
        """
        (x, y, z), _, velocity, _ = state
        u, v, w = velocity
        thing_near, ground_near = self._obstacles.thing_near, self._obstacles.ground_near
        then = x + u * PERIOD, y + v * PERIOD, z + w * PERIOD
        fast = u * u + v * v + w * w > _FAST * _FAST
        self.near_things = others_near or fast or thing_near(x, y, z) or thing_near(*then)
        self.near_ground = fast or ground_near(x, y, z) or ground_near(*then)
        self._may_stand = may_stand
        self._touches = ()
        self._velocity = velocity
        self.impact = 0.0

    def update(self, state: BodyState) -> None:
        """Read the contacts after a physics step."""
        self._touches = touches = self._body.contacts()
        for touch in touches:
            closing = self._hit(touch)
            if touch.name:
                may_stand = self._may_stand and not touch.free and touch.normal[2] >= self._level
                self._collisions.add(touch.name, not may_stand or closing > _SOFT)
        self._velocity = state[2]

    def _hit(self, touch: Touch) -> float:
        """Take down a touch; the speed (m/s) across the surface at which the two came together.

        What moves freely has lost a part of it in the hit: what counts is its velocity before.
        """
        nx, ny, nz = touch.normal
        vx, vy, vz = self._velocity
        x, y, z = self._velocity_of(touch.name) if touch.free else touch.velocity
        closing = (x - vx) * nx + (y - vy) * ny + (z - vz) * nz
        if closing > self.impact:
            self.impact, self.hit_by = closing, touch.name
        return closing

    def end_period(self, state: BodyState, active: bool, thrust: bool) -> None:
        """End a mission period; unless ``active``, support and rest stay as they are."""
        if not active:
            if self.near_things:
                self.update(state)  # hit while it is parked: once a period is enough
        elif not self.near_things and self.near_ground:
            self._touches = self._body.contacts()  # the ground alone: no collision
            for touch in self._touches:
                self._hit(touch)
        self._collisions.end_period()
        if active:
            self._update_rest(state, thrust)

    def _update_rest(self, state: BodyState, thrust: bool) -> None:
        self.untouched += 1
        self.clear = 0 if self._touches else self.clear + 1
        below = [touch for touch in self._touches if touch.normal[2] > _FROM_BELOW]
        if not below:
            self.supported, self.still = False, 0
            self._places.clear()
            self.thing = next((touch.name for touch in self._touches), self.thing)
            return
        (x, y, _), _, velocity, (roll, pitch, _) = state
        level = [touch for touch in below if touch.normal[2] >= self._level and not touch.free]
        main = (level or below)[0]
        self.untouched = 0
        self.thing = next((touch.name for touch in below if touch.name), "")
        # On a moving carrier the vehicle rests when it moves along.
        resting = distance(velocity, main.velocity) < REST and hypot(roll, pitch) < _ROCKING
        self.still = self.still + 1 if resting else 0
        if not resting:
            self._places.clear()
        self._places += [(touch.place[0] - x, touch.place[1] - y) for touch in level]
        self.supported = bool(level) or (not thrust and self.settled)

    def has_footing(self, state: BodyState) -> bool:
        """Whether what it touches holds it up on all sides of its centre of mass.

        An engine may tell of few of the places where two faces meet, so that where none is known
        it is asked whether the surface goes on evenly.
        """
        places = self._places
        return bool(places) and all(
            max(east * x + north * y for x, y in places) >= _BASE
            or self._is_even(state, east * _PROBE, north * _PROBE)
            for east, north in _DIRECTIONS
        )

    def _is_even(self, state: BodyState, east: float, north: float) -> bool:
        """Whether it lies on a surface that is straight below it, this far to both sides."""
        x, y, z = state[0]
        starts = [(x + share * east, y + share * north, z) for share in (-1, 0, 1)]
        ends = [(x, y, z - 2 * self._height) for x, y, z in starts]
        before, middle, after = self._physics.rays(starts, ends).distances
        bend = (before + after) / 2 - middle
        return middle - self._height < _LIES and abs(bend) < _EVEN

    def restart_rest(self) -> None:
        """Count the periods at rest anew, since the vehicle changes its mode."""
        self.still = 0

    def height_above_ground(self, state: BodyState) -> float:
        """Height of the skids above the ground or thing straight below, metres."""
        x, y, z = state[0]
        below = self._physics.ray((x, y, z), (x, y, z - _FARTHEST_GROUND))
        return z - (below.z if below is not None else z - _FARTHEST_GROUND) - self._height
