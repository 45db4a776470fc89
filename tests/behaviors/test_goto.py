"""goto."""

from __future__ import annotations

from math import pi, sqrt

import pytest

from behaviors import Face
from behaviors.arrival import PATIENCE
from behaviors.guidance import ACCELERATION, BRAKING
from hal.vehicle import Position
from tests.behaviors.flying import Solo
from vencejo.geometry import Point, distance, horizontal_distance

FAR = Point(6.0, -3.0, 5.0)


def test_it_arrives_and_commands_the_target_itself_in_the_end() -> None:
    solo = Solo("goto", {"to": FAR})
    solo.run(20)
    assert solo.word == "done"
    assert distance(solo.vehicle.position, FAR) < 0.2
    assert solo.vehicle.commands[-1] == Position(FAR, yaw=0.0)


def test_it_flies_straight_at_the_speed_asked_for() -> None:
    solo = Solo("goto", {"to": Point(10.0, 0.0, 3.0), "speed": 1.5})
    fastest = 0.0
    while solo.run(0.025) is None:
        fastest = max(fastest, solo.vehicle.observe().velocity.norm())
        assert solo.vehicle.position[1:] == pytest.approx((0, 3))
    assert fastest == pytest.approx(1.5)
    # Getting up to speed, the way, slowing down up to 0.2 m from its end, and the dwell.
    inside = sqrt(2 * 0.2 / BRAKING)
    due = 10 / 1.5 + 1.5 / 2 / ACCELERATION + 1.5 / 2 / BRAKING - inside + 0.5
    assert solo.time - 1.5 == pytest.approx(due, abs=0.1)


def test_the_dwell_is_without_a_break() -> None:
    solo = Solo("goto", {"to": Point(0.0, 0.0, 3.0), "dwell": 1.0})
    solo.run(0.9)
    solo.vehicle.position = Point(1.0, 0.0, 3.0)
    blown_off = solo.time
    solo.run(10)
    assert solo.word == "done"
    assert solo.time - blown_off > 1.0


def test_it_waits_for_the_heading() -> None:
    solo = Solo("goto", {"to": Point(0.0, 0.0, 3.0), "heading": pi, "dwell": 0.0})
    solo.run(10)
    assert solo.word == "done"
    assert solo.time - 1.5 == pytest.approx((pi - 0.15) / 1.75, abs=0.1)
    assert abs(solo.vehicle.yaw) > pi - 0.15


@pytest.mark.parametrize(
    ("heading", "yaw"),
    [
        ("keep", 1.0),
        ("travel", pi / 2),
        (-2.0, -2.0),
        ({"face": Point(-5.0, 5.0, 0.0)}, pi),
    ],
)
def test_headings(heading: object, yaw: float) -> None:
    solo = Solo("hover")
    solo.vehicle.yaw = 1.0
    solo.session.wait()
    values = {"to": Point(0.0, 5.0, 3.0), "heading": heading, "speed": 5.0}
    solo = Solo("goto", values, vehicle=(solo.session, solo.vehicle))
    solo.run(20)
    assert solo.word == "done"
    assert abs(solo.vehicle.yaw) == pytest.approx(abs(yaw), abs=0.05)


def test_travel_keeps_its_heading_where_the_way_is_too_short_or_upright() -> None:
    for to in (Point(0.1, 0.2, 3.0), Point(0.0, 0.0, 8.0)):
        solo = Solo("goto", {"to": to, "heading": "travel"})
        solo.run(20)
        assert solo.word == "done"
        assert solo.vehicle.yaw == 0.0


def test_it_is_blocked_when_it_comes_no_nearer() -> None:
    solo = Solo("goto", {"to": FAR})
    solo.run(1)
    solo.vehicle.stuck = True
    stuck_since = solo.time
    solo.run(60)
    assert solo.outcome and solo.word == "blocked"
    assert solo.outcome.fields["reason"] == "came no nearer for 15 s"
    assert solo.outcome.fields["distance"] == pytest.approx(distance(solo.vehicle.position, FAR))
    assert solo.time - stuck_since == pytest.approx(PATIENCE, abs=0.5)


