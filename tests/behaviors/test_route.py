"""route."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import pytest

from hal.limits import Limits
from tests.behaviors.flying import Rig, Solo
from vencejo.geometry import Point, distance

CORNERS = [Point(4.0, 0.0, 3.0), Point(4.0, 4.0, 4.0), Point(0.0, 4.0, 3.0)]


def nearest(track: list[Point], place: Point) -> float:
    return min(distance(point, place) for point in track)


def fly(solo: Solo, seconds: float = 120) -> list[Point]:
    track = []
    while solo.run(0.025) is None and solo.time < seconds:
        track.append(solo.vehicle.position)
    return track


def test_it_visits_every_point_in_order() -> None:
    solo = Solo("route", {"points": CORNERS})
    track = fly(solo)
    assert solo.word == "done"
    assert all(nearest(track, corner) <= 0.5 for corner in CORNERS)
    assert solo.events == [
        ("route.reached", {"index": index, "position": corner})
        for index, corner in enumerate(CORNERS)
    ]
    assert solo.vehicle.commands[-1].xyz == CORNERS[-1]


def test_without_a_dwell_it_flies_on_through_the_points() -> None:
    solo = Solo("route", {"points": [Point(3.0 * k, 0.0, 3.0) for k in range(1, 4)]})
    slowest = 9.0
    while solo.run(0.025) is None:
        if 1.0 < solo.vehicle.position.x < 8.0:
            slowest = min(slowest, solo.vehicle.observe().velocity.norm())
    assert slowest > 0.8


def test_a_dwell_is_waited_for_at_each_point() -> None:
    quick, slow = (Solo("route", {"points": CORNERS, "dwell": dwell}) for dwell in (0.0, 2.0))
    fly(quick), fly(slow)
    assert slow.time - quick.time > 3 * 2.0


def test_points_have_settings_of_their_own() -> None:
    points: list[Any] = [
        {"at": CORNERS[0], "speed": 0.5, "heading": pi},
        {"at": {"x": 4.0, "y": 4.0}, "dwell": 3.0},
        CORNERS[2],
    ]
    solo = Solo("route", {"points": points, "speed": 3.0})
    headings, fastest = {}, {0: 0.0, 1: 0.0, 2: 0.0}
    while solo.run(0.025) is None:
        index = solo.activity.published.index
        fastest[index] = max(fastest[index], solo.vehicle.observe().velocity.norm())
        headings[index] = solo.vehicle.yaw
    assert solo.word == "done"
    assert fastest[0] == pytest.approx(0.5, abs=0.01)
    assert fastest[1] > 1.5
    assert abs(headings[0]) == pytest.approx(pi, abs=0.16)
    assert headings[1] == pytest.approx(pi / 2, abs=0.16)


def test_a_route_without_points_is_done() -> None:
    solo = Solo("route", {"points": []})
    solo.run(1)
    assert solo.word == "done"


def test_the_same_point_twice_is_reached_twice() -> None:
    solo = Solo("route", {"points": [CORNERS[0], CORNERS[0]], "dwell": 1.0})
    solo.run(30)
    assert [fields["index"] for _, fields in solo.events] == [0, 1]
    assert solo.time > 1.5 + 2.0


def test_it_is_blocked_by_what_holds_it_up_and_by_the_time_for_a_point() -> None:
    solo = Solo("route", {"points": CORNERS})
    solo.vehicle.stuck = True
    solo.run(60)
    assert solo.outcome and solo.outcome.fields["reason"] == "came no nearer for 15 s"

    # Each point has its own time: the whole takes longer.
    solo = Solo("route", {"points": CORNERS, "timeout": 4.0})
    solo.run(60)
    assert solo.word == "done" and solo.time > 6

    solo = Solo("route", {"points": CORNERS, "timeout": 4.0, "speed": 0.5})
    solo.run(60)
    assert solo.outcome and solo.outcome.fields["reason"] == "not there within 4 s"


def test_what_it_publishes() -> None:
    solo = Solo("route", {"points": CORNERS})
    solo.step()
    seen = solo.activity.published
    assert (seen.index, seen.count, seen.distance) == (0, 3, pytest.approx(4.0))


def test_it_goes_on_where_it_was_when_its_state_was_left() -> None:
    solo = Solo("route", {"points": CORNERS})
    solo.run(4)
    progress = solo.activity.progress()
    assert progress["index"] == 1
    solo.activity.stop()
    again = Solo(
        "route", {"points": CORNERS}, progress=progress, vehicle=(solo.session, solo.vehicle)
    )
    fly(again)
    assert [fields["index"] for _, fields in again.events] == [1, 2]


def test_its_progress_is_known_from_the_first_step_on() -> None:
    """Also when that step reaches the first point, and begins the way to the second."""
    points = [Point(0.0, 0.0, 3.0), Point(9.0, 0.0, 3.0)]
    solo = Solo("route", {"points": points})
    solo.step()
    progress = solo.activity.progress()
    assert [fields["index"] for _, fields in solo.events] == [0]
    assert progress["index"] == 1
    watch = progress["way"]["watch"]
    assert watch["target"] == list(points[1])
    assert (watch["nearest"], watch["no_nearer"]) == (9.0, 0.0)


def test_progress_beyond_the_route_is_its_end() -> None:
    solo = Solo("route", {"points": CORNERS}, progress={"index": 3})
    solo.run(1)
    assert solo.word == "done"


def test_a_history_state_resumes_it() -> None:
    rig = Rig(
        """
