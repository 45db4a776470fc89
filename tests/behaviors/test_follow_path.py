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
