"""Set-points as people's code gives them."""

from __future__ import annotations

from math import inf, isfinite, nan
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from behaviors.setpoints import FURTHEST, checked
from hal import Attitude, Hold, Position, Velocity
from vencejo.geometry import Point


@pytest.mark.parametrize(
    ("given_", "plain"),
    [
        (Velocity(1, 2, 3), Velocity(1.0, 2.0, 3.0)),
        (Velocity(np.float32(0.5), frame="heading"), Velocity(0.5, frame="heading")),
        (Velocity(yaw_rate=np.array(0.25)), Velocity(yaw_rate=0.25)),
        (Position((1, 2, 3)), Position(Point(1.0, 2.0, 3.0))),  # type: ignore[arg-type]
        (Position(np.array([1, 2, 3])), Position(Point(1.0, 2.0, 3.0))),  # type: ignore[arg-type]
        (
            Position(Point(0, 0, 1), [1, 0, 0], 2, 3),  # type: ignore[arg-type]
            Position(Point(0.0, 0.0, 1.0), Point(1.0, 0.0, 0.0), 2.0, 3.0),
        ),
        (
            Position(Point(0, 0, 1), acceleration=(1, 0, 2)),  # type: ignore[arg-type]
            Position(Point(0.0, 0.0, 1.0), acceleration=Point(1.0, 0.0, 2.0)),
        ),
        (Attitude(1, 0, 0, 1, unit="share"), Attitude(1.0, 0.0, 0.0, 1.0, unit="share")),
        (Hold(), Hold()),
    ],
)
def test_its_numbers_become_plain(given_: Any, plain: Any) -> None:
    assert repr(checked(given_)) == repr(plain)


@pytest.mark.parametrize(
    ("given_", "kind", "told"),
    [
        (None, TypeError, "a NoneType is no set-point"),
        ((1.0, 0.0, 0.0), TypeError, "a tuple is no set-point"),
        ({"x": 1.0}, TypeError, r"those are Velocity, Position, Attitude, Hold"),
        (Velocity, TypeError, "the class Velocity is no set-point"),
        (Velocity(x="fast"), TypeError, "x must be a number: fast is not a number"),
        (Velocity(y=None), TypeError, "y must be a number, not None"),
        (Velocity(z=True), TypeError, "z must be a number"),
        (Velocity(x=np.zeros(2)), TypeError, "x must be a number: a ndarray"),
        (Velocity(x=1j), TypeError, "x must be a number: a complex"),
        (Velocity(frame="body"), ValueError, "frame is world or heading, not 'body'"),
        (Velocity(frame=None), ValueError, "frame is world or heading, not None"),
        (Position((1.0, 2.0)), TypeError, "xyz is a Point of three numbers, not a tuple"),
        (Position(3), TypeError, "xyz is a Point of three numbers, not an int"),
        (Position(Point(0.0, "a", 0.0)), TypeError, "xyz must be a number"),
        (Position(Point(0.0, 0.0, 0.0), velocity=1.0), TypeError, "velocity is a Point"),
        (Position(Point(0.0, 0.0, 0.0), acceleration=1.0), TypeError, "acceleration is a Point"),
        (Position(Point(0.0, 0.0, 0.0), yaw="keep"), TypeError, "yaw must be a number"),
        (Attitude(unit="deg"), ValueError, "unit is si or share, not 'deg'"),
        (Attitude(thrust="full"), TypeError, "thrust must be a number"),
    ],
)
def test_what_is_none_is_refused(given_: Any, kind: type[Exception], told: str) -> None:
    with pytest.raises(kind, match=told):
        checked(given_)


BAD = [nan, inf, -inf, 1e10, np.float32(nan)]


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("place", range(15))
def test_every_number_must_be_finite(bad: float, place: int) -> None:
    n: list[Any] = [0.0] * 15
    n[place] = bad
    setpoints = [
        Velocity(*n[:3], "world", n[3]),
        Position(Point(*n[4:7]), Point(*n[7:10]), *n[10:12]),
        Attitude(*n[12:15]),
    ]
    refused = 0
    for setpoint in setpoints:
        try:
            checked(setpoint)
        except (TypeError, ValueError):
            refused += 1
    assert refused == 1


@given(st.lists(st.floats(), min_size=6, max_size=6))
def test_what_is_flown_is_finite(numbers: list[float]) -> None:
    setpoint = Position(Point(*numbers[:3]), Point(*numbers[3:]))
    try:
        plain = checked(setpoint)
    except ValueError:
        assert not all(isfinite(n) and abs(n) <= FURTHEST for n in numbers)
    else:
        assert plain == setpoint
