"""evade: a loop of beacons, faster from level to level."""

from __future__ import annotations

from math import atan2, hypot, pi
from typing import Any

import pytest

from behaviors import PlanStart, Unflyable, Waypoint
from behaviors.behavior import Behavior
from behaviors.evade import Evade, Evading
from hal.vehicle import PERIOD
from tests.behaviors.flying import Solo, airborne
from vencejo.geometry import Point, distance, wrap

SQUARE = [Point(*each) for each in ((8, 0, 3), (8, 8, 4), (0, 8, 3), (0, 0, 3.5))]


def mouse(**values: Any) -> Solo:
    given = {"beacons": SQUARE, "durations": [2.0, 12.0, 12.0], "speeds": [0.0, 1.0, 1.5]}
    return Solo("evade", {**given, **values})


def test_each_level_has_its_time_and_its_speed() -> None:
    solo = mouse()
    begin, speeds = solo.time, []
    while solo.step() and solo.outcome is None:
        seen = solo.vehicle.observe()
        speeds.append((solo.time - begin, hypot(seen.velocity.x, seen.velocity.y)))
        told = solo.activity.published
        assert isinstance(told, Evading)
        now = solo.time - begin
        assert told.level == (1 if now <= 2.01 else 2 if now <= 14.01 else 3)
    assert solo.word == "done" and solo.time - begin == pytest.approx(26.0, abs=0.1)
    assert [fields["level"] for _, fields in solo.events] == [1, 2, 3]
    assert all(speed < 0.05 for time, speed in speeds if time < 2)
    assert all(abs(speed - 1.0) < 0.12 for time, speed in speeds if 4 < time < 14)
    assert all(abs(speed - 1.5) < 0.15 for time, speed in speeds if 16 < time < 25)


def test_it_passes_the_beacons_in_a_loop_and_turns_no_faster_than_it_may() -> None:
    solo = mouse(durations=[60.0], speeds=[1.5], turn_rate=pi / 2)
    least = dict.fromkeys(range(4), 99.0)
    course, beacons = None, []
    for _ in range(round(45 / PERIOD)):
        solo.step()
        seen = solo.vehicle.observe()
        for number, beacon in enumerate(SQUARE):
            least[number] = min(least[number], distance(seen.position, beacon))
        told = solo.activity.published
        assert isinstance(told, Evading)
        beacons += [told.beacon] if not beacons or beacons[-1] != told.beacon else []
        if hypot(seen.velocity.x, seen.velocity.y) > 1.0:
            now = atan2(seen.velocity.y, seen.velocity.x)
            if course is not None:
                assert abs(wrap(now - course)) < 1.25 * pi / 2 * PERIOD
            course = now
            assert abs(wrap(seen.yaw - now)) < 0.25, "the nose is ahead"
    assert beacons[:6] == [0, 1, 2, 3, 0, 1]
    assert max(least.values()) < 0.8


def test_the_nose_may_stay() -> None:
    solo = mouse(durations=[20.0], speeds=[1.0], heading="keep")
    solo.run(15.0)
    assert abs(solo.vehicle.observe().yaw) < 0.01


def test_one_beacon_and_hairpins_are_flown_too() -> None:
    for points in ([(4, 0, 3)], [(6, 0, 3), (0, 0.2, 3)], [(1, 0, 3), (1.2, 0, 3), (1, 0.2, 3)]):
        solo = mouse(beacons=[Point(*each) for each in points], durations=[20.0], speeds=[1.5])
        assert solo.run(25.0) is not None and solo.word == "done"
        assert solo.vehicle.observe().position.norm() < 12


def test_it_goes_on_where_it_was() -> None:
    solo = mouse(durations=[2.0, 30.0], speeds=[0.0, 1.5])
    solo.run(12.0)
    progress = solo.activity.progress()
    on = Solo(
        "evade",
        {"beacons": SQUARE, "durations": [2.0, 30.0], "speeds": [0.0, 1.5]},
        progress=progress,
        vehicle=airborne(3.0),
    )
    begin = on.time
    on.run(40.0)
    assert on.word == "done" and on.time - begin == pytest.approx(20.0, abs=0.1)
    assert on.events == []


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"beacons": []}, "no beacon"),
        ({"durations": [1.0]}, "1 durations and 3 speeds"),
        ({"durations": [], "speeds": []}, "0 durations"),
        ({"speeds": [0.0, "fast", 1.0]}, "'fast' is no number"),
        ({"speeds": [0.0, -1.0, 1.0]}, "-1.0 is no number of 0 or more"),
    ],
)
def test_what_makes_no_game_is_refused(values: dict[str, Any], message: str) -> None:
    given = {"beacons": SQUARE, "durations": [2.0, 12.0, 12.0], "speeds": [0.0, 1.0, 1.5], **values}
    start = PlanStart(Point(0, 0, 3), 0.0, True, 0.0, 10.0)
    with pytest.raises(Unflyable, match=message):
        Evade.plan(params_of(Evade, given), start)
    solo = Solo("evade", given)
    solo.step()
    assert solo.word == "failed"


def params_of(behavior: type[Behavior], values: dict[str, Any]) -> Any:
    beacons = [Waypoint(each) for each in values["beacons"]]
    return behavior.Params(**{**values, "beacons": beacons})


def test_its_plan_is_the_loop_as_often_as_it_is_flown() -> None:
    given = {"beacons": SQUARE, "durations": [2.0, 20.0], "speeds": [0.0, 2.0]}
    legs = Evade.plan(params_of(Evade, given), PlanStart(Point(0, 0, 3), 0.0, True, 0.0, 10.0))
    assert legs is not None
    assert [leg.to for leg in legs] == [*SQUARE, SQUARE[0]]
    assert {leg.speed for leg in legs} == {2.0}
