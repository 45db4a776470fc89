"""follow_path."""

from __future__ import annotations

import json
from itertools import pairwise
from math import cos, pi, sin, sqrt, tan
from typing import Any

import pytest

from behaviors import Face, PlanStart, describe
from behaviors.activity import DroneActivity
from behaviors.follow_path import FollowPath
from behaviors.path_file import PathFile
from fsm.values.packing import pack, unpack
from hal.limits import Limits
from hal.vehicle import Position
from tests.behaviors.flying import Solo
from vencejo.geometry import Point, distance

INFO = describe(FollowPath)
EIGHT: dict[str, Any] = {
    "shape": "figure_eight", "center": Point(0.0, 0.0, 3.0), "length": 4.0, "width": 2.0,
}  # fmt: skip


def follow(values: dict[str, Any]) -> tuple[Solo, list[Position]]:
    """A whole flight, and its set-points."""
    solo = Solo(INFO, values)
    told = []
    while solo.outcome is None:
        setpoint = solo.step()
        assert isinstance(setpoint, Position)
        told.append(setpoint)
        assert solo.time < 200
    return solo, told


def at_speed(told: list[Position]) -> list[Position]:
    """The set-points between the first and the last at nearly full speed on the path."""
    speeds = [setpoint.velocity.norm() if setpoint.velocity else 0.0 for setpoint in told]
    begin = max(k for k, speed in enumerate(speeds[: len(speeds) * 4 // 5]) if speed < 1e-3)
    fast = [k for k, speed in enumerate(speeds) if speed > 0.98 * max(speeds) and k > begin]
    return told[fast[0] : fast[-1] + 1]


def test_a_figure_eight_is_at_each_place_at_its_time() -> None:
    solo, told = follow({**EIGHT, "speed": 1.0, "laps": 3})
    assert solo.word == "done"
    rate = 1.0 / (2 * sqrt(2))
    # Somewhere in the second lap: from there on it is a matter of time only.
    middle = told[len(told) // 2 - 300 : len(told) // 2 + 300]
    phases = [k * 0.0005 for k in range(round(2 * pi / 0.0005))]
    begin = min(phases, key=lambda a: distance(middle[0].xyz, (2 * cos(a), sin(2 * a), 3)))
    for k, setpoint in enumerate(middle):
        angle = begin + rate * k * 0.025
        assert distance(setpoint.xyz, (2 * cos(angle), sin(2 * angle), 3)) < 0.002
        assert setpoint.velocity == pytest.approx(
            (-2 * rate * sin(angle), 2 * rate * cos(2 * angle), 0), abs=0.02
        )
        assert setpoint.acceleration == pytest.approx(
            (-2 * rate**2 * cos(angle), -4 * rate**2 * sin(2 * angle), 0), abs=0.02
        )


def test_it_begins_and_ends_at_rest_and_says_its_laps() -> None:
    solo, told = follow({**EIGHT, "speed": 1.0, "laps": 2})
    assert [(name, fields["lap"]) for name, fields in solo.events] == [
        ("path.lap", 1),
        ("path.lap", 2),
    ]
    assert distance(solo.vehicle.position, (2, 0, 3)) < 0.01
    for a, b in pairwise(told[:-1]):
        assert a.velocity is not None and b.velocity is not None
        assert distance(a.velocity, b.velocity) < 2.9 * 0.025
    published = solo.activity.published
    assert (published.lap, published.laps, published.progress) == (2, 2, pytest.approx(1.0))


def test_a_circle_has_its_diameter_direction_and_speed() -> None:
    for clockwise in (False, True):
        values = {"shape": "circle", "length": 6.0, "axis": pi / 2, "clockwise": clockwise}
        solo, told = follow({**values, "speed": 1.5})
        flown = at_speed(told)
        assert all(distance(s.xyz, (0, 0, 3)) == pytest.approx(3, abs=1e-3) for s in flown)
        assert all(s.velocity and s.velocity.norm() == pytest.approx(1.5, rel=0.03) for s in flown)
        first = flown[0]
        assert first.velocity is not None
        turn = first.xyz.x * first.velocity.y - first.xyz.y * first.velocity.x
        assert (turn < 0) == clockwise
        assert distance(solo.vehicle.position, (0, 3, 3)) < 0.01


POINTS = [Point(0, 0, 3), Point(5, 2, 4), Point(8, 8, 3), Point(2, 9, 4)]


@pytest.mark.parametrize("closed", [False, True])
def test_a_curve_passes_through_its_points(closed: bool) -> None:
    solo, told = follow({"points": POINTS, "closed": closed, "speed": 2.0})
    assert solo.word == "done"
    for point in POINTS:
        assert min(distance(setpoint.xyz, point) for setpoint in told) < 0.1
    assert distance(solo.vehicle.position, POINTS[0 if closed else -1]) < 0.05
    assert max(s.velocity.norm() for s in told if s.velocity) <= 2.0 + 1e-6


def test_what_needs_more_tilt_is_flown_more_slowly_and_told() -> None:
    solo, told = follow({**EIGHT, "speed": 4.0})
    slower = solo.events[0]
    assert slower[0] == "path.slower" and slower[1]["asked"] == 4.0
    # Its largest acceleration is 3·√2·ω² or so; three quarters of the tilt are used.
    most = 0.75 * 9.81 * tan(0.35)
    largest = max(s.acceleration.norm() for s in at_speed(told) if s.acceleration)
    assert largest == pytest.approx(most, rel=0.02)
    fastest = max(s.velocity.norm() for s in told if s.velocity)
    assert slower[1]["speed"] == pytest.approx(fastest, rel=0.01)

    nimble = Solo(INFO)
    nimble.vehicle.configure(Limits(max_tilt=1.0))
    nimble = Solo(INFO, {**EIGHT, "speed": 4.0}, vehicle=(nimble.session, nimble.vehicle))
    nimble.run(2)
    assert nimble.events == []


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({}, "leads through 2 different points or more, not 0"),
        ({"points": [Point(0, 0, 3), Point(4, 0, 3), Point(0, 0, 3)]}, "cannot turn back at"),
    ],
)
def test_what_is_no_path_has_failed(values: dict[str, Any], reason: str) -> None:
    solo = Solo(INFO, values)
    solo.run(1)
    assert solo.outcome and solo.word == "failed" and reason in solo.outcome.fields["reason"]


def test_it_is_blocked_by_what_holds_it_up() -> None:
    for seconds in (1.0, 9.0):
        solo = Solo(INFO, {**EIGHT, "speed": 1.0, "laps": 5})
        solo.run(seconds)
        solo.vehicle.stuck = True
        solo.run(60)
        assert solo.outcome and solo.word == "blocked"
        assert "for 15 s" in solo.outcome.fields["reason"]


def test_headings() -> None:
    face = {"face": Point(0.0, 0.0, 0.0)}
    _, told = follow({"shape": "circle", "length": 8.0, "heading": face})
    inward = [s for s in at_speed(told) if s.yaw is not None]
    assert all(
        abs(cos(s.yaw or 0) * s.xyz.x + sin(s.yaw or 0) * s.xyz.y + 4) < 0.01 for s in inward
    )
    _, told = follow({"shape": "circle", "length": 8.0, "center": Point(0, 0, 3)})
    along = at_speed(told)
    assert all(
        s.velocity
        and abs(cos(s.yaw or 0) * s.velocity.x + sin(s.yaw or 0) * s.velocity.y - 2) < 0.1
        for s in along
    )


@pytest.mark.parametrize("values", [{**EIGHT, "speed": 1.0}, {"points": POINTS}])
def test_it_goes_on_where_it_was(values: dict[str, Any]) -> None:
    def fly(period: int) -> tuple[Any, ...]:
        solo, number = Solo(INFO, values), 0
        while solo.outcome is None:
            solo.step()
            if number == period:
                saved = json.loads(json.dumps(pack(solo.activity.saved()), allow_nan=False))
                solo.activity = DroneActivity.resumed(INFO, unpack(saved), solo.channel, solo._post)
            number += 1
        return number, solo.vehicle.position, solo.events

    whole = fly(-1)
    for period in (0, 50, 120, 200, 300):
        assert fly(period) == whole


def test_from_elsewhere_it_comes_back_to_where_it_was() -> None:
    solo = Solo(INFO, {**EIGHT, "speed": 1.0})
    solo.run(10)
    progress, here = solo.activity.progress(), solo.vehicle.position
    solo.activity.stop()
    solo.vehicle.position = Point(-6.0, 5.0, 3.0)
    solo.session.wait()
    again = Solo(
        INFO, {**EIGHT, "speed": 1.0}, progress=progress, vehicle=(solo.session, solo.vehicle)
    )
    nearest = 9.0
    while again.outcome is None:
        again.step()
        nearest = min(nearest, distance(again.vehicle.position, here))
        assert again.time < 100
    assert again.word == "done" and nearest < 0.15
    assert [name for name, _ in again.events] == ["path.lap"]


def test_its_plan_leads_along_its_first_lap_and_takes_its_time() -> None:
    start = PlanStart(Point(0, 0, 3), 0.0, True, 0.0, 5.0)
    defaults = {name: parameter.default for name, parameter in INFO.parameters.items()}
    values = {**defaults, **EIGHT, "speed": 1.0, "laps": 4, "heading": Face(Point(0, 0, 0))}
    legs = FollowPath.plan(FollowPath.Params(**values), start)
    assert legs is not None
    assert distance(legs[0].to, (2, 0, 3)) < 1e-6 and distance(legs[-1].to, (2, 0, 3)) < 1e-6
    assert len(legs) > 40
    way = sum(distance(a.to, b.to) / (b.speed or 1) for a, b in pairwise(legs))
    lap = 2 * pi * 2 * sqrt(2)
    assert way + legs[-1].dwell == pytest.approx(4 * lap, rel=0.02)


ROWS = PathFile(
    (Point(0, 0, 3), Point(4, 1, 3.5), Point(6, 4, 4), Point(2, 6, 3)),
    (0.0, 3.0, 6.0, 9.5),
    (0.0, 1.5, 3.0, -3.0),
)


def follow_file(file: PathFile, **values: Any) -> tuple[Solo, list[Position]]:
    solo = Solo(INFO)
    solo.channel.frame.files = {"path.csv": file}
    values = {"shape": "file", "file": "path.csv", **values}
    solo.activity = DroneActivity(INFO, values, None, solo.channel, solo._post)
    told = []
    while solo.outcome is None:
        setpoint = solo.step()
        assert isinstance(setpoint, Position)
        told.append(setpoint)
        assert solo.time < 100
    return solo, told


def nearest_period(told: list[Position], place: Point) -> int:
    return min(range(len(told)), key=lambda k: distance(told[k].xyz, place))


def test_a_file_with_times_is_at_its_places_at_these() -> None:
    solo, told = follow_file(ROWS)
    assert solo.word == "done" and [name for name, _ in solo.events] == ["path.lap"]
    assert ROWS.times is not None and ROWS.yaws is not None
    second, third = (nearest_period(told, place) for place in ROWS.places[1:3])
    for place, yaw in zip(ROWS.places[1:3], ROWS.yaws[1:3], strict=True):
        there = told[nearest_period(told, place)]
        assert distance(there.xyz, place) < 0.05
        assert there.yaw == pytest.approx(yaw, abs=0.05)
    assert (third - second) * 0.025 == pytest.approx(3.0, abs=0.03)
    assert distance(solo.vehicle.position, ROWS.places[-1]) < 0.01
    # Between the last two it turns from 3 to -3 rad by way of pi.
    yaws = [setpoint.yaw for setpoint in told[third + 4 :]]
    assert all(yaw is not None and abs(yaw) > 2.9 for yaw in yaws)


def test_a_heading_asked_for_goes_before_that_of_the_file() -> None:
    _, told = follow_file(ROWS, heading=0.25)
    assert all(setpoint.yaw == pytest.approx(0.25) for setpoint in told[100:])


def test_a_file_whose_times_are_too_short_is_slowed_as_a_whole_and_told() -> None:
    fast = PathFile(ROWS.places, (0.0, 0.6, 1.2, 1.9), None)
    solo, told = follow_file(fast)
    (name, fields), *_ = solo.events
    assert name == "path.slower" and fields["asked"] > 6.0
    fastest = max(s.velocity.norm() for s in told if s.velocity)
    assert fields["speed"] == pytest.approx(fastest, rel=0.03) and fields["speed"] < 4.0
    second, third = (nearest_period(told, place) for place in ROWS.places[1:3])
    factor = fields["asked"] / fields["speed"]
    assert (third - second) * 0.025 == pytest.approx(0.6 * factor, abs=0.05)


def test_a_file_without_times_is_flown_at_the_speed() -> None:
    given = PathFile(ROWS.places, None, None)
    solo, told = follow_file(given, speed=1.0)
    _, same = follow({"points": list(ROWS.places), "speed": 1.0})
    assert solo.word == "done" and told == same


def test_a_file_goes_on_where_it_was() -> None:
    whole, _ = follow_file(ROWS)
    solo = Solo(INFO)
    solo.channel.frame.files = {"path.csv": ROWS}
    values = {"shape": "file", "file": "path.csv"}
    solo.activity = DroneActivity(INFO, values, None, solo.channel, solo._post)
    solo.run(6.0)
    saved = json.loads(json.dumps(pack(solo.activity.saved()), allow_nan=False))
    assert saved["with"]["file"] == "path.csv"
    solo.activity = DroneActivity.resumed(INFO, unpack(saved), solo.channel, solo._post)
    solo.run(60.0)
    assert (solo.word, solo.time, solo.vehicle.position) == (
        *("done", whole.time, whole.vehicle.position),
    )


def test_a_plan_has_no_tiny_legs_however_many_rows_a_file_has() -> None:
    angles = [k * 0.005 for k in range(1001)]
    places = tuple(Point(3 * cos(a), 3 * sin(a), 3.0) for a in angles)
    dense = PathFile(places, tuple(4 * a for a in angles), None)
    start = PlanStart(Point(0, 0, 3), 0.0, True, 0.0, 5.0)
    defaults = {name: parameter.default for name, parameter in INFO.parameters.items()}
    values = {**defaults, "shape": "file", "file": dense}
    legs = FollowPath.plan(FollowPath.Params(**values), start)
    assert legs is not None and legs[-1].to == places[-1]
    assert all(0.24 < distance(a.to, b.to) < 0.5 for a, b in pairwise(legs[:-1]))
    seconds = sum(distance(a.to, b.to) / (b.speed or 1) for a, b in pairwise(legs))
    assert seconds == pytest.approx(20.0, rel=0.01)
