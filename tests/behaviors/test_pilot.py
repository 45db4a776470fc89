"""The pilot: who is in command, and what happens when nobody is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from behaviors import Behavior, BehaviorParams, Outcome, describe, live, param
from behaviors.pilot import HOLD_BEFORE_LANDING, LANDING_TIMEOUT
from hal.fake import FakeSession
from hal.vehicle import Hold, Position, Velocity
from tests.behaviors.flying import Rig
from vencejo.errors import UserError, VehicleError, Where
from vencejo.geometry import Point, distance

SHELL = """
mission: test
states:
  takeoff: {{do: takeoff, with: {{altitude: 3 m}}, on: {{done: fly}}}}
  fly: {fly}
  idle: {{after: {{3 s: land}}}}
  land: {{do: land, on: {{done: finish}}}}
  finish: {{type: final}}
"""


def mission(fly: str) -> str:
    """A mission whose state ``fly`` is the one that matters."""
    return SHELL.format(fly=fly)


# -- who is in command --------------------------------------------------------------------------


def test_after_a_takeoff_the_vehicle_holds_by_itself() -> None:
    rig = Rig(mission("{after: {2 s: land}}"))
    rig.until_in("fly")
    rig.run(1)
    assert rig.vehicle.commands == []
    assert rig.vehicle.position == pytest.approx((0, 0, 3))


def test_a_takeoff_whose_state_is_left_ends_where_it_is() -> None:
    rig = Rig(mission("{do: goto, with: {to: home}, on: {done: land, blocked: land}}").replace(
        "{done: fly}", "{done: fly}, when: {vehicle.altitude > 1 m: idle}"
    ))  # fmt: skip
    rig.until_in("idle")
    rig.run(2)
    assert rig.last == Hold()
    assert 1.0 < rig.vehicle.position.z < 1.2


def test_a_landing_whose_state_is_left_ends_where_it_is() -> None:
    rig = Rig(mission("{do: land, on: {done: finish}, when: {vehicle.altitude < 2 m: idle}}"))
    rig.until_in("idle")
    rig.run(2)
    assert rig.last == Hold()
    assert 1.8 < rig.vehicle.position.z < 2.0


def test_a_goto_s_target_is_held_after_it() -> None:
    to = Point(2.0, 0.0, 3.0)
    rig = Rig(
        mission(
            "{do: goto, with: {to: [2, 0, 3], heading: 90 deg}, on: {done: idle, blocked: land}}"
        )
    )
    rig.until_in("idle")
    for _ in range(80):
        assert isinstance(rig.last, Position)
        assert (rig.last.xyz, rig.last.velocity) == (to, None)
        assert rig.last.yaw == pytest.approx(1.5708, abs=1e-4)
        rig.period()
    assert rig.vehicle.position == pytest.approx(to)


def test_a_goto_that_is_left_on_the_way_is_stopped() -> None:
    rig = Rig(
        mission(
            "{do: goto, with: {to: [20, 0]}, after: {4 s: idle}, on: {done: land, blocked: land}}"
        )
    )
    rig.until_in("idle")
    place = rig.vehicle.position
    rig.run(2)
    assert rig.last == Hold()
    assert distance(rig.vehicle.position, place) < 0.06


def test_no_velocity_stays_latched_when_its_state_is_left() -> None:
    rig = Rig(mission("{do: move, with: {forward: 2 m/s, yaw_rate: 20 deg/s}, after: {2 s: idle}}"))
    rig.until_in("idle")
    place = rig.vehicle.position
    assert rig.last == Hold()
    rig.run(2)
    assert rig.vehicle.position == pytest.approx(place)


class Silent(Behavior):
    """Is in command and says nothing."""

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]

    def step(self, flight: Any) -> None:
        return None


class Once(Behavior):
    """Commands a velocity once and never again."""

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]

    def start(self, flight: Any, progress: Any = None) -> None:
        flight.command(Velocity(x=1.0))

    def step(self, flight: Any) -> None:
        return None


class Faraway(Behavior):
    """Commands a far place, to be at rest in."""

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]

    def step(self, flight: Any) -> None:
        flight.command(Position(Point(500.0, 0.0, 3.0)))


class Broken(Behavior):
    """Raises in its tenth step."""

    class Params(BehaviorParams):
        """When."""

        where: str = param("step", choices=("step", "start", "stop", "word", "event"))

    events: Mapping[str, type | None] = {"known.event": None}  # type: ignore[misc]

    def start(self, flight: Any, progress: Any = None) -> None:
        self.left = 10
        if self.params.where == "start":
            raise ValueError("no such thing")

    def step(self, flight: Any) -> Outcome | str | None:
        flight.command(Velocity(x=2.0))
        self.left -= 1
        if self.left:
            return None
        if self.params.where == "word":
            return "finished"
        if self.params.where == "event":
            flight.raise_event("unknown.event")
        if self.params.where == "stop":
            return "done"
        raise ZeroDivisionError("sooner or later")

    def stop(self, flight: Any) -> None:
        if self.params.where == "stop":
            raise RuntimeError("will not stop")


class Seek(Behavior):
    """Needs a point, and publishes what it has."""

    class Params(BehaviorParams):
        """The place to seek."""

        to: Point = live()

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]

    def step(self, flight: Any) -> None:
        flight.command(Position(self.params.to))


OWN = {info.name: info for info in map(describe, (Silent, Once, Faraway, Broken, Seek))}


def test_one_who_says_nothing_holds_and_does_not_fly_on_with_what_was_before() -> None:
    text = mission("{do: move, with: {forward: 2 m/s}, after: {2 s: idle}}")
    rig = Rig(text.replace("idle: {after", "idle: {do: silent, after"), own=OWN)
    rig.until_in("idle")
    place = rig.vehicle.position
    rig.run(2)
    assert rig.last == Hold()
    assert rig.vehicle.position == pytest.approx(place)


def test_a_command_is_for_one_period() -> None:
    rig = Rig(mission("{do: once, after: {3 s: idle}}"), own=OWN)
    rig.until_in("fly")
    assert rig.last == Velocity(x=1.0)
    rig.run(1)
    assert rig.last == Hold()
    assert rig.vehicle.position.x == pytest.approx(0.025)


def test_a_far_place_is_not_flown_to_without_its_behaviour() -> None:
    rig = Rig(mission("{do: faraway, after: {2 s: idle}}"), own=OWN)
    rig.until_in("idle")
    rig.run(1)
    assert rig.last == Hold()


# -- how a mission ends -------------------------------------------------------------------------


def test_it_ends_done_on_the_ground_with_the_motors_off() -> None:
    rig = Rig(mission("{after: {1 s: land}}"))
    rig.run(30)
    assert (rig.pilot.outcome, rig.pilot.reason, rig.pilot.finished) == ("done", "", True)
    assert not rig.vehicle.observe().armed
    assert rig.pilot.landing is None


def test_a_mission_that_ends_in_the_air_holds_and_is_landed() -> None:
    rig = Rig(mission("{do: move, with: {forward: 2 m/s}, after: {2 s: finish}}").replace(
        "  idle: {after: {3 s: land}}\n  land: {do: land, on: {done: finish}}\n", ""
    ))  # fmt: skip
    rig.until(lambda: rig.pilot.outcome is not None)
    place, ended = rig.vehicle.position, rig.vehicle.observe().time
    assert rig.last == Hold()
    rig.until(lambda: rig.pilot.landing is not None)
    assert rig.vehicle.observe().time - ended == pytest.approx(HOLD_BEFORE_LANDING, abs=0.06)
    rig.run(30)
    assert rig.pilot.finished and rig.pilot.outcome == "done"
    assert rig.vehicle.position == pytest.approx((place.x, 0, 0), abs=0.06)
    assert "land" in rig.vehicle.verbs


def test_an_unhandled_failure_lands() -> None:
    rig = Rig(mission("{do: broken, on: {done: land}}"), own=OWN)
    rig.run(30)
    assert rig.pilot.outcome == "failed"
    assert rig.pilot.reason.startswith("nothing handled failed: ZeroDivisionError: sooner or later")
    assert rig.vehicle.position.z == 0 and rig.pilot.finished
    assert ("reaction", {"event": "failed", "does": "land"}) in rig.records


def test_a_refused_landing_is_asked_for_again_and_again() -> None:
    rig = Rig(mission("{after: {1 s: land}}"))
    rig.until_in("fly")
    rig.vehicle.refuse_next = "not now"
    rig.pilot.land_now()
    rig.period()
    assert rig.pilot.landing and rig.pilot.landing.state == "refused"
    asked = rig.vehicle.verbs.count("land")
    rig.run(0.9)
    assert rig.vehicle.verbs.count("land") == asked
    rig.run(30)
    assert rig.pilot.finished
    assert rig.vehicle.verbs.count("land") == asked + 1


def test_a_vehicle_that_cannot_be_landed_is_an_error() -> None:
    rig = Rig(mission("{after: {1 s: land}}"))
    rig.until_in("fly")
    rig.vehicle.stuck = True
    rig.pilot.land_now()
    with pytest.raises(VehicleError) as raised:
        rig.run(LANDING_TIMEOUT + 10)
    assert raised.value.code == "cannot-land"


# -- the operator and other urgent events -------------------------------------------------------


def test_an_abort_lands() -> None:
    rig = Rig(mission("{do: move, with: {forward: 1 m/s}, after: {60 s: land}}"))
    rig.until_in("fly")
    rig.run(1)
    rig.pilot.abort()
    rig.run(30)
    assert (rig.pilot.outcome, rig.pilot.reason) == ("aborted", "nothing handled operator.abort")
    assert rig.pilot.finished and rig.vehicle.position.z == 0


def test_a_mission_may_handle_the_abort_itself() -> None:
    rig = Rig(mission("{do: hover, on: {operator.abort: idle}, after: {60 s: land}}"))
    rig.until_in("fly")
    rig.pilot.abort()
    rig.run(30)
    assert rig.pilot.outcome == "done"
    assert "idle" in rig.states


def test_land_now_goes_past_the_mission() -> None:
    rig = Rig(mission("{do: hover, on: {operator.abort: idle}, after: {60 s: land}}"))
    rig.until_in("fly")
    rig.pilot.abort()
    rig.period()
    rig.pilot.land_now()
    assert rig.vehicle.verbs[-1] == "land"
    rig.run(30)
    assert (rig.pilot.outcome, rig.pilot.finished) == ("aborted", True)
    assert rig.pilot.reason == "the operator asked to land"
    # And once more changes nothing.
    verbs = list(rig.vehicle.verbs)
    rig.pilot.land_now()
    assert rig.vehicle.verbs == verbs


def test_land_now_before_it_flies_ends_it() -> None:
    rig = Rig(mission("{after: {1 s: land}}"))
    rig.pilot.land_now()
    assert rig.pilot.finished and rig.vehicle.verbs == []


@pytest.mark.parametrize(
    ("change", "event"),
    [({"battery": 0.1}, "battery.critical"), ({"link_age": 5.0}, "link.lost")],
)
def test_unhandled_urgent_events_land(change: dict[str, float], event: str) -> None:
    rig = Rig(mission("{do: hover, after: {60 s: land}}"))
    rig.until_in("fly")
    for name, value in change.items():
        setattr(rig.vehicle, name, value)
    rig.run(30)
    assert (rig.pilot.outcome, rig.pilot.reason) == ("failed", f"nothing handled {event}")
    assert rig.vehicle.position.z == 0


def test_advice_and_good_news_need_no_handling() -> None:
    rig = Rig(mission("{do: hover, on: {link.lost: idle}, after: {5 s: land}}"))
    rig.vehicle.battery = 0.25
    rig.until_in("fly")
    rig.vehicle.link_age = 9.0
    rig.run(1)
    rig.vehicle.link_age = 0.0
    rig.run(30)
    assert rig.pilot.outcome == "done"
    events = [fields["name"] for kind, fields in rig.records if kind == "event"]
    assert events.count("battery.low") == 1
    assert events.count("link.lost") == events.count("link.restored") == 1


def test_handled_battery_events_are_the_mission_s() -> None:
    rig = Rig(mission("{do: hover, on: {battery.*: idle}, after: {60 s: land}}"))
    rig.until_in("fly")
    rig.vehicle.battery = 0.29
    rig.run(30)
    assert rig.pilot.outcome == "done" and "idle" in rig.states


# -- behaviours that go wrong -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("where", "reason"),
    [
        ("start", "ValueError: no such thing (test_pilot.py:"),
        ("step", "ZeroDivisionError: sooner or later (test_pilot.py:"),
        ("word", "broken ended in 'finished', which it does not declare"),
        ("event", "ValueError: broken declares no event 'unknown.event'"),
    ],
)
def test_what_goes_wrong_in_a_behaviour_is_its_failure(where: str, reason: str) -> None:
    text = mission(f"{{do: broken, with: {{where: {where}}}, on: {{done: land, failed: idle}}}}")
    rig = Rig(text, own=OWN)
    rig.until_in("idle")
    (told,) = [
        fields["fields"]["reason"]
        for kind, fields in rig.records
        if kind == "event" and fields["name"] == "failed"
    ]
    assert told.startswith(reason)
    assert "/" not in told
    rig.run(1)
    assert isinstance(rig.last, Hold | Position)
    rig.run(30)
    assert rig.pilot.outcome == "done"


def test_a_failing_stop_is_an_error_of_the_graph() -> None:
    text = mission("{do: broken, with: {where: stop}, on: {done: idle}}")
    rig = Rig(text, own=OWN)
    rig.run(30)
    assert rig.pilot.outcome == "failed"
    assert "RuntimeError: will not stop" in rig.pilot.reason


def test_a_value_that_is_missing_fails_with_its_name() -> None:
    text = mission("{do: seek, with: {to: $place}, on: {failed: idle}}").replace(
        "states:", "data: {place: {type: point}}\nstates:"
    )
    rig = Rig(text, own=OWN)
    rig.run(10)
    assert "idle" in rig.states
    assert "the parameter 'to' has no value" in str(rig.records)


def test_a_live_value_that_goes_missing_keeps_what_it_was() -> None:
    fly = "{do: seek, live: {to: $place}, on: {failed: idle, error.execution: {}, test.lose: "
    fly += "{actions: {set: {place: $nothing}}}}, after: {9 s: land}}"
    data = "{place: {type: point, default: [0.5, 0, 3]}, nothing: {type: point}}"
    text = mission(fly).replace("states:", f"events: {{test.lose: {{}}}}\ndata: {data}\nstates:")
    rig = Rig(text, own=OWN)
    rig.until_in("fly")
    rig.pilot.instance.post("test.lose")
    rig.run(3)
    assert rig.pilot.instance.is_active("fly")
    assert rig.vehicle.position == pytest.approx((0.5, 0, 3))


def test_a_refused_takeoff_tells_the_mission_why() -> None:
    text = """
