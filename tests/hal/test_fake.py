"""The faults that a test can cause in the fake vehicle."""

from __future__ import annotations

import pytest

from hal.fake import FakeSession
from hal.lights import Lights
from hal.vehicle import VALIDITY, Hold, Position, Velocity
from tests.hal.flying import decided, take_off, wait
from vencejo.geometry import Point


def test_it_notes_what_it_is_told() -> None:
    session = FakeSession()
    vehicle = session.vehicles["drone"]
    vehicle.command(Hold())
    take_off(session)
    vehicle.command(Velocity(x=1.0))
    vehicle.land()
    session.wait()
    assert vehicle.commands == [Hold(), Velocity(x=1.0)]
    assert vehicle.verbs == ["takeoff", "land"]


@pytest.mark.parametrize("verb", ["arm", "disarm", "land", "return_home"])
def test_it_refuses_the_next_verb_once(verb: str) -> None:
    session = FakeSession()
    vehicle = session.vehicles["drone"]
    vehicle.refuse_next = "the compass spins"
    order = decided(session, getattr(vehicle, verb)())
    assert (order.verb, order.state, order.reason) == (verb, "refused", "the compass spins")
    assert decided(session, getattr(vehicle, verb)()).state == "done"


def test_only_the_next_of_two_verbs_is_refused() -> None:
    session = FakeSession()
    vehicle = take_off(session)
    session.vehicles["drone"].refuse_next = "not now"
    landing, lights = vehicle.land(), vehicle.lights(Lights("solid"))
    session.wait()
    assert (landing.state, landing.reason, lights.state) == ("refused", "not now", "done")


def test_a_set_point_runs_out_within_a_late_period() -> None:
    session = FakeSession()
    vehicle = take_off(session)
    before = vehicle.observe().position.x
    vehicle.command(Velocity(x=1.0))
    session.late = 5.0
    assert session.wait() == pytest.approx(5.025)
    assert vehicle.observe().position.x - before == pytest.approx(VALIDITY)
    session.wait()
    assert vehicle.observe().velocity.norm() == 0


def test_a_set_point_that_was_not_heard_is_not_flown_later() -> None:
    session = FakeSession()
    vehicle = take_off(session)
    session.vehicles["drone"].silent = True
    vehicle.command(Velocity(x=1.0))
    there = wait(session, 1)[-1].position
    session.vehicles["drone"].silent = False
    assert wait(session, 1)[-1].position == there


def test_it_stays_on_the_ground_while_unwell() -> None:
    session = FakeSession()
    vehicle = session.vehicles["drone"]
    vehicle.health = ("no position", "no heading")
    assert decided(session, vehicle.takeoff(2)).reason == "no position, no heading"
    assert vehicle.observe().health == ("no position", "no heading")
    vehicle.health = ()
    assert decided(session, vehicle.takeoff(2)).state == "accepted"


def test_it_gets_nowhere_when_stuck() -> None:
    session = FakeSession()
    vehicle = take_off(session)
    there = vehicle.observe().position
    session.vehicles["drone"].stuck = True
    seen = wait(session, 3, Position(Point(9.0, 0.0, 3.0)))[-1]
    assert (seen.position, seen.velocity) == (there, Point(0, 0, 0))


def test_the_wind_carries_it_along_in_the_air() -> None:
    session = FakeSession()
    session.vehicles["drone"].wind = Point(0.5, 0.0, 0.0)
    assert wait(session, 1)[-1].position == (0, 0, 0)
    vehicle = take_off(session)
    before = vehicle.observe().position.x
    assert wait(session, 2)[-1].position.x == pytest.approx(before + 1.0)


def test_what_is_set_is_observed() -> None:
    session = FakeSession(("a", "b"), places={"gate": Point(1, 2, 3)})
    session.vehicles["b"].battery, session.vehicles["b"].link_age = 0.25, 4.0
    session.wait()
    seen = session.vehicles["b"].observe()
    assert (seen.battery, seen.link_age, seen.position.x) == (0.25, 4.0, 2.0)
    assert session.places == {"gate": Point(1, 2, 3)}
