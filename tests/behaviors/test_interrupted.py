"""Behaviours that go on after an interruption: from where they were, or anew from elsewhere."""

from __future__ import annotations

from math import pi
from typing import Any

import pytest

from hal.vehicle import Position
from tests.behaviors.flying import Solo
from vencejo.geometry import Point


def interrupted(name: str, values: dict[str, Any], seconds: float, moved: Point) -> Solo:
    """A behaviour that flew for a while and goes on after its vehicle was moved and turned."""
    before = Solo(name, values)
    before.run(seconds)
    progress, vehicle = before.activity.progress(), before.vehicle
    vehicle.position, vehicle.yaw = vehicle.position.plus(moved), -1.0
    vehicle.stuck = True
    before.session.wait()
    vehicle.stuck = False
    return Solo(name, values, progress=progress, vehicle=(before.session, vehicle))


def first(solo: Solo) -> Position:
    """The set-point of its first period."""
    setpoint = solo.step()
    assert isinstance(setpoint, Position)
    return setpoint


def test_hover_goes_back_over_one_metre_at_most() -> None:
    near = first(interrupted("hover", {}, 1.0, Point(0.9, 0.0, 0.0)))
    assert near.xyz == pytest.approx((0, 0, 3))
    far = first(interrupted("hover", {}, 1.0, Point(1.1, 0.0, 0.0)))
    assert far.xyz == pytest.approx((1.1, 0, 3))


@pytest.mark.parametrize("moved", [0.0, 0.9, 1.1, 50.0])
def test_keep_means_the_heading_of_the_first_start(moved: float) -> None:
    for name, values in (("hover", {}), ("goto", {"to": Point(90.0, 0.0, 3.0)})):
        solo = interrupted(name, values, 1.0, Point(0.0, moved, 0.0))
        assert first(solo).yaw == pytest.approx(0.0)


def test_a_heading_without_direction_stays_what_was_asked_for_last() -> None:
    # It comes within 0.3 m of the point that it faces.
    face = {"heading": {"face": Point(0.0, 0.8, 3.0)}}
    for name, values in (("hover", face), ("goto", {"to": Point(90.0, 0.0, 3.0), **face})):
        solo = interrupted(name, values, 0.1, Point(0.0, 0.6, 0.0))
        assert first(solo).yaw == pytest.approx(pi / 2, abs=0.01)


@pytest.mark.parametrize(
    ("moved", "elapsed", "reference"),
    [(Point(0.0, 0.9, 0.0), 2.0, 0.0), (Point(0.0, 1.1, 0.0), 0.0, 1.1)],
)
def test_goto_goes_on_near_by_and_flies_anew_from_elsewhere(
    moved: Point, elapsed: float, reference: float
) -> None:
    solo = interrupted("goto", {"to": Point(90.0, 0.0, 3.0)}, 2.0, moved)
    setpoint = first(solo)
    assert solo.activity.published.elapsed == pytest.approx(elapsed, abs=0.051)
    assert setpoint.xyz[1] == pytest.approx(reference, abs=0.01)


def test_near_by_the_dwell_goes_on() -> None:
    arrived = {"to": Point(0.0, 0.0, 3.0), "dwell": 4.0}
    solo = interrupted("goto", arrived, 3.0, Point(0.0, 0.0, 0.0))
    solo.vehicle.yaw = 0.0
    solo.session.wait()
    solo.run(0.9)
    assert solo.word is None
    solo.run(0.3)
    assert solo.word == "done"
