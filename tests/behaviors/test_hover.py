"""hover."""

from __future__ import annotations

from itertools import pairwise
from math import pi

import pytest

from hal.vehicle import Position, Velocity
from tests.behaviors.flying import Solo, airborne
from vencejo.geometry import Point, distance


def test_it_stays_and_never_ends() -> None:
    solo = Solo("hover")
    solo.vehicle.yaw = 1.0
    solo.session.wait()
    solo = Solo("hover", vehicle=(solo.session, solo.vehicle))
    assert solo.run(60) is None
    assert solo.vehicle.position == pytest.approx((0, 0, 3))
    assert solo.vehicle.yaw == pytest.approx(1.0)


def test_it_brakes_gently_along_its_way_and_stays_where_that_ends() -> None:
    session, vehicle = airborne()
    for _ in range(40):
        vehicle.command(Velocity(x=2.0))
        session.wait()
    began = vehicle.position
    solo = Solo("hover", vehicle=(session, vehicle))
    speeds = []
    for _ in range(80):
        setpoint = solo.step()
        assert isinstance(setpoint, Position) and setpoint.velocity is not None
        speeds.append(setpoint.velocity.x)
    # v²/2a at 2 m/s², and half of the smoothing's 0.6 s.
    assert vehicle.position == pytest.approx((began.x + 1.6, 0, 3), abs=0.06)
    assert speeds[0] == pytest.approx(2.0, abs=0.01)
    assert all(later <= sooner for sooner, later in pairwise(speeds))
    assert speeds[-1] == 0


def test_it_goes_to_a_place_and_back_when_the_wind_has_its_way() -> None:
    solo = Solo("hover", {"at": Point(2.0, 1.0, 4.0)})
    solo.run(8)
    assert solo.vehicle.position == pytest.approx((2, 1, 4), abs=1e-6)
    solo.vehicle.position = Point(3.0, 1.0, 4.0)
    solo.run(8)
    assert solo.vehicle.position == pytest.approx((2, 1, 4), abs=1e-6)


def test_its_place_and_heading_follow_live_values() -> None:
    solo = Solo("hover")
    solo.run(1)
    solo.live = {"at": Point(0.0, 2.0, 3.0), "heading": {"face": Point(0.0, -9.0, 3.0)}}
    solo.run(8)
    assert solo.vehicle.position == pytest.approx((0, 2, 3), abs=1e-6)
    assert solo.vehicle.yaw == pytest.approx(-pi / 2)
    # Something that is not seen just now has no place: the last one counts.
    solo.live = {"at": None}
    assert solo.run(4) is None
    assert distance(solo.vehicle.position, (0, 2, 3)) < 1e-6