mission: grounded
data: {why: ""}
states:
  takeoff:
    do: takeoff
    on:
      done: land
      failed: {target: grounded, actions: {set: {why: $event.reason}}}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
  grounded: {type: final, outcome: grounded, output: {why: $why}}
"""
    rig = Rig(text)
    rig.vehicle.health = ("no position",)
    rig.run(10)
    assert rig.pilot.finished and rig.pilot.outcome == "grounded"
    assert rig.pilot.instance.output == {"why": "takeoff refused: no position"}


def test_what_the_vehicle_cannot_do_is_refused_before_takeoff() -> None:
    text = mission("{do: goto, with: {to: home}, on: {done: land, blocked: land}}")
    with pytest.raises(UserError) as raised:
        Rig(text, strip=("velocity",))
    (fault,) = raised.value.faults
    assert fault.code == "missing-capability"
    assert isinstance(fault.where, Where) and fault.where.line == 5
    assert "'goto' needs 'velocity'" in fault.message
    assert fault.hint and "position" in fault.hint


# -- frames and seeds ---------------------------------------------------------------------------


def test_points_count_from_where_the_mission_began() -> None:
    session = FakeSession()
    session.vehicles["drone"].position = Point(10.0, 5.0, 2.0)
    rig = Rig(
        mission("{do: goto, with: {to: gate}, on: {done: idle, blocked: land}}"),
        session=session,
        places={"gate": Point(12.0, 5.0, 6.0)},
    )
    rig.until_in("idle")
    assert rig.vehicle.position == pytest.approx((12, 5, 6), abs=0.2)
    assert rig.pilot.channel.observation.position == pytest.approx((2, 0, 4), abs=0.2)


def test_the_same_flight_twice_leaves_the_same_records() -> None:
    text = mission("{do: goto, with: {to: [3, 2, 4]}, on: {done: land, blocked: land}}")
    runs = []
    for _ in range(2):
        rig = Rig(text)
        rig.run(60)
        runs.append((rig.records, rig.vehicle.commands))
    assert runs[0] == runs[1]


# -- the operator takes over --------------------------------------------------------------------


def test_a_takeover_suspends_the_mission_until_release() -> None:
    rig = Rig(mission("{do: goto, with: {to: [20, 0, 3]}, on: {done: land, blocked: land}}"))
    rig.until_in("fly")
    rig.run(3)
    rig.pilot.instance.post("operator.takeover")
    rig.run(1)
    assert rig.last == Hold()
    held = rig.vehicle.position
    rig.run(5)
    assert distance(rig.vehicle.position, held) < 1.0
    assert rig.pilot.instance.paths() == ["fly"]
    rig.pilot.instance.post("operator.release")
    rig.until_in("land")
    assert rig.vehicle.position.x == pytest.approx(20, abs=0.5)


def test_an_abort_lands_a_suspended_mission() -> None:
    rig = Rig(mission("{after: {60 s: land}}"))
    rig.until_in("fly")
    rig.pilot.instance.post("operator.takeover")
    rig.run(1)
    rig.pilot.abort()
    rig.run(20)
    assert (rig.pilot.outcome, rig.pilot.finished) == ("aborted", True)


@pytest.mark.parametrize("where", ["shed", "home", {"x": 2.0, "y": 0.0}, Point(2.0, 0.0, 1.5)])
def test_a_parameter_that_is_a_place_can_be_flown_to_and_measured(where: object) -> None:
    text = """
