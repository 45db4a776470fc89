"""move."""

from __future__ import annotations

from math import pi

import pytest

from hal.vehicle import Velocity
from tests.behaviors.flying import Solo, airborne


def test_it_flies_at_a_velocity_of_the_heading_frame() -> None:
    session, vehicle = airborne()
    vehicle.yaw = pi / 2
    solo = Solo("move", {"forward": 1.0, "left": 0.5, "up": 0.2}, vehicle=(session, vehicle))
    assert solo.run(2) is None
    assert solo.vehicle.position == pytest.approx((-1.0, 2.0, 3.4), abs=0.05)


def test_it_turns_counter_clockwise() -> None:
    solo = Solo("move", {"yaw_rate": 0.5})
    solo.run(2)
    assert solo.vehicle.yaw == pytest.approx(1.0)
    assert solo.vehicle.position == pytest.approx((0, 0, 3))


def test_all_of_it_is_live() -> None:
    solo = Solo("move")
    assert solo.step() == Velocity(frame="heading")
    solo.live = {"forward": 1.0, "left": -1.0, "up": 0.5, "yaw_rate": 0.1}
    assert solo.step() == Velocity(1.0, -1.0, 0.5, "heading", 0.1)
