"""Flights that are saved and go on with a new pilot end as if nothing had happened."""

from __future__ import annotations

import json
from typing import Any

import pytest

from behaviors.activity import DroneActivity
from behaviors.pilot import resume_flight, save_flight
from fsm.values.packing import pack, unpack
from hal.vehicle import Hold
from tests.behaviors.flying import Rig, Solo
from vencejo.errors import UserError
from vencejo.geometry import Point, distance

TRIP = """
mission: trip
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: out, failed: down}}
  out:
    do: goto
    with: {to: {forward: 2 m, left: 1 m}, heading: 90 deg}
    on: {done: look, "*": down}
  look: {do: hover, after: {400 ms: round}}
  round:
    do: route
    with: {points: [{forward: 1 m}, {at: {left: 1 m}, dwell: 200 ms}, [0, 0]], speed: 3 m/s}
    on: {done: push, blocked: down, failed: down}
  push: {do: move, with: {forward: 1 m/s, up: 20 cm/s}, after: {500 ms: back}}
  back: {do: goto, live: {to: {forward: 1 m}}, with: {dwell: 100 ms}, on: {done: home, "*": down}}
  home: {do: return_home, on: {done: end, failed: down}}
  down: {do: land, on: {done: end}}
  end: {type: final}
"""


def flown(saved_after: set[int] | None) -> tuple[Any, ...]:
    """The trip, with a new pilot after each of these periods (None: after every one)."""
    rig = Rig(TRIP)
    number = 0
    while not rig.pilot.finished:
        rig.period()
        if saved_after is None or number in saved_after:
            saved = json.loads(json.dumps(save_flight(rig.pilot), allow_nan=False))
            rig.pilot = resume_flight(rig.pilot.instance.graph, rig.vehicle, saved)
        number += 1
        assert number < 4000
    return rig.pilot.outcome, rig.states, rig.vehicle.position, number


WHOLE = flown(set())


def test_the_trip_visits_every_behaviour_but_land() -> None:
    assert WHOLE[:2] == ("done", ["up", "out", "look", "round", "push", "back", "home", "end"])


@pytest.mark.parametrize(
    "first", [7, *(pytest.param(n, marks=pytest.mark.slow) for n in range(20) if n != 7)]
)
def test_a_flight_saved_at_any_period_ends_the_same(first: int) -> None:
    """All periods, each in a flight of its own, twenty apart in one test."""
    for number in range(first, WHOLE[3], 20):
        check(flown({number}))


def test_a_flight_saved_at_every_period_ends_the_same() -> None:
    check(flown(None))


def check(found: tuple[Any, ...]) -> None:
    assert found[:2] == WHOLE[:2]
    assert distance(found[2], WHOLE[2]) < 0.05
    assert abs(found[3] - WHOLE[3]) <= 2


@pytest.mark.parametrize(
    ("name", "values", "grounded"),
    [
        ("takeoff", {"altitude": 2.0}, True),
        ("land", {}, False),
        ("return_home", {}, False),
        ("hover", {"heading": 1.0}, False),
        ("move", {"forward": 1.0, "yaw_rate": 0.3}, False),
        ("goto", {"to": {"forward": 2.0}, "dwell": 0.2, "heading": "travel"}, False),
        ("goto", {"to": {"forward": 200.0}, "timeout": 1.5}, False),
        ("route", {"points": [{"forward": 1.0}, {"left": 1.0}], "heading": "keep"}, False),
    ],
)
def test_each_behaviour_goes_on_where_it_was(name: str, values: Any, grounded: bool) -> None:
    def fly(period: int) -> tuple[Any, ...]:
        solo = Solo(name, values, grounded=grounded)
        for number in range(100):
            solo.step()
            if solo.outcome is not None:
                break
            if number == period:
                saved = json.loads(json.dumps(pack(solo.activity.saved()), allow_nan=False))
                solo.activity = DroneActivity.resumed(
                    solo.activity.info, unpack(saved), solo.channel, solo._post
                )
        return solo.word, solo.vehicle.position, solo.vehicle.yaw, number, len(solo.events)

    whole = fly(-1)
    for period in range(0, whole[3], 3):
        word, place, yaw, periods, events = fly(period)
        assert (word, events) == (whole[0], whole[4]), period
        # An order that is given again after it was done is done in the period after that.
        assert 0 <= periods - whole[3] <= 1
        assert distance(place, whole[1]) < 1e-6 and abs(yaw - whole[2]) < 1e-6


