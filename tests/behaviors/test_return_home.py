"""return_home."""

from __future__ import annotations

import pytest

from tests.behaviors.flying import Solo, airborne
from vencejo.geometry import Point, horizontal_distance


def test_it_flies_home_and_lands_there() -> None:
    session, vehicle = airborne()
    vehicle.position = Point(20.0, -10.0, 3.0)
    solo = Solo("return_home", vehicle=(session, vehicle))
    solo.run(60)
    assert solo.word == "done"
    assert vehicle.position == pytest.approx((0, 0, 0), abs=0.01)
    assert not vehicle.observe().armed
    assert vehicle.commands == []


def test_a_refusal_and_a_return_without_end_fail() -> None:
    pair = airborne()
    pair[1].refuse_next = "no home position"
    solo = Solo("return_home", vehicle=pair)
    solo.run(1)
    assert solo.outcome
    assert solo.outcome.fields == {"reason": "return_home refused: no home position"}

    solo = Solo("return_home", {"timeout": 3.0})
    solo.vehicle.stuck = True
    solo.run(10)
    assert solo.outcome and solo.outcome.fields == {"reason": "return_home took too long"}


def test_where_it_does_not_stand_at_home_it_lands_beside() -> None:
    session, vehicle = airborne()
    vehicle.position = Point(20.0, -10.0, 3.0)
    vehicle.unstable_on = ["ball"]
    solo = Solo("return_home", vehicle=(session, vehicle))
    solo.run(90)
    assert solo.word == "done" and not vehicle.observe().armed
    assert vehicle.verbs == ["takeoff", "return_home", "land"]
    assert 1.0 <= horizontal_distance(vehicle.position, (0, 0, 0)) < 2.0
