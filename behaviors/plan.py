"""Plans: where a behaviour will fly, said before the flight.

:meth:`behaviors.behavior.Behavior.plan` gives the legs from where it begins. The checks before a
flight use them, and whatever else wants to know: how near they pass to things, how much of the
battery they take.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from behaviors.guidance import yaw_towards
from behaviors.params import Face, Heading, value
from fsm.values.functions import EvaluationError
from hal.limits import Limits
from vencejo.geometry import Point


class NotKnown(EvaluationError):
    """A value was asked for that is only known in flight."""

    def __init__(self, *_: object) -> None:
        super().__init__("this is known in flight only")


class Unflyable(EvaluationError):
    """Parameters that make no flight, wherever it begins: raised by a plan, which the check tells
    as an error of the mission, and at the start of the behaviour.
    """

    def __init__(self, message: str, parameter: str = "", hint: str = "") -> None:
        """``parameter``: the name of the one that is to be changed, if it is one."""
        super().__init__(message)
        self.parameter = parameter
        self.hint = hint


class Unknown:
    """Stands for a value that is only known in flight: whatever is made of it raises NotKnown."""

    __slots__ = ()

    def __repr__(self) -> str:
        return "unknown"

    def __reduce__(self) -> str:
        return "UNKNOWN"  # there is one only, copies included

    def _refuse(self, *_: object) -> Any:
        raise NotKnown

    __bool__ = __float__ = __int__ = __index__ = __len__ = __iter__ = __getitem__ = _refuse
    __contains__ = __call__ = __eq__ = __ne__ = __lt__ = __le__ = __gt__ = __ge__ = _refuse
    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = _refuse
    __rtruediv__ = __floordiv__ = __mod__ = __pow__ = __neg__ = __pos__ = __abs__ = _refuse
    __hash__ = object.__hash__

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)  # what Python itself looks for, to copy it for instance
        raise NotKnown


UNKNOWN: Final[Any] = Unknown()
"""The value of a parameter, or of a fact about the start, that is only known in flight."""


def is_known(given: Any) -> bool:
    """Whether a value is known before the flight, and all that is in it."""
    if isinstance(given, Unknown):
        return False
    inside = given.values() if isinstance(given, Mapping) else given
    return not isinstance(inside, Iterable) or isinstance(inside, str) or all(map(is_known, inside))


def require_order(params: Any, least: str, most: str) -> None:
    """Raises Unflyable where the parameter ``least`` is above ``most``; either may be UNKNOWN."""
    low, high = getattr(params, least), getattr(params, most)
    if is_known(low) and is_known(high) and low > high:
        raise Unflyable(f"{least} ({low:g}) is above {most} ({high:g})", least)


@dataclass(frozen=True, slots=True)
class PlanStart:
    """Where a behaviour begins. Mission frame, metres, radians; any may be :data:`UNKNOWN`."""

    position: Point
    yaw: float
    """Counter-clockwise from east."""
    flying: bool
    """Whether it is in the air."""
    ground: float
    """The height of what lies straight below: the ground, or the top of a thing."""
    return_height: float
    """The height above home at which the vehicle returns by its own means, at least."""
    limits: Limits = field(default_factory=Limits)
    """Its limits, as far as they are known: None where one is not."""


@dataclass(frozen=True, slots=True)
class Slower:
    """A path that needs more tilt, climb or speed than the vehicle has."""

    asked: float = value("m/s")
    speed: float = value("m/s")
    """The speed at which it is flown: of a circle or figure eight the highest one, of a line
    through points the lowest, in its sharpest bend."""


@dataclass(frozen=True, slots=True)
class PlannedLeg:
    """A flight in a straight line."""

    to: Point
    """Its end, mission frame, metres."""
    speed: float | None = None
    """Along it, m/s; None where the vehicle chooses."""
    dwell: float = 0.0
    """Stay at its end, seconds."""
    yaw: float | None = None
    """The heading at its end, radians counter-clockwise from east; None where it is not known."""
    slower: Slower | None = None
    """The speeds of the path that it is part of, if the vehicle cannot fly that as fast as asked
    for."""


Legs = Sequence[PlannedLeg]
"""The legs of a plan, in order. None: it stays where it begins."""


def leg_to(
    start: PlanStart, here: Point, to: Point, speed: float, heading: Heading, dwell: float = 0.0
) -> PlannedLeg:
    """A leg as goto flies it, from ``here``; its speed and heading may be UNKNOWN."""
    known_speed = None if isinstance(speed, Unknown) else speed
    known_dwell = 0.0 if isinstance(dwell, Unknown) else dwell
    return PlannedLeg(to, known_speed, known_dwell, _yaw_after(start, here, to, heading))


def _yaw_after(start: PlanStart, here: Point, to: Point, heading: Heading) -> float | None:
    """The heading at the end of a leg; None where it is not known."""
    try:
        at = to if isinstance(heading, Face) else here
        yaw = yaw_towards(heading, at, to, start.yaw, start.yaw)
    except NotKnown:
        return None
    return None if isinstance(yaw, Unknown) else yaw