HOVER = """
mission: hover
data: {lows: 0}
states:
  up: {do: takeoff, on: {done: stay, failed: down}}
  stay:
    do: hover
    on: {battery.low: {actions: {set: {lows: "${lows + 1}"}, log: "low $lows"}}}
    after: {1 s: over}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""


def again(rig: Rig) -> None:
    saved = json.loads(json.dumps(save_flight(rig.pilot), allow_nan=False))
    rig.pilot = resume_flight(rig.pilot.instance.graph, rig.vehicle, saved)


def test_what_was_said_is_not_said_again() -> None:
    rig = Rig(HOVER)
    rig.until_in("stay")
    rig.vehicle.battery = 0.25
    rig.run(0.2)
    again(rig)
    rig.run(0.2)
    assert [fields["text"] for kind, fields in rig.records if kind == "log"] == ["low 1"]


def test_a_mission_that_ended_in_the_air_is_still_brought_down() -> None:
    rig = Rig(HOVER)
    rig.until(lambda: rig.pilot.outcome is not None)
    again(rig)
    rig.run(30.0)
    assert (rig.pilot.finished, rig.pilot.outcome, rig.vehicle.position.z) == (True, "done", 0.0)


def test_a_jump_between_saving_and_resuming_leads_nothing_astray() -> None:
    """The frame follows a jump that nobody saw, and one from before is not followed again."""
    rig = Rig(TRIP.replace("{forward: 2 m, left: 1 m}", "[2, 1, 2]"))
    rig.until_in("out")
    rig.run(0.5)
    shift = Point(40.0, -20.0, 3.0)
    for unseen in (False, True):
        rig.vehicle.jump(shift)
        if unseen:
            rig.session.wait()
        else:
            rig.period()
        again(rig)
        rig.run(0.2)
    rig.until_in("look")
    assert distance(rig.vehicle.position, shift.plus(shift).plus((2, 1, 2))) < 0.3
    assert [fields["epoch"] for kind, fields in rig.records if kind == "jump"] == [1, 2]


def test_who_flies_meanwhile_is_not_landed_by_resuming() -> None:
    rig = Rig(HOVER)
    rig.until_in("stay")
    rig.pilot.land_now()
    rig.run(0.2)
    rig.vehicle.authority = "operator"
    rig.vehicle.orders.end("mode POSCTL")
    rig.vehicle.fly(Hold())
    rig.run(0.2)
    again(rig)
    rig.run(5)
    assert rig.vehicle.verbs.count("land") == 1
    rig.vehicle.authority = "mission"
    rig.run(20)
    assert rig.pilot.finished and rig.vehicle.verbs.count("land") == 2


def test_draws_go_on() -> None:
    rig = Rig(HOVER)
    rig.pilot.channel.rng.random()
    saved = save_flight(rig.pilot)
    expected = rig.pilot.channel.rng.random()
    resumed = resume_flight(rig.pilot.instance.graph, rig.vehicle, saved)
    assert resumed.channel.rng.random() == expected


@pytest.mark.parametrize("part", ["pilot", "running"])
def test_a_flight_with_a_part_missing_is_refused(part: str) -> None:
    rig = Rig(HOVER)
    rig.run(1.0)
    saved = save_flight(rig.pilot)
    del saved[part]
    with pytest.raises(UserError) as refused:
        resume_flight(rig.pilot.instance.graph, rig.vehicle, saved)
    assert refused.value.code == "torn-save"


@pytest.mark.parametrize("part", ["origin", "origin_shift", "watch", "rng", "last"])
def test_a_flight_with_a_part_of_another_form_is_refused(part: str) -> None:
    rig = Rig(HOVER)
    rig.run(1.0)
    saved = save_flight(rig.pilot)
    saved["pilot"][part] = 7
    with pytest.raises(UserError) as refused:
        resume_flight(rig.pilot.instance.graph, rig.vehicle, saved)
    assert refused.value.code == "torn-save"
