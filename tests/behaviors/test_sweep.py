"""sweep: all of an area in lanes, without detecting anything."""

from __future__ import annotations

from math import pi
from typing import Any

import pytest

from behaviors import PlanStart, describe
from behaviors.plan import Unflyable
from behaviors.sweep import Sweep
from tests.behaviors.flying import Rig, Solo
from vencejo.geometry import Point, distance

INFO = describe(Sweep)
FIELD = [Point(0, 0, 0), Point(12, 0, 0), Point(12, 6, 0), Point(0, 6, 0)]
PLACES = [Point(*p, 3.0) for p in [(1, 1), (11, 1), (11, 3), (1, 3), (1, 5), (11, 5)]]


def plan_of(values: dict[str, Any]) -> list[Any]:
    start = PlanStart(Point(0, 0, 3), 0.0, True, 0.0, 5.0)
    given = {name: parameter.default for name, parameter in INFO.parameters.items()}
    legs = Sweep.plan(Sweep.Params(**{**given, **values}), start)
    assert legs is not None
    return list(legs)


def fly(solo: Solo, seconds: float = 100) -> list[Point]:
    track = []
    while solo.run(0.025) is None and solo.time < seconds:
        track.append(solo.vehicle.position)
    return track


def test_it_flies_its_plan_at_the_height_at_which_it_began() -> None:
    legs = plan_of({"area": FIELD})
    assert [leg.to for leg in legs] == PLACES
    assert {leg.yaw for leg in legs} == {0.0}
    solo = Solo(INFO, {"area": FIELD})
    track = fly(solo)
    assert solo.word == "done" and solo.events == []
    assert max(min(distance(place, at) for at in track) for place in PLACES) <= 0.5
    assert all(abs(place.z - 3.0) < 0.05 for place in track)
    assert (solo.activity.published.lanes, solo.activity.published.progress) == (3, 1.0)
    assert abs(solo.vehicle.observe().yaw) < 0.05  # along the lanes on all of them


def test_height_heading_and_direction_are_as_given() -> None:
    values = {"area": FIELD, "height": 5.0, "axis": pi / 2, "heading": "travel", "step": 4.0}
    legs = plan_of(values)
    assert {leg.to.z for leg in legs} == {5.0}
    assert {round(leg.to.x, 6) for leg in legs} == {2.0, 6.0, 10.0}
    assert [round(leg.yaw, 3) for leg in legs[1::2]] == [1.571, -1.571, 1.571]


def test_it_leaves_out_holes() -> None:
    hole = [Point(5, 2, 0), Point(7, 2, 0), Point(7, 4, 0), Point(5, 4, 0)]
    solo = Solo(INFO, {"area": FIELD, "holes": [hole]})
    track = fly(solo)
    assert solo.word == "done"
    assert not any(5.3 < at.x < 6.7 and 2.3 < at.y < 3.7 for at in track)


@pytest.mark.parametrize(("moved", "again"), [(0.0, False), (9.0, True)])
def test_it_goes_on_with_its_lane(moved: float, again: bool) -> None:
    values = {"area": FIELD}
    solo = Solo(INFO, values)
    while solo.activity.published.lane < 2 or solo.vehicle.position.x > 6:
        solo.step()
    progress = solo.activity.progress()
    solo.activity.stop()
    solo.vehicle.position = solo.vehicle.position.plus((0.0, moved, 0.0))
    solo.session.wait()
    other = Solo(INFO, values, progress=progress, vehicle=(solo.session, solo.vehicle))
    track = fly(other)
    assert other.word == "done"
    # From farther away it begins the second lane anew; the first is not flown again.
    assert (min(distance(PLACES[2], at) for at in track) <= 0.5) == again
    assert min(distance(PLACES[1], at) for at in track) > 1.0
    assert max(min(distance(place, at) for at in track) for place in PLACES[3:]) <= 0.5


def test_what_holds_it_up_makes_it_fail() -> None:
    solo = Solo(INFO, {"area": FIELD})
    solo.run(2)
    solo.vehicle.stuck = True
    solo.run(30)
    assert solo.outcome is not None and solo.word == "failed"
    assert solo.outcome.fields["reason"] == "came no nearer for 15 s"


@pytest.mark.parametrize(
    ("values", "message", "parameter"),
    [
        ({"area": FIELD[:2]}, "3 different corners", "area"),
        ({"area": [FIELD[0], FIELD[2], FIELD[1], FIELD[3]]}, "crosses or touches", "area"),
        ({"area": FIELD, "holes": [FIELD[:2]]}, "3 different corners", "holes"),
        ({"area": FIELD, "holes": [FIELD]}, "leave nothing", "holes"),
        ({"area": FIELD, "step": 1e-4}, "in 60000 lanes", "area"),
    ],
)
def test_what_is_no_area_is_told_before_the_flight(
    values: dict[str, Any], message: str, parameter: str
) -> None:
    with pytest.raises(Unflyable, match=message) as raised:
        plan_of(values)
    assert raised.value.parameter == parameter


def test_a_mission_gives_holes_as_a_list_of_areas() -> None:
    rig = Rig(
        """
mission: holes
parameters:
  field: {type: area, default: [[0, 0], [8, 0], [8, 6], [0, 6]]}
  holes: {type: [area], default: [[[3, 2], [5, 2], [5, 4], {x: 3 m, y: 4 m}]]}
states:
  up: {do: takeoff, with: {altitude: 3 m}, on: {done: fly, failed: down}}
  fly: {do: sweep, with: {area: $field, holes: $holes}, on: {done: down, failed: down}}
  down: {do: land, on: {done: end}}
  end: {type: final}
"""
    )
    over = []
    while not rig.pilot.finished:
        rig.period()
        over.append(rig.vehicle.observe().position)
    assert rig.pilot.outcome == "done"
    assert not any(3.3 < at.x < 4.7 and 2.3 < at.y < 3.7 for at in over)
    assert max(at.x for at in over) > 6.9 and max(at.y for at in over) > 4.9
