"""land."""

from __future__ import annotations

from math import pi

import pytest

from behaviors.landing import Descent
from hal.vehicle import Position
from tests.behaviors.flying import Rig, Solo, airborne
from vencejo.geometry import about_y, horizontal_distance, product, yaw_quaternion


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


# Where it does not stand.


def test_it_tries_again_beside() -> None:
    solo = Solo("land")
    solo.vehicle.unstable_on = ["ball"]
    start = solo.vehicle.position
    solo.run(60)
    assert solo.word == "done" and not solo.vehicle.observe().armed
    assert solo.vehicle.verbs == ["takeoff", "land", "land"]
    assert horizontal_distance(solo.vehicle.position, start) >= 1.0
    # It rises before it goes there.
    ways = [each for each in solo.vehicle.commands if isinstance(each, Position)]
    assert ways[0].xyz == pytest.approx((0, 0, 1)) and ways[-1].xyz.z == pytest.approx(1)


def test_it_tries_three_times_and_has_failed_then() -> None:
    solo = Solo("land")
    solo.vehicle.unstable_on = ["ball", "roof", "roof", "ledge", "never"]
    places = []
    while solo.outcome is None:
        solo.step()
        if any(event.name == "vehicle.unstable" for event in solo.vehicle.observe().events):
            places.append(solo.vehicle.position)
    assert solo.outcome.word == "failed"
    assert solo.outcome.fields == {"reason": "land refused: it does not stand on the ledge"}
    assert solo.vehicle.verbs.count("land") == 4 and solo.vehicle.unstable_on == ["never"]
    for k, place in enumerate(places):
        assert all(horizontal_distance(place, other) >= 1.0 for other in places[:k])


def test_without_a_sign_it_goes_back_and_on_the_same_way() -> None:
    session, vehicle = airborne()
    vehicle.yaw = pi / 2
    solo = Solo("land", vehicle=(session, vehicle))
    vehicle.unstable_on = ["ball", "ball"]
    solo.run(90)
    assert solo.word == "done"
    assert vehicle.position.x == pytest.approx(0, abs=0.3)
    assert vehicle.position.y == pytest.approx(-3.0, abs=0.5)


def test_it_goes_to_the_side_to_which_it_slid() -> None:
    solo = Solo("land")
    solo.vehicle.unstable_on = ["roof"]
    while solo.vehicle.position.z > 1.0:
        solo.step()
    solo.vehicle.position = solo.vehicle.position._replace(y=-0.2)
    solo.run(60)
    assert solo.word == "done"
    assert solo.vehicle.position[:2] == pytest.approx((0, -1.7), abs=0.25)


def test_it_goes_to_the_side_to_which_it_leans() -> None:
    seen = airborne()[1].observe()
    nose_up = product(yaw_quaternion(pi / 2), about_y(-0.2))
    descent = Descent()
    descent.watch(seen)
    aside = descent.aside(seen._replace(attitude=nose_up))
    up = aside.step(seen)
    assert up is not None and up.xyz == pytest.approx((0, 0, 4))
    over = aside.step(seen._replace(position=up.xyz))
    assert over is not None and over.xyz == pytest.approx((0, -1.5, 4))
    assert aside.step(seen._replace(position=over.xyz)) is None


def test_what_is_in_the_way_does_not_hinder_it_for_long() -> None:
    solo = Solo("land", {"timeout": 60.0})
    solo.vehicle.unstable_on = ["ball"]
    solo.until_unstable()
    solo.vehicle.stuck = True
    solo.run(15)
    solo.vehicle.stuck = False
    solo.run(15)
    assert solo.word == "done"


def test_the_timeout_counts_for_all_tries() -> None:
    solo = Solo("land", {"timeout": 8.0})
    solo.vehicle.unstable_on = ["ball"]
    solo.until_unstable()
    solo.vehicle.stuck = True
    solo.run(20)
    assert solo.outcome and solo.outcome.fields == {"reason": "land took too long"}
    assert solo.time < 11


def test_tries_are_counted_on_when_it_is_resumed() -> None:
    solo = Solo("land")
    solo.vehicle.unstable_on = ["ball", "ball"]
    solo.until_unstable()
    solo.step()
    progress = solo.activity.progress()
    assert progress is not None and progress["tries"] == 1
    again = Solo("land", progress=progress, vehicle=(solo.session, solo.vehicle))
    again.vehicle.unstable_on = ["ball"] * 4
    again.run(90)
    assert again.word == "failed" and again.vehicle.unstable_on == ["ball"]


def test_a_refusal_for_another_reason_is_none_of_these() -> None:
    solo = Solo("land")
    solo.run(1)
    solo.vehicle.tell("vehicle.collision", thing="wall")
    solo.vehicle.orders.end("not here")
    solo.run(1)
    assert solo.outcome and solo.outcome.fields == {"reason": "land refused: not here"}


MISSION = """
mission: m
states:
  up: {do: takeoff, with: {altitude: 3 m}, on: {done: %s}}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


def test_the_landing_past_the_mission_tries_again_until_it_stands() -> None:
    rig = Rig(MISSION % "finish")
    rig.vehicle.unstable_on = ["ball"] * 6
    rig.run(200)
    assert rig.pilot.finished and rig.pilot.outcome == "done"
    seen = rig.vehicle.observe()
    assert not seen.armed and rig.vehicle.unstable_on == []
    assert horizontal_distance(seen.position, (0, 0, 0)) > 6
    landings = [kind for kind, _ in rig.records if kind == "landing"]
    assert len(landings) == 7


def test_a_mission_hears_it_and_a_failed_landing_is_tried_on_past_it() -> None:
    rig = Rig(MISSION % "land")
    rig.vehicle.unstable_on = ["roof"] * 5
    rig.run(200)
    events = [fields["name"] for kind, fields in rig.records if kind == "event"]
    assert events.count("vehicle.unstable") == 4 and "failed" in events
    assert rig.pilot.finished and rig.pilot.outcome == "failed"
    assert rig.pilot.reason.endswith("land refused: it does not stand on the roof")
    assert not rig.vehicle.observe().armed
