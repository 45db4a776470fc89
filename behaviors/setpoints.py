"""Set-points as behaviours give them: checked, and brought to plain finite numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from fsm.values.functions import EvaluationError
from fsm.values.intake import admitted, kind_of
from fsm.values.types import Number
from hal.vehicle import Attitude, Hold, Position, Setpoint, Velocity
from vencejo.geometry import Point

FURTHEST = 1e9
"""The largest number in a set-point, metres, m/s, radians or rad/s: with larger ones the sums of
whoever follows it are no numbers any more."""
_FURTHEST_SQUARED = FURTHEST**2
_NUMBER = Number()


def checked(setpoint: Any) -> Setpoint:
    """The set-point, with its numbers as Python's floats.

    Raises TypeError for what is no set-point, or has something else where a number belongs;
    ValueError for numbers that are not finite or beyond FURTHEST, and for unknown words.
    """
    if _is_plain(setpoint):
        plain: Setpoint = setpoint
        return plain
    for kind, reader in _READERS.items():
        if isinstance(setpoint, kind):
            read: Setpoint = reader(setpoint)
            return read
    known = ", ".join(kind.__name__ for kind in _READERS)
    raise TypeError(f"{kind_of(setpoint)} is no set-point (those are {known})")


def number(what: str, value: Any) -> float:
    """A number that a behaviour gives to its vehicle. Raises TypeError and ValueError."""
    if type(value) is not float:
        try:
            plain = admitted(value, _NUMBER)
        except EvaluationError as error:
            raise TypeError(f"{what} must be a number: {error}") from None
        if plain is None:
            raise TypeError(f"{what} must be a number, not None")
        value = float(plain)
    if not -FURTHEST <= value <= FURTHEST:
        raise ValueError(
            f"a set-point needs finite numbers up to {FURTHEST:g}: {what} is {value:g}"
        )
    result: float = value
    return result


def _optional(what: str, value: Any) -> float | None:
    return None if value is None else number(what, value)


def _point(what: str, value: Any) -> Point:
    try:
        x, y, z = value
    except (TypeError, ValueError):
        message = f"{what} is a Point of three numbers, not {kind_of(value)}"
        raise TypeError(message) from None
    return Point(number(what, x), number(what, y), number(what, z))


def _word(what: str, value: Any, known: tuple[str, ...]) -> Any:
    if not isinstance(value, str) or value not in known:
        raise ValueError(f"{what} is {' or '.join(known)}, not {value!r:.40}")
    return value


def _is_plain(setpoint: Any) -> bool:
    """Whether a set-point is as :func:`checked` gives it, as most are; False when in doubt."""
    # One sum of squares tests all its numbers: it is small only when each is finite and small.
    try:
        if type(setpoint) is Position:
            xyz, velocity, yaw, yaw_rate, acceleration = setpoint
            x, y, z = xyz
            if not type(x) is type(y) is type(z) is float or type(xyz) is not Point:
                return False
            total = x * x + y * y + z * z
            if velocity is not None:
                x, y, z = velocity
                total += x * x + y * y + z * z
            if acceleration is not None:
                x, y, z = acceleration
                total += x * x + y * y + z * z
            if yaw is not None:
                total += yaw * yaw
            if yaw_rate is not None:
                total += yaw_rate * yaw_rate
            return type(total) is float and total < _FURTHEST_SQUARED
        if type(setpoint) is Velocity:
            x, y, z, frame, yaw_rate = setpoint
            if not type(x) is type(y) is type(z) is type(yaw_rate) is float:
                return False
            total = x * x + y * y + z * z + yaw_rate * yaw_rate
            return total < _FURTHEST_SQUARED and frame in ("world", "heading")
    except (TypeError, ValueError, ArithmeticError):
        pass  # it is told what is wrong with it where each number is looked at
    return False


def _velocity(given: Velocity) -> Velocity:
    numbers = number("x", given.x), number("y", given.y), number("z", given.z)
    frame = _word("frame", given.frame, ("world", "heading"))
    return Velocity(*numbers, frame, number("yaw_rate", given.yaw_rate))


def _position(given: Position) -> Position:
    return Position(
        _point("xyz", given.xyz),
        None if given.velocity is None else _point("velocity", given.velocity),
        _optional("yaw", given.yaw),
        _optional("yaw_rate", given.yaw_rate),
        None if given.acceleration is None else _point("acceleration", given.acceleration),
    )


def _attitude(given: Attitude) -> Attitude:
    _word("unit", given.unit, ("si", "share"))
    return Attitude(
        number("roll", given.roll),
        number("pitch", given.pitch),
        number("climb", given.climb),
        _optional("thrust", given.thrust),
        number("yaw_rate", given.yaw_rate),
        given.unit,
    )


_READERS: Mapping[type[Setpoint], Callable[[Any], Setpoint]] = MappingProxyType(
    {Velocity: _velocity, Position: _position, Attitude: _attitude, Hold: lambda given: Hold()}
)
"""Kind of set-point → how it is read."""
