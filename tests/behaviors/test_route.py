"""route."""

from __future__ import annotations

from math import pi
from typing import Any

import pytest

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
    assert progress["leg"]["target"] == list(points[1])
    assert (progress["leg"]["nearest"], progress["leg"]["no_nearer"]) == (None, 0.0)


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
