"""land."""

from __future__ import annotations

import pytest

from tests.behaviors.flying import Solo, airborne


def test_it_lands_and_switches_off() -> None:
    solo = Solo("land")
    solo.run(20)
    assert solo.word == "done"
    assert solo.vehicle.position.z == 0
    assert not solo.vehicle.observe().armed


def test_it_lands_from_any_height() -> None:
    solo = Solo("land", vehicle=airborne(80.0))
    solo.run(100)
    assert solo.word == "done"
    assert solo.vehicle.position.z == 0


def test_on_the_ground_it_is_done_at_once() -> None:
    solo = Solo("land", grounded=True)
    solo.run(1)
    assert solo.word == "done"


def test_a_refusal_and_a_landing_without_end_fail() -> None:
    solo = Solo("land", {"timeout": 4.0})
    solo.vehicle.stuck = True
    solo.run(10)
    assert solo.outcome and solo.outcome.fields == {"reason": "land took too long"}
    assert solo.time == pytest.approx(4.0 + 1.5, abs=0.2)

    pair = airborne()
    pair[1].refuse_next = "not now"
    solo = Solo("land", vehicle=pair)
    solo.run(1)
    assert solo.outcome and solo.outcome.fields == {"reason": "land refused: not now"}
