"""Authority, lost links, late periods and jumps of the world frame, as a mission meets them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from behaviors.pilot import LANDING_TIMEOUT, SILENCE_TIMEOUT
from behaviors.vocabulary import EVENTS
from hal.fake import FakeSession
from hal.limits import Limits
from hal.orders import ANSWER_WITHIN
from hal.vehicle import PERIOD, Hold, Options, Velocity
from tests.behaviors.flying import Rig
from vencejo.errors import VehicleError
from vencejo.geometry import Point, distance

FLIGHT = """
mission: flight
states:
  takeoff: {do: takeoff, with: {altitude: 3 m}, on: {done: fly}}
  fly: {do: hover, after: {3600 s: land}, on: {HANDLER}}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


def hovering(handler: str = "") -> Rig:
    """A mission that hovers, with these transitions for ``on``."""
    rig = Rig(FLIGHT.replace("HANDLER", handler))
    rig.until_in("fly")
    rig.run(1)
    return rig


def of_kind(rig: Rig, kind: str) -> list[dict[str, Any]]:
    return [fields for each, fields in rig.records if each == kind]


# -- the link -----------------------------------------------------------------------------------


def test_time_goes_on_in_silence() -> None:
    rig = hovering()
    rig.vehicle.silent = True
    before = rig.vehicle.observe()
    rig.session.wait()
    after = rig.vehicle.observe()
    assert after.time == pytest.approx(before.time + PERIOD)
    assert after.link_age == pytest.approx(PERIOD)
    assert (after.position, after.mode) == (before.position, before.mode)


def test_in_ten_minutes_of_silence_a_landing_is_ordered_and_ordered_again() -> None:
    rig = hovering()
    rig.vehicle.silent, since = True, rig.vehicle.observe().time
    rig.until(lambda: "land" in rig.vehicle.verbs, 5)
    assert rig.vehicle.observe().time - since <= 5.0
    with pytest.raises(VehicleError) as raised:
        rig.run(SILENCE_TIMEOUT + 20)
    assert raised.value.code == "cannot-land"
    assert rig.vehicle.observe().time - since > 600
    asked = rig.vehicle.verbs.count("land")
    assert asked == pytest.approx(SILENCE_TIMEOUT / ANSWER_WITHIN, rel=0.05)
    assert (rig.pilot.outcome, rig.pilot.reason) == ("failed", "nothing handled link.lost")
    assert [fields["link"] for fields in of_kind(rig, "link")] == ["old", "lost"]


def test_a_link_that_comes_back_in_time_lands_it() -> None:
    rig = hovering()
    rig.vehicle.silent = True
    rig.run(60)
    rig.vehicle.silent, rig.vehicle.link_age = False, 0.0
    rig.run(60)
    assert rig.pilot.finished and rig.pilot.outcome == "failed"
    assert rig.vehicle.position.z == 0


def test_a_mission_may_go_on_after_a_silence() -> None:
    rig = hovering("link.lost: {actions: {log: lost}}, link.restored: land")
    rig.vehicle.silent = True
    rig.run(10)
    assert rig.pilot.instance.is_active("fly")
    rig.vehicle.silent, rig.vehicle.link_age = False, 0.0
    rig.run(20)
    assert rig.pilot.outcome == "done"


def test_a_link_that_is_gone_ends_the_flight_once_a_landing_was_ordered() -> None:
    rig = hovering("link.lost: {actions: {log: lost}}")
    rig.vehicle.gone = True
    with pytest.raises(VehicleError) as raised:
        rig.run(10)
    assert raised.value.code == "link-gone"
    assert rig.vehicle.verbs[-1] == "land"
    assert rig.pilot.landing is not None and rig.pilot.landing.state == "lost"
    assert (rig.pilot.outcome, rig.pilot.reason) == ("failed", "the link to the vehicle is gone")
    assert [fields["text"] for fields in of_kind(rig, "log")] == ["lost"]


def test_a_link_that_is_gone_waits_for_no_landing_under_way() -> None:
    rig = hovering()
    rig.pilot.land_now()
    rig.run(0.5)
    assert rig.pilot.landing is not None and rig.pilot.landing.state == "accepted"
    rig.vehicle.gone = True
    with pytest.raises(VehicleError, match="link"):
        rig.period()