def test_a_long_dwell_and_a_slow_way_are_not_blocked() -> None:
    solo = Solo("goto", {"to": Point(1.0, 0.0, 3.0), "speed": 0.05, "dwell": 40.0})
    solo.run(200)
    assert solo.word == "done"


def test_a_vehicle_slower_than_asked_for_is_waited_for() -> None:
    solo = Solo("goto", {"to": Point(0.0, 0.0, 93.0), "speed": 20.0})
    while solo.run(0.025) is None:
        reference = solo.vehicle.commands[-1]
        assert isinstance(reference, Position)
        assert distance(reference.xyz, solo.vehicle.position) < 0.8
    assert solo.word == "done"


def test_a_timeout_counts_in_any_case() -> None:
    solo = Solo("goto", {"to": Point(30.0, 0.0, 3.0), "timeout": 2.0})
    solo.run(10)
    assert solo.outcome and solo.outcome.fields["reason"] == "not there within 2 s"
    assert solo.time - 1.5 == pytest.approx(2.0, abs=0.06)


def test_a_live_target_is_followed() -> None:
    solo = Solo("goto", {"to": Point(5.0, 0.0, 3.0)})
    solo.run(2)
    solo.live = {"to": Point(0.0, 5.0, 3.0)}
    solo.run(20)
    assert solo.word == "done"
    assert distance(solo.vehicle.position, (0, 5, 3)) < 0.2


def test_a_live_target_that_is_lost_stays_where_it_was() -> None:
    solo = Solo("goto", {"to": Point(5.0, 0.0, 3.0)})
    solo.live = {"to": Point(0.0, 5.0, 3.0)}
    solo.run(1)
    solo.live = {"to": None}
    solo.run(20)
    assert solo.word == "done"
    assert distance(solo.vehicle.position, (0, 5, 3)) < 0.2


def test_a_live_speed_is_followed() -> None:
    solo = Solo("goto", {"to": Point(30.0, 0.0, 3.0)})
    solo.live = {"speed": 0.5}
    solo.run(4)
    assert solo.vehicle.observe().velocity.norm() == pytest.approx(0.5)
    solo.live = {"speed": 3.0}
    solo.run(3)
    assert solo.vehicle.observe().velocity.norm() == pytest.approx(3.0)


def test_a_moved_target_has_time_and_dwell_of_its_own() -> None:
    solo = Solo("goto", {"to": Point(0.0, 0.0, 3.0), "dwell": 30.0})
    solo.run(20)
    solo.live = {"to": Point(0.1, 0.0, 3.0)}
    moved = solo.time
    solo.run(60)
    assert solo.word == "done"
    assert solo.time - moved == pytest.approx(30.0, abs=0.1)


def test_what_it_publishes() -> None:
    solo = Solo("goto", {"to": Point(3.0, 4.0, 3.0), "heading": 1.0})
    assert solo.activity.published.distance == 0.0
    solo.step()
    seen = solo.activity.published
    assert (seen.distance, seen.yaw_error, seen.elapsed) == pytest.approx((5.0, 1.0, 0.0))


def test_two_coordinates_keep_the_height_and_words_name_directions() -> None:
    solo = Solo("goto", {"to": {"x": 1.0, "y": 2.0}})
    solo.run(10)
    assert distance(solo.vehicle.position, (1, 2, 3)) < 0.2
    solo = Solo("goto", {"to": {"forward": 2.0, "up": 1.0}})
    solo.run(10)
    assert distance(solo.vehicle.position, (2, 0, 4)) < 0.2
    assert horizontal_distance(solo.vehicle.position, (2, 0, 4)) < 0.2


def test_facing_a_point_right_below_keeps_the_heading() -> None:
    solo = Solo("goto", {"to": Point(0.0, 0.0, 5.0), "heading": {"face": Point(0.1, 0.0, 0.0)}})
    solo.run(10)
    assert solo.word == "done"
    assert solo.vehicle.yaw == 0.0
    assert isinstance(solo.activity._behavior.params.heading, Face)
