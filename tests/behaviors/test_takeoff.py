"""takeoff."""

from __future__ import annotations

import pytest

from tests.behaviors.flying import Solo


def test_it_rises_to_the_altitude() -> None:
    solo = Solo("takeoff", {"altitude": 4.0}, grounded=True)
    solo.run(10)
    assert solo.word == "done"
    assert solo.vehicle.position.z == pytest.approx(4.0)
    assert solo.vehicle.observe().armed


def test_it_commands_no_setpoint_that_would_end_the_takeoff() -> None:
    solo = Solo("takeoff", grounded=True)
    solo.run(10)
    assert solo.word == "done"
    assert solo.vehicle.commands == []


def test_a_refusal_fails_with_the_vehicles_words() -> None:
    session_and_vehicle = Solo("hover", grounded=True)
    vehicle = session_and_vehicle.vehicle
    vehicle.health = ("the compass is not calibrated",)
    solo = Solo("takeoff", vehicle=(session_and_vehicle.session, vehicle))
    assert solo.run(1) is not None
    assert solo.word == "failed"
    assert solo.outcome and "takeoff refused: the compass" in solo.outcome.fields["reason"]


def test_it_does_not_wait_for_ever() -> None:
    solo = Solo("takeoff", {"timeout": 5.0}, grounded=True)
    solo.vehicle.stuck = True
    solo.run(20)
    assert solo.word == "failed"
    assert solo.outcome and solo.outcome.fields["reason"] == "takeoff took too long"
    assert solo.time == pytest.approx(5.0, abs=0.1)


def test_in_the_air_it_is_done_at_once() -> None:
    solo = Solo("takeoff", {"altitude": 9.0})
    solo.run(1)
    assert solo.word == "done"
    assert solo.vehicle.position.z == pytest.approx(3.0)
