"""The end of a landing: from the first touch until the vehicle stands, or has to leave again."""

from __future__ import annotations

from math import cos, hypot, pi, tan
from typing import Literal

from hal.sim.contact_tracker import ContactTracker
from hal.sim.model import Model
from hal.sim.physics import BodyState

_ON_EDGE = 2
"""Mission periods on one edge after which the thrust is cut."""
_SWAYS = 0.05
"""Height by which the centre of a vehicle on one edge may rise when it sways, metres."""
_LYING = 5
"""Least mission periods without thrust before it is known that it stands."""
_OVER_EDGE = 4
"""Mission periods of touching beside the centre of mass, with nothing below that, before it leaves.
"""
_SLIPPED = 4
"""Mission periods without contact after which a vehicle without thrust falls."""
_PATIENCE = 60
"""Mission periods, 1.5 s, in which it gets on or stands."""
_LONGEST = 200
"""Mission periods, 5 s, of touching again and again after which it leaves."""
_SINKING = 0.1
"""Least descent of a vehicle that comes down, m/s."""
_TIPPED = 10 * pi / 180
"""Tilt beyond that of the steepest ground at which it falls over, radians."""

Verdict = Literal["", "stands", "unstable", "capsized"]
"""Empty while that is not known; capsized is what lies so that its thrust does not lift it."""


class Touchdown:
    """Tells in each mission period of a landing whether the vehicle stands."""

    def __init__(self, contacts: ContactTracker, model: Model) -> None:
        self._contacts = contacts
        self._least_cosine = cos(model.steepest_ground + _TIPPED)
        self._capsized_cosine = cos(model.steepest)
        length, width, _ = model.size
        self._gap = hypot(length, width) / 2 * tan(model.steepest_ground) + _SWAYS
        """Most height above the ground of a vehicle that touches a slope, metres."""
        self.idle = False
        """True when the thrust is cut: the vehicle lies down on what it touches, and comes to rest
        on what moves."""
        self._periods = 0
        """Mission periods without thrust; before, of touching without coming down."""
        self._touching = 0
        """Mission periods since it has touched something, with short breaks only."""
        self._on_edge = self._over_edge = 0
        """Mission periods of touching with an edge: above ground, and above nothing near."""

    def restart(self) -> None:
        """Begin another landing, or none."""
        self.idle = False
        self._periods = self._touching = self._on_edge = self._over_edge = 0

    def update(self, state: BodyState, height: float) -> Verdict:
        """Go on by a mission period; ``height`` (m) is that above what is straight below."""
        if self._is_over(state, self._capsized_cosine, _SLIPPED):
            return self._lie_over()
        return self._lie_down(state) if self.idle else self._touch(state, height)

    def _touch(self, state: BodyState, height: float) -> Verdict:
        contacts = self._contacts
        if contacts.supported:
            # On a slope the level vehicle touches with one edge.
            self._on_edge += height < self._gap
            if self._on_edge >= _ON_EDGE or contacts.has_footing(state):
                self.idle, self._periods = True, 0
                return ""
            self._over_edge += height >= self._gap
        near = contacts.clear < _PATIENCE
        self._touching = self._touching + 1 if near else 0
        self._periods = self._periods + 1 if near and state[2][2] > -_SINKING else 0
        stuck = self._periods >= _PATIENCE or self._over_edge >= _OVER_EDGE
        stuck = stuck or self._touching >= _LONGEST
        return "unstable" if stuck or self._tips(state) else ""

    def _lie_down(self, state: BodyState) -> Verdict:
        contacts = self._contacts
        self._periods += 1
        falls = contacts.untouched >= _SLIPPED or self._tips(state)
        if falls or self._periods >= _PATIENCE:
            return "unstable"
        settled = contacts.settled and self._periods >= _LYING
        return "stands" if settled and contacts.has_footing(state) else ""

    def _lie_over(self) -> Verdict:
        if not self.idle:
            self.idle, self._periods = True, 0
        self._periods += 1
        lies = self._contacts.settled or self._periods >= _PATIENCE
        return "capsized" if lies else ""

    def _tips(self, state: BodyState) -> bool:
        return self._is_over(state, self._least_cosine, _PATIENCE)

    def _is_over(self, state: BodyState, least_cosine: float, periods: int) -> bool:
        """Whether it leans further than that, and was touched within so many mission periods."""
        x, y, _, _ = state[1]
        leans = 1 - 2 * (x * x + y * y) < least_cosine
        return leans and self._contacts.untouched < periods