def test_a_link_that_is_lost_for_long_and_comes_back_lands_it() -> None:
    rig = hovering()
    rig.vehicle.silent = True
    rig.run(LANDING_TIMEOUT + 100)
    rig.vehicle.silent, rig.vehicle.link_age = False, 0.0
    rig.run(60)
    assert rig.pilot.finished and rig.vehicle.position.z == 0


GROUND = """
mission: ground
states:
  wait: {after: {1 s: takeoff}}
  takeoff: {do: takeoff, with: {altitude: 3 m}, on: {done: land}}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


@pytest.mark.parametrize(("how", "code"), [("gone", "link-gone"), ("silent", "cannot-land")])
def test_a_vehicle_not_heard_any_more_is_not_known_to_stand(how: str, code: str) -> None:
    rig = Rig(GROUND)
    # The take-off is given, and whether it is heard nobody knows.
    rig.until_in("takeoff")
    setattr(rig.vehicle, how, True)
    with pytest.raises(VehicleError) as raised:
        rig.run(SILENCE_TIMEOUT + 20)
    assert raised.value.code == code
    assert not rig.vehicle.observe().flying and rig.vehicle.verbs[-1] == "land"


def test_a_takeoff_that_was_just_given_is_not_left_to_itself() -> None:
    rig = Rig(GROUND)
    rig.until_in("takeoff")
    assert rig.vehicle.verbs == ["takeoff"]
    rig.pilot.land_now()
    assert not rig.pilot.finished and rig.vehicle.verbs == ["takeoff", "land"]
    rig.run(10)
    assert rig.pilot.finished and rig.vehicle.position.z == 0


def test_a_vehicle_that_is_not_heard_is_an_error_with_what_to_try() -> None:
    session = FakeSession(options=Options(address="udpin:127.0.0.1:14540", connect_timeout=7.0))
    session.vehicles["drone"].silent = True
    with pytest.raises(VehicleError) as raised:
        session.wait()
    assert raised.value.code == "not-heard" and raised.value.exit_code == 3
    assert "udpin:127.0.0.1:14540" in str(raised.value) and "7 s" in str(raised.value)
    assert raised.value.faults[0].hint


def test_an_order_that_is_not_heard_is_lost() -> None:
    rig = hovering()
    rig.vehicle.silent = True
    order = rig.vehicle.disarm()
    for _ in range(round(ANSWER_WITHIN / PERIOD)):
        rig.session.wait()
        assert order.state == "sent"
    rig.session.wait()
    assert (order.state, order.reason) == ("lost", "no answer within 3 s")


def test_an_order_that_is_never_done_is_lost() -> None:
    rig = hovering()
    rig.vehicle.stuck = True
    order = rig.vehicle.land()
    for _ in range(round(LANDING_TIMEOUT / PERIOD) + 1):
        rig.session.wait()
    assert (order.state, order.reason) == ("lost", "not done within 300 s")


# -- authority ----------------------------------------------------------------------------------


def take_over(rig: Rig) -> None:
    rig.vehicle.authority, rig.vehicle.authority_reason = "operator", "mode POSCTL"
    rig.vehicle.tell("operator.takeover")


def test_a_person_takes_over_and_gives_back() -> None:
    rig = hovering()
    take_over(rig)
    rig.run(1)
    assert rig.pilot.instance.suspended_at is not None
    assert rig.vehicle.command(Velocity(x=1.0)).reason == "mode POSCTL"
    rig.vehicle.authority = "mission"
    rig.vehicle.tell("operator.release")
    rig.run(1)
    assert rig.pilot.instance.suspended_at is None and rig.pilot.instance.is_active("fly")
    assert [fields["authority"] for fields in of_kind(rig, "authority")] == ["operator", "mission"]
    assert of_kind(rig, "authority")[0]["reason"] == "mode POSCTL"


def test_a_person_who_flies_is_not_landed_when_the_mission_ends() -> None:
    rig = hovering("operator.takeover: finish")
    take_over(rig)
    rig.run(30)
    assert rig.pilot.outcome == "done" and not rig.pilot.finished
    assert "land" not in rig.vehicle.verbs
    rig.vehicle.authority = "mission"
    rig.run(30)
    assert rig.pilot.finished and rig.vehicle.verbs[-1] == "land"


def test_a_refused_set_point_is_told_once_with_its_reason() -> None:
    rig = hovering("operator.takeover: {actions: {log: taken}}")
    take_over(rig)
    rig.run(2)
    assert of_kind(rig, "refused") == [{"setpoint": "Position", "reason": "mode POSCTL"}]
    assert rig.pilot.instance.is_active("fly")


@pytest.mark.parametrize(
    ("event", "fields"),
    [
        ("position.lost", {}),
        ("geofence.breach", {}),
        ("operator.land", {}),
        ("autopilot.failsafe", {"reason": "low battery"}),
    ],
)
def test_what_a_backend_posts_is_urgent_and_lands_unless_handled(
    event: str, fields: dict[str, Any]
) -> None:
    rig = hovering()
    rig.vehicle.tell(event, **fields)
    rig.run(30)
    assert rig.pilot.finished and rig.vehicle.position.z == 0
    assert rig.pilot.reason.startswith(f"nothing handled {event}")
    handled = hovering(f"{event}: {{actions: {{log: heard}}}}")
    handled.vehicle.tell(event, **fields)
    handled.run(2)
    assert [fields["text"] for fields in of_kind(handled, "log")] == ["heard"]
    assert handled.pilot.instance.is_active("fly")


def test_every_event_stands_in_the_guide_with_who_makes_it() -> None:
    guide = (Path(__file__).parents[2] / "docs" / "backends.md").read_text("utf-8")
    families = "|".join({name.partition(".")[0] for name in EVENTS})
    section = guide.partition("**Who commands.**")[2].partition("**Set-points.**")[0]
    assert set(re.findall(rf"`((?:{families})\.[a-z]+)`", section)) == set(EVENTS)


def test_good_news_needs_no_handler() -> None:
    rig = hovering("position.restored: {actions: {log: found}}")
    rig.vehicle.tell("position.restored")
    rig.run(1)
    assert [fields["text"] for fields in of_kind(rig, "log")] == ["found"]
    quiet = hovering()
    quiet.vehicle.tell("position.restored")
    quiet.run(1)
    assert quiet.pilot.outcome is None


def test_a_failsafe_of_the_autopilot_is_not_disturbed() -> None:
    rig = hovering()
    rig.vehicle.authority, rig.vehicle.authority_reason = "autopilot", "RTL"
    rig.vehicle.tell("autopilot.failsafe", reason="radio lost")
    rig.run(60)
    assert rig.pilot.outcome == "failed" and "land" not in rig.vehicle.verbs
    assert rig.pilot.reason == "nothing handled autopilot.failsafe: radio lost"


@pytest.mark.parametrize("whose", ["operator", "autopilot"])
def test_a_link_that_is_gone_ends_the_flight_whoever_flies(whose: Any) -> None:
    rig = hovering()
    rig.vehicle.authority = whose
    rig.period()
    rig.vehicle.gone = True
    with pytest.raises(VehicleError) as raised:
        rig.run(10)
    assert raised.value.code == "link-gone" and rig.vehicle.verbs[-1] == "land"


@pytest.mark.parametrize("whose", ["operator", "autopilot"])
def test_a_silence_while_somebody_else_flies_ends_too(whose: Any) -> None:
    rig = hovering()
    rig.vehicle.authority = whose
    rig.period()
    rig.vehicle.silent = True
    rig.run(SILENCE_TIMEOUT - 10)
    assert "land" not in rig.vehicle.verbs
    with pytest.raises(VehicleError) as raised:
        rig.run(20)
    assert raised.value.code == "cannot-land" and rig.vehicle.verbs[-1] == "land"


def test_who_takes_over_during_the_landing_is_left_alone_until_he_gives_back() -> None:
    rig = hovering()
    rig.pilot.land_now()
    rig.run(0.5)
    take_over(rig)
    rig.vehicle.orders.end("mode POSCTL")
    rig.vehicle.fly(Hold())
    rig.run(20)
    assert rig.vehicle.verbs.count("land") == 1
    rig.vehicle.authority = "mission"
    rig.run(20)
    assert rig.pilot.finished and rig.vehicle.verbs.count("land") == 2


# -- late periods, jumps ------------------------------------------------------------------------


def test_a_late_period_is_an_event_and_a_line_of_the_log() -> None:
    rig = hovering("vehicle.late: {actions: {log: $event.step}}")
    steps = []
    rig.session.late = 0.5
    rig.period()
    steps.append(rig.pilot.channel.dt)
    rig.run(0.2)
    steps.append(rig.pilot.channel.dt)
    assert steps == pytest.approx([0.525, PERIOD])
    assert [fields["step"] for fields in of_kind(rig, "late")] == pytest.approx([0.525])
    assert [float(fields["text"]) for fields in of_kind(rig, "log")] == pytest.approx([0.525])


def test_a_jump_of_the_world_s_origin_moves_nothing() -> None:
    rig = Rig(FLIGHT.replace("do: hover", "do: hover, with: {at: [2, 1, 3]}").replace(
        "HANDLER", ""
    ))  # fmt: skip
    rig.until_in("fly")
    rig.run(10)
    rig.vehicle.jump(Point(5.0, -3.0, 0.5))
    rig.run(2)
    assert distance(rig.vehicle.position, (7, -2, 3.5)) < 1e-6
    assert distance(rig.pilot.channel.observation.position, (2, 1, 3)) < 1e-6
    assert of_kind(rig, "jump") == [{"epoch": 1, "offset": [5.0, -3.0, 0.5]}]


@pytest.mark.parametrize(
    ("do", "end"),
    [
        ("{do: goto, with: {to: [6, 2, 3]}, on: {done: land, blocked: finish}}", (6, 2)),
        ("{do: goto, with: {to: {x: 6, y: 2, frame: world}}, on: {done: land, blocked: finish}}",
         (6, 2)),
        ("{do: goto, live: {to: gate}, on: {done: land, blocked: finish}}", (5, -1)),
        ("{do: route, with: {points: [[3, 0], {left: 2 m}, gate], speed: 1 m/s},"
         " on: {done: land, blocked: finish}}", (5, -1)),
    ],
)  # fmt: skip
def test_jumps_lead_no_flight_astray(do: str, end: tuple[float, float]) -> None:
    text = FLIGHT.replace("{do: hover, after: {3600 s: land}, on: {HANDLER}}", do)
    rig = Rig(text, places={"gate": Point(5.0, -1.0, 3.0)})
    rig.until_in("fly")
    jumped = Point(0.0, 0.0, 0.0)
    for shift in (Point(50.0, -30.0, 2.0), Point(-7.0, 0.0, -1.0), Point(0.1, 0.2, 0.3)):
        rig.run(1)
        rig.vehicle.jump(shift)
        jumped = jumped.plus(shift)
    rig.until_in("land")
    assert distance(rig.vehicle.position, jumped.plus((*end, 3.0))) < 0.5
    assert [fields["epoch"] for fields in of_kind(rig, "jump")] == [1, 2, 3]


def test_the_ceiling_stays_where_it_is_when_the_origin_jumps() -> None:
    rig = hovering()
    rig.pilot.channel.configure(Limits(max_altitude=4.0))
    rig.vehicle.jump(Point(0.0, 0.0, 10.0))
    rig.period()
    for _ in range(200):
        rig.vehicle.command(Velocity(z=1.0))
        rig.session.wait()
    rig.period()
    assert rig.pilot.channel.observation.position.z == pytest.approx(4.0)


def test_a_vehicle_that_nobody_commands_holds() -> None:
    rig = hovering()
    rig.vehicle.command(Velocity(x=1.0))
    for _ in range(80):
        rig.session.wait()
    there = rig.vehicle.position
    for _ in range(40):
        rig.session.wait()
    assert rig.vehicle.position == there
    assert rig.vehicle.commands[-1] != Hold()