parameters: {where: {type: point, default: home}}
states:
  up: {do: takeoff, with: {altitude: 1.5 m}, on: {done: go}}
  go:
    do: goto
    with: {to: $where}
    when: {"distance(where, vehicle.position) < 1 m": {actions: {log: near}}}
    on: {done: land, blocked: land}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""
    rig = Rig(text, parameters={"where": where}, places={"shed": Point(2.0, 0.0, 1.5)})
    rig.run(60)
    assert rig.pilot.outcome == "done"
    assert [fields["text"] for kind, fields in rig.records if kind == "log"] == ["near"]


@pytest.mark.parametrize(
    "go",
    [
        "goto, with: {to: {x: 3, y: 4, above_ground: 4 m}}",
        "goto, live: {to: {x: 3, y: $vehicle.altitude, above_ground: 4 m}}",
        "route, with: {points: [[1, 2, 3], {at: {x: 3, above_ground: 4 m}, speed: 1 m/s}]}",
        "hover, with: {heading: {face: {x: 3, above_ground: 0}}}",
    ],
)
def test_heights_above_ground_need_a_vehicle_that_knows_it(go: str) -> None:
    text = f"""
mission: high
states:
  go: {{do: {go}, on: {{"*": finish}}}}
  finish: {{type: final}}
"""
    with pytest.raises(UserError) as refused:
        Rig(text)
    (fault,) = refused.value.faults
    assert fault.code == "missing-capability" and "needs 'terrain'" in fault.message
    session = FakeSession()
    session.vehicles["drone"].capabilities |= {"terrain"}
    Rig(text, session=session)