mission: interrupted
events: {test.pause: {}}
states:
  takeoff: {do: takeoff, on: {done: work}}
  work:
    on: {test.pause: pause}
    states:
      fly:
        do: route
        with: {points: [[4, 0, 3], [4, 4, 3], [0, 4, 3]], heading: keep}
        on: {done: land, blocked: land}
      back: {type: history, target: fly}
  pause: {do: hover, after: {2 s: work.back}}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""
    )
    rig.until(lambda: rig.vehicle.position.y > 2.0)
    rig.pilot.instance.post("test.pause")
    rig.run(60)
    assert rig.pilot.outcome == "done"
    reached = [
        fields["fields"]["index"]
        for kind, fields in rig.records
        if kind == "event" and fields["name"] == "route.reached"
    ]
    assert reached == [0, 1, 2]
    assert rig.states.count("work.fly") == 2


def circle(radius: float, count: int) -> list[Point]:
    """Points of a circle through the start, close to each other."""
    angles = [2 * pi * k / count for k in range(1, count + 1)]
    return [Point(radius * sin(a), radius * (1 - cos(a)), 3.0) for a in angles]


@pytest.mark.parametrize("speed", [2.0, 3.0])
def test_points_close_to_each_other_are_flown_at_the_speed_asked_for(speed: float) -> None:
    solo = Solo("route", {"points": circle(6.0, 32), "speed": speed})
    speeds = []
    while solo.run(0.025) is None:
        speeds.append(solo.vehicle.observe().velocity.norm())
    cruising = speeds[100:-100]
    assert solo.word == "done" and len(solo.events) == 32
    assert max(speeds) <= speed * 1.001
    assert min(cruising) > 0.97 * speed


def test_more_points_than_periods_are_all_reached() -> None:
    points = [Point(0.02 * k, 0.0, 3.0) for k in range(1, 301)]
    solo = Solo("route", {"points": points, "speed": 3.0, "tolerance": 0.02})
    solo.run(20)
    assert solo.word == "done"
    assert [fields["index"] for _, fields in solo.events] == list(range(300))


def test_a_corner_is_passed_within_its_tolerance_without_a_stop() -> None:
    for tolerance in (0.1, 0.5, 2.0):
        solo = Solo("route", {"points": CORNERS, "tolerance": tolerance})
        track, slowest = [], 9.0
        while solo.run(0.025) is None:
            track.append(solo.vehicle.position)
            if nearest(track[-1:], CORNERS[0]) < 0.5:
                slowest = min(slowest, solo.vehicle.observe().velocity.norm())
        assert nearest(track, CORNERS[0]) <= tolerance
        assert slowest > 0.2
        assert solo.time < 12.0


def test_the_way_back_is_a_stop_and_not_an_arc() -> None:
    there, back = Point(5.0, 0.0, 3.0), Point(0.0, 0.0, 3.0)
    solo = Solo("route", {"points": [there, there, back]})
    track = fly(solo)
    assert solo.word == "done" and len(solo.events) == 3
    assert nearest(track, there) < 0.01
    assert all(place[1:] == pytest.approx((0, 3)) for place in track)


def test_a_point_that_the_wind_kept_it_from_is_flown_back_to() -> None:
    solo = Solo(
        "route", {"points": [Point(4.0, 0.0, 3.0), Point(12.0, 0.0, 3.0)], "tolerance": 0.1}
    )
    solo.vehicle.wind = Point(0.0, 4.5, 0.0)
    solo.run(3)
    assert solo.vehicle.position.x > 4.2 and solo.events == []
    solo.vehicle.wind = Point(0.0, 0.0, 0.0)
    track = fly(solo)
    assert solo.word == "done"
    assert [fields["index"] for _, fields in solo.events] == [0, 1]
    assert nearest(track, Point(4.0, 0.0, 3.0)) <= 0.1


def test_tolerances_of_height_and_place_are_apart() -> None:
    points = [Point(4.0, 0.0, 3.0), Point(8.0, 0.0, 3.0)]
    for vertical, word in ((0.1, None), (0.5, "done")):
        solo = Solo("route", {"points": points, "tolerance": 0.6, "tolerance_vertical": vertical})
        solo.vehicle.configure(Limits(max_altitude=2.6))
        solo.run(10)
        assert solo.word == word


def test_it_brakes_before_it_begins_where_it_moves() -> None:
    moving = Solo("move", {"forward": 2.0, "left": 0.0})
    moving.run(3)
    here = moving.vehicle.position
    solo = Solo(
        "route", {"points": [here.plus((0, 5, 0))]}, vehicle=(moving.session, moving.vehicle)
    )
    before = moving.vehicle.observe().velocity
    while solo.run(0.025) is None:
        velocity = solo.vehicle.observe().velocity
        assert distance(velocity, before) < 0.08
        before = velocity
    assert solo.word == "done"
