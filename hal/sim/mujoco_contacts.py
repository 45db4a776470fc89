"""Who touches whom in MuJoCo. World frame, metres."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from typing import Any, NamedTuple, Protocol

from hal.sim.physics import GAP, GRAVITY, Triple

_PRESSURE = 4.0
"""Greatest pressure of what slides, in weights, but for that of an impact."""
_ACROSS = 0.01
"""The share of the speed of what slides that another surface stops, from which that counts."""


class Touchable(Protocol):
    """What a shape belongs to."""

    @property
    def name(self) -> str: ...

    @property
    def free(self) -> bool:
        """True for a free body, whose path nothing determines."""

    @property
    def slippery(self) -> bool:
        """False for hills, on which what slides may be thrown upwards a little."""

    @property
    def restless(self) -> bool:
        """True for what moves or may begin to: nothing sleeps that touches it."""

    def velocity_at(self, place: Triple) -> Triple:
        """The velocity at a place, m/s."""


class Contact(NamedTuple):
    """A place at which something is touched."""

    other: Touchable
    """By what."""
    place: Triple
    """On the other's surface."""
    normal: Triple
    """Of that surface, towards what is touched."""


class _Meeting(NamedTuple):
    """How two meet at a contact."""

    one: Touchable
    two: Touchable
    number: int
    """Of the contact."""
    normal: Sequence[float]
    """A unit vector from the first to the second."""
    apart: float
    """The speed with which they move apart, m/s."""
    slip: Sequence[float]
    """The velocity of the second along the first, m/s."""

    def is_held_by(self, other: _Meeting) -> bool:
        """Whether another surface there holds what slides here, as in a corner: friction that asks
        for less than that does would push it in there, and it would bounce.
        """
        shared = {id(self.one), id(self.two)} & {id(other.one), id(other.two)}
        return bool(shared) and abs(_dot(self.slip, other.normal)) > _ACROSS * hypot(*self.slip)


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


class MujocoContacts:
    """The contacts of the last step, which are those of the poses before it."""

    def __init__(self) -> None:
        self._data: Any = None
        self._owners: Sequence[Touchable] = ()
        self._pairs: list[tuple[Touchable, Touchable, int]] | None = []
        self.outdated = False
        """True when the engine does not know them, before the next step."""

    def bind(self, data: Any, owners: Sequence[Touchable]) -> None:
        """Read them from these data from now on; ``owners``: of each shape, by its number."""
        self._data, self._owners, self._pairs = data, owners, None
        self.outdated = True

    def renew(self) -> None:
        """Forget those of the last step: there was another one."""
        self._pairs = None
        self.outdated = False

    def outdate(self) -> None:
        """Something was put elsewhere: only a look at its new place can tell what it touches."""
        self.outdated = True

    def pairs(self) -> list[tuple[Touchable, Touchable, int]]:
        """The two that touch, and the number of the contact; the normal points to the second."""
        if self._pairs is None:
            self._pairs = self._read_pairs() if self._data.ncon else []
        return self._pairs

    def _read_pairs(self) -> list[tuple[Touchable, Touchable, int]]:
        found = self._data.contact
        gaps = found.dist.tolist()
        if min(gaps) >= GAP:  # as near as that the engine knows them, but nothing touches
            return []
        shapes = found.geom.tolist()
        return [
            (self._owners[one], self._owners[two], number)
            for number, ((one, two), gap) in enumerate(zip(shapes, gaps, strict=True))
            if gap < GAP
        ]

    def ease_friction(self, seconds: float) -> None:
        """Ask the friction of each contact for no more than it can bring about in a step.

        ``seconds``: of that step. On hills it is not asked less: what fell on a steep slope with a
        corner first would slide on for some metres.
        """
        found, meetings = self._data.contact, [self._meeting(*pair) for pair in self.pairs()]
        for meeting in meetings:
            if not (meeting.one.slippery and meeting.two.slippery):
                continue
            number, slip = meeting.number, hypot(*meeting.slip)
            pressure = _PRESSURE * GRAVITY + max(0.0, -meeting.apart) / seconds
            slowing = float(found.friction[number][0]) * pressure
            if slip > slowing * seconds and not any(map(meeting.is_held_by, meetings)):
                # Negative: a damping in 1/s, and next to no stiffness (MuJoCo's direct format).
                found.solreffriction[number] = -1e-9, -slowing / slip

    def _meeting(self, one: Touchable, two: Touchable, number: int) -> _Meeting:
        found = self._data.contact
        place, normal = found.pos[number].tolist(), found.frame[number].tolist()[:3]
        ours, theirs = one.velocity_at(place), two.velocity_at(place)
        velocity = [b - a for a, b in zip(ours, theirs, strict=True)]
        apart = _dot(velocity, normal)
        slip = [a - apart * b for a, b in zip(velocity, normal, strict=True)]
        return _Meeting(one, two, number, normal, apart, slip)

    def others(self, body: Touchable) -> list[Touchable]:
        """Who touches a body, each once."""
        found = (
            two if one is body else one
            for one, two, _ in self.pairs()
            if one is body or two is body
        )
        return list(dict.fromkeys(found))

    def of(self, body: Touchable) -> list[Contact]:
        """What touches a body."""
        return [
            self._contact(two if one is body else one, number, 1.0 if two is body else -1.0)
            for one, two, number in self.pairs()
            if one is body or two is body
        ]

    def _contact(self, other: Touchable, number: int, sign: float) -> Contact:
        contact = self._data.contact[number]
        x, y, z, *_ = contact.frame.tolist()
        a, b, c = contact.pos.tolist()
        normal = sign * x, sign * y, sign * z
        half = contact.dist / 2  # the place that MuJoCo tells is half-way between the surfaces
        return Contact(
            other, (a - half * normal[0], b - half * normal[1], c - half * normal[2]), normal
        )
