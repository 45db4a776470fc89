"""search_spiral."""

from __future__ import annotations

from itertools import pairwise
from math import pi

import pytest

from behaviors import PlanStart, describe
from behaviors.search_spiral import SearchSpiral
from hal.vehicle import Position
from tests.behaviors.flying import Solo
from vencejo.geometry import Point, bearing, horizontal_distance, wrap

INFO = describe(SearchSpiral)


@pytest.mark.parametrize("clockwise", [False, True])
def test_it_comes_farther_out_with_each_turn(clockwise: bool) -> None:
    centre = Point(3.0, 1.0, 4.0)
    values = {"center": centre, "radius": 6.0, "spacing": 1.5, "clockwise": clockwise}
    solo, told = Solo(INFO, values), []
    while solo.outcome is None:
        setpoint = solo.step()
        assert isinstance(setpoint, Position)
        if solo.activity.published.progress > 0:
            told.append(setpoint.xyz)
        assert solo.time < 200
    assert solo.word == "done"
    assert horizontal_distance(solo.vehicle.position, centre) == pytest.approx(6.0, abs=0.02)
    assert all(place.z == pytest.approx(4.0, abs=0.01) for place in told)
    swept, far = 0.0, [place for place in told if horizontal_distance(place, centre) > 0.5]
    for a, b in pairwise(far):
        swept += wrap(bearing(centre, b) - bearing(centre, a))
        turns = (abs(swept) + 2 * pi * horizontal_distance(far[0], centre) / 1.5) / (2 * pi)
        assert horizontal_distance(b, centre) == pytest.approx(1.5 * turns, abs=0.15)
    assert (swept < 0) == clockwise


def test_it_goes_on_from_its_progress() -> None:
    solo = Solo(INFO, {"radius": 3.0})
    solo.run(8)
    share = solo.activity.published.progress
    progress = solo.activity.progress()
    solo.activity.stop()
    again = Solo(INFO, {"radius": 3.0}, progress=progress, vehicle=(solo.session, solo.vehicle))
    again.step()
    assert again.activity.published.progress == pytest.approx(share, abs=0.01)
    again.run(100)
    assert again.word == "done"


def test_its_plan_stays_within_its_radius() -> None:
    start = PlanStart(Point(2, 0, 3), 0.0, True, 0.0, 5.0)
    values = {name: parameter.default for name, parameter in INFO.parameters.items()}
    legs = SearchSpiral.plan(SearchSpiral.Params(**{**values, "radius": 8.0}), start)
    assert legs is not None
    far = [horizontal_distance(leg.to, (2, 0, 3)) for leg in legs]
    assert far == sorted(far) and far[-1] == pytest.approx(8.0)
