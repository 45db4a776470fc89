"""Points and angles."""

from __future__ import annotations

from math import cos, isclose, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vencejo.geometry import (
    Point,
    bearing,
    distance,
    enu_of,
    horizontal_distance,
    roll_pitch_of,
    rotate_xy,
    wrap,
    yaw_of,
    yaw_quaternion,
)

ANGLES = st.floats(-1e4, 1e4)


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(0.0, 0.0), (pi, pi), (-pi, pi), (3 * pi / 2, -pi / 2), (2 * pi, 0.0), (-7.0, -7.0 + 2 * pi)],
)
def test_wrap(angle: float, wrapped: float) -> None:
    assert wrap(angle) == pytest.approx(wrapped)


@given(ANGLES)
def test_a_wrapped_angle_points_the_same_way_and_stays(angle: float) -> None:
    wrapped = wrap(angle)
    assert -pi < wrapped <= pi
    assert wrap(wrapped) == wrapped
    assert isclose(cos(wrapped), cos(angle), abs_tol=1e-9)
    assert isclose(sin(wrapped), sin(angle), abs_tol=1e-9)


@given(st.floats(-3.1, 3.1))
def test_a_yaw_survives_its_quaternion(yaw: float) -> None:
    assert yaw_of(yaw_quaternion(yaw)) == pytest.approx(yaw)
    assert roll_pitch_of(yaw_quaternion(yaw)) == pytest.approx((0.0, 0.0))


@given(st.floats(-99, 99), st.floats(-99, 99), ANGLES)
def test_turning_keeps_lengths(x: float, y: float, yaw: float) -> None:
    east, north = rotate_xy(x, y, yaw)
    assert Point(east, north, 0.0).norm() == pytest.approx(Point(x, y, 0.0).norm())


def test_points() -> None:
    a, b = Point(1.0, 2.0, 3.0), Point(4.0, 6.0, 3.0)
    assert a.plus((1, 1, 1)) == Point(2.0, 3.0, 4.0)
    assert b.minus(a) == Point(3.0, 4.0, 0.0)
    assert distance(a, b) == horizontal_distance(a, b) == b.minus(a).norm() == 5.0
    assert bearing((0, 0, 0), (0, 2, 9)) == pi / 2
    assert rotate_xy(1.0, 0.0, pi / 2) == pytest.approx((0.0, 1.0))


def test_pitch_is_positive_nose_down() -> None:
    half = 0.1
    assert roll_pitch_of((0.0, sin(half), 0.0, cos(half))) == pytest.approx((0.0, 0.2))
    assert roll_pitch_of((sin(half), 0.0, 0.0, cos(half))) == pytest.approx((0.2, 0.0))


def test_places_by_latitude() -> None:
    assert enu_of(40.0, -3.0, 40.0, -3.0) == (0.0, 0.0)
    east, north = enu_of(60.0, 1.0, 60.0, 0.0)
    assert (east, north) == pytest.approx((55659.7, 0.0), abs=1.0)
