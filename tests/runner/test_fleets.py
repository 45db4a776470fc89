"""Fleets in the simulator: who flies what from where, messages, their common end, distances."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from itertools import combinations
from math import pi
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from behaviors import Pilot
from fsm.engine.instance import Record
from hal.engines import default_engine
from runner import (
    FleetFlight,
    Plan,
    Recorder,
    fly,
    fly_fleet,
    missions,
    prepare_fleet,
    read_run,
)
from runner.separation import Separation
from tests.runner.test_loop import HOP, WAIT, Witness
from vencejo.errors import UserError
from vencejo.geometry import Point, distance

Write = Callable[..., str]
SENDER = """\
parameters: {wait: 1 s}
states:
  a: {after: {wait: {target: b, actions: {send: {event: game.over, to: mouse, with: FIELDS}}}}}
  b: {type: final}
"""
DATA = "{where: {type: point, default: [0, 0, 0]}}"
HEARER = f"""\
events: {{game.over: {{at: point, who: text}}}}
data: {DATA}
states:
  wait:
    on:
      game.over: {{target: over, actions: {{log: $event.source, set: {{where: $event.at}}}}}}
  over: {{type: final, output: {{where: $where}}}}
"""
PLACE = "{at: [3, 2, 1], who: cat}"


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write a fleet, and its missions beside it; its path."""

    def write_files(fleet: str, **texts: str) -> str:
        for name, text in texts.items():
            (tmp_path / f"{name}.yaml").write_text(text)
        (tmp_path / "fleet.yaml").write_text(fleet)
        return str(tmp_path / "fleet.yaml")

    return write_files


def two(**missions_: str) -> str:
    """A fleet of vehicles that have a mission of their own name."""
    vehicles = "".join(f"  {name}: {{mission: {name}.yaml}}\n" for name in missions_)
    return f"fleet: two\nvehicles:\n{vehicles}"


def log_of(flight: FleetFlight, vehicle: str, *kinds: str) -> list[tuple[float, str, object]]:
    records = flight.vehicles[vehicle].records
    return [(time, kind, fields) for time, kind, fields in records if kind in kinds]


def plan_of(fleet: str, **settings: object) -> Plan:
    prepared = prepare_fleet(missions.find(fleet))
    prepared.require()
    return Plan(prepared.assignments, settings=settings, fleet=prepared.fleet)


# -- who flies what, and from where --------------------------------------------------------------


def test_each_vehicle_has_a_mission_parameters_and_a_start_of_its_own(write: Write) -> None:
    flight = fly_fleet(
        write(
            "fleet: three\n"
            "vehicles:\n"
            "  cat: {mission: hop.yaml, with: {height: 2 m}}\n"
            "  mouse: {mission: hop.yaml, start: {at: [-3, 4], heading: 90 deg}, model: f450}\n"
            "  dog: {mission: hop.yaml, color: [1, 2, 3]}\n",
            hop=HOP,
        ),
        {"mouse.height": "3 m"},
    )
    highest = {name: each.highest for name, each in flight.vehicles.items()}
    assert highest == pytest.approx({"cat": 2, "mouse": 3, "dog": 1}, abs=0.15)
    assert flight.summary.exit_code == 0
    assert flight.summary.header.fleet == "three"
    settings = flight.summary.header.settings
    assert settings is not None
    asked = {n: (each.model, each.start, each.color) for n, each in settings.missions.items()}
    assert asked["cat"] == (None, None, None)
    assert asked["dog"] == (None, None, (1, 2, 3))
    model, start, _ = asked["mouse"]
    assert model == "f450" and start is not None
    assert (start.at, start.heading) == ((-3, 4, 0), pytest.approx(pi / 2))
    apart = {pair.vehicles: pair.distance for pair in flight.summary.separation}
    assert apart["cat", "dog"] == pytest.approx(2.0, abs=0.05)
    assert apart["cat", "mouse"] == pytest.approx(5.0, abs=0.05)


def test_a_vehicle_without_a_mission_stands_until_the_others_are_down(write: Write) -> None:
    flight = fly_fleet(write("fleet: f\nvehicles: {cat: {mission: w.yaml}, lamp: {}}\n", w=WAIT))
    cat, lamp = flight.summary.vehicles["cat"], flight.summary.vehicles["lamp"]
    assert (cat.outcome, lamp.outcome, lamp.left_ground) == ("given_up", "done", False)
    assert cat.mission_time < lamp.mission_time < cat.mission_time + 0.1
    assert flight.vehicles["lamp"].highest == pytest.approx(0.0, abs=0.01)


class Hand:
    """Flies the vehicle `lamp` from outside."""

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        vehicle = pilot.vehicle
        if vehicle.name == "lamp" and vehicle.observe().time < 0.1:
            vehicle.takeoff(1.5)


def test_a_vehicle_without_a_mission_may_be_flown_and_is_landed_in_the_end(write: Write) -> None:
    fleet = write("fleet: f\nvehicles: {cat: {mission: w.yaml}, lamp: {}}\n", w=WAIT)
    flight = fly_fleet(fleet, watchers=[Hand()])
    lamp = flight.vehicles["lamp"]
    assert lamp.highest == pytest.approx(1.5, abs=0.1)
    assert flight.vehicles["cat"].time + 1 < lamp.time
    assert lamp.track[-1][1].z == pytest.approx(0.0, abs=0.01)
    assert flight.summary.vehicles["lamp"].outcome == "done"


def test_vehicles_touch_each_other(write: Write) -> None:
    stays = WAIT.replace("3 s", "9 s")
    comes = stays.replace("do: hover,", 'do: goto, with: {to: [2, 0, 2]}, on: {"*": down},')
    flight = fly_fleet(write(two(cat="", dog=""), cat=comes, dog=stays))
    assert flight.summary.vehicles["cat"].collisions["dog"] >= 1
    assert flight.summary.vehicles["dog"].collisions["cat"] >= 1
    assert flight.nearest.vehicles == ("cat", "dog") and flight.nearest.distance < 0.6


# -- messages ------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [("cat", "mouse"), ("mouse", "cat")])
def test_what_is_sent_arrives_in_the_next_period(write: Write, order: tuple[str, str]) -> None:
    texts = {"cat": SENDER.replace("FIELDS", PLACE), "mouse": HEARER}
    flight = fly_fleet(write(two(**dict.fromkeys(order, "")), **texts))
    ((sent, _, _),) = log_of(flight, "cat", "send")
    ((heard, _, event),) = log_of(flight, "mouse", "event")
    assert heard == pytest.approx(sent + 0.025)
    home = {name: 2.0 * order.index(name) for name in order}
    at = Point(3 + home["cat"] - home["mouse"], 2, 1)
    assert isinstance(event, dict) and event["taken"]
    assert event["fields"] == {"at": at, "who": "cat", "source": "cat"}
    assert flight.vehicles["mouse"].output == {"where": at}
    assert [fields for _, _, fields in log_of(flight, "mouse", "log")] == [{"text": "cat"}]


HOME = Point(-2, 0, 0)
"""That of the cat, for the mouse."""


@pytest.mark.parametrize(
    ("type_", "sent", "heard"),
    [
        ("point", "[3, 2]", Point(1, 2, 0)),
        ("point", "home", HOME),
        ("point", "{forward: 1, left: 2}", Point(-1, 2, 0)),
        ("point", "$vehicle.position", HOME),
        ("any", "$vehicle.position", HOME),
        ("list", "[[1, 2], $vehicle.position]", [[1, 2], HOME]),
        ("area", "[[0, 0], [4, 4]]", [HOME, Point(2, 4, 0)]),
        ("[point]", "[[0, 0], [4, 4]]", [HOME, Point(2, 4, 0)]),
        ("[[point]]", "[[[0, 0]], [[4, 4]]]", [[HOME], [Point(2, 4, 0)]]),
        ("[number]", "[1, 2]", [1, 2]),
        ("map", "{here: $vehicle.position, count: 3}", {"here": HOME, "count": 3}),
        ("route", "[[1, 1], {at: [2, 2], dwell: 3}]", [[-1, 1, 0], {"at": [0, 2, 0], "dwell": 3}]),
        ("heading", "travel", "travel"),
        ("text", "home", "home"),
        ("length", "3 m", 3.0),
    ],
)  # fmt: skip
def test_a_place_is_the_same_place_on_arrival(
    write: Write, type_: str, sent: str, heard: object
) -> None:
    hearer = HEARER.replace("at: point", f"at: {type_}").replace(DATA, "{where: null}")
    texts = {"cat": SENDER.replace("FIELDS", f"{{at: {sent}, who: x}}"), "mouse": hearer}
    flight = fly_fleet(write(two(**texts), **texts))
    assert rounded(flight.vehicles["mouse"].output["where"]) == rounded(heard)


def rounded(value: Any) -> Any:
    """A value with its numbers rounded to millimetres: a vehicle does not quite stand at 0."""
    if isinstance(value, (list, tuple)):
        return [rounded(each) for each in value]
    if isinstance(value, dict):
        return {name: rounded(each) for name, each in value.items()}
    return round(value, 2) + 0.0 if isinstance(value, float | int) else value


def test_what_nobody_hears_any_more_is_undelivered(write: Write) -> None:
    texts = {
        "cat": SENDER.replace("FIELDS", PLACE).replace("1 s", "2 s"),
        "mouse": HEARER.replace("wait:", "wait:\n    after: {1 s: over}"),
    }
    flight = fly_fleet(write(two(**texts), **texts))
    assert [fields for _, _, fields in log_of(flight, "cat", "undelivered")] == [
        {"event": "game.over", "to": "mouse"}
    ]
    assert log_of(flight, "mouse", "event") == []


def test_an_event_of_one_s_own_has_no_source(write: Write) -> None:
    raised = "entry: {raise: {game.over: {at: [1, 2, 3], who: me}}}"
    mouse = HEARER.replace("wait:", f"wait:\n    {raised}")
    texts = {"cat": SENDER.replace("FIELDS", PLACE), "mouse": mouse}
    flight = fly_fleet(write(two(**texts), **texts))
    assert [fields for _, _, fields in log_of(flight, "mouse", "log")] == [{"text": ""}]


def test_an_event_from_outside_may_be_for_one(write: Write) -> None:
    text = WAIT.replace("stay: {", "stay: {on: {battery.low: down}, ")
    fleet = write(two(cat="", mouse=""), cat=text, mouse=text)
    one = fly_fleet(fleet, post=["3s:mouse:battery.low"])
    assert one.vehicles["mouse"].time + 1 < one.vehicles["cat"].time
    both = fly_fleet(fleet, post=["3s:battery.low"])
    assert both.vehicles["mouse"].time == one.vehicles["mouse"].time
    assert both.vehicles["cat"].time == pytest.approx(both.vehicles["mouse"].time, abs=0.1)


# -- the end of all ------------------------------------------------------------------------------


def both_until(condition: str, more: str = "") -> str:
    """A fleet of two that fly the same mission, until something is so."""
    return f"{two(a='', b='').replace('b.yaml', 'a.yaml')}{more}until: {condition}\n"


def test_until_lands_all_and_is_a_success(write: Write) -> None:
    flight = fly_fleet(write(both_until("time > 3 s", "  c: {}\n"), a=WAIT))
    assert flight.summary.exit_code == 0 and flight.summary.ended_by_until
    for name in "abc":
        flown = flight.summary.vehicles[name]
        assert (flown.outcome, flown.reason) == ("done", "until time > 3 s")
        ((ended, _, _),) = log_of(flight, name, "outcome")
        assert ended == pytest.approx(3.025)
        assert flight.vehicles[name].end.z == pytest.approx(0.0, abs=0.01)
    assert flight.summary.vehicles["a"].left_ground


def test_until_reads_what_the_vehicles_publish_in_one_frame(write: Write) -> None:
    apart = "distance(a.vehicle.position, b.vehicle.position) > 1.9 m"
    flight = fly_fleet(write(both_until(f"{apart} and b.vehicle.altitude > 1.9 m"), a=WAIT))
    assert flight.summary.ended_by_until
    ended = log_of(flight, "a", "outcome")[0][0]
    assert 1.9 < dict(flight.vehicles["b"].track)[ended].z < 2.0


def test_until_that_never_comes_true_ends_nothing(write: Write) -> None:
    flight = fly_fleet(write(both_until("time > 300 s"), a=HOP))
    assert not flight.summary.ended_by_until and flight.summary.exit_code == 0
    assert flight.summary.mission_time < 10


def test_a_condition_without_a_value_is_false_and_told_once(write: Write) -> None:
    flight = fly_fleet(write(both_until("1 / floor(time / 900 s) > 2"), a=HOP))
    assert not flight.summary.ended_by_until and flight.summary.exit_code == 0
    ((time, _, fields),) = log_of(flight, "a", "error")
    assert time == pytest.approx(0.025)
    assert isinstance(fields, dict) and fields["where"].endswith("fleet.yaml:5:8")
    assert log_of(flight, "b", "error") == []


def test_one_that_fails_leaves_the_others_their_missions(write: Write) -> None:
    texts = {
        "cat": WAIT.replace("given_up", "failed").replace("3 s", "1 s"),
        "mouse": WAIT.replace("given_up", "done"),
    }
    flight = fly_fleet(write(two(**texts), **texts))
    cat, mouse = flight.summary.vehicles["cat"], flight.summary.vehicles["mouse"]
    assert (cat.outcome, mouse.outcome) == ("failed", "done")
    assert flight.vehicles["cat"].track[-1][1].z == pytest.approx(0.0, abs=0.01)
    assert flight.vehicles["mouse"].states == ["up", "stay", "down", "over"]
    assert flight.summary.exit_code == 1


def test_asked_to_stop_all_land(write: Write, tmp_path: Path) -> None:
    texts = {"cat": WAIT, "mouse": WAIT}
    fleet = two(**texts).replace("mouse:", "lamp: {}\n  mouse:")
    witness = Witness(stop_at=2.0)
    summary = fly(plan_of(write(fleet, **texts)), None, [witness], stops=witness)
    assert summary.interrupted and summary.exit_code == 130
    assert {n: each.outcome for n, each in summary.vehicles.items()} == dict.fromkeys(
        ["cat", "lamp", "mouse"], "aborted"
    )
    assert witness.shown[-1][2] == pytest.approx(0.0, abs=0.01)
    assert summary.mission_time < 7


RAISES = """\
from behaviors import Behavior


class Breaks(Behavior):
    outcomes = {"done": None}
    controls = ("motion",)

    def step(self, flight):
        if flight.now > 3.0:
            raise ValueError("a screw is loose")
"""


def test_a_defect_in_the_code_of_one_is_its_own(write: Write, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(RAISES)
    broken = "uses: [mine.py]\n" + WAIT.replace("do: hover", "do: breaks, on: {done: down}")
    texts = {"cat": broken.replace("mission: wait\n", ""), "mouse": WAIT}
    flight = fly_fleet(write(two(**texts), **texts))
    cat, mouse = flight.summary.vehicles["cat"], flight.summary.vehicles["mouse"]
    assert cat.outcome == "failed" and "a screw is loose" in cat.reason
    assert flight.vehicles["cat"].end.z == pytest.approx(0.0, abs=0.01)
    assert (mouse.outcome, mouse.reason) == ("given_up", "")


# -- what one more changes, and how near they come ------------------------------------------------


def test_one_more_vehicle_changes_nothing_for_the_others(write: Write, tmp_path: Path) -> None:
    starts = {"cat": "[0, 0]", "mouse": "[0, 30]", "dog": "[30, 0]"}
    rows = {n: f"  {n}: {{mission: w.yaml, start: {{at: {at}}}}}\n" for n, at in starts.items()}
    for names in (("cat", "mouse"), ("dog", "cat", "mouse")):
        fleet = write("fleet: f\nvehicles:\n" + "".join(rows[n] for n in names), w=WAIT)
        folder = tmp_path / str(len(names))
        folder.mkdir()
        recorder = Recorder(folder)
        assert fly(plan_of(fleet, noise=1.0), lambda recorder=recorder: recorder).exit_code == 1  # type: ignore[misc]
    for name in ("cat", "mouse"):
        few, many = ((tmp_path / n / f"telemetry/{name}.csv").read_text() for n in "23")
        if default_engine() == "mujoco":  # its solver works on all contacts of a world together
            few, many = ("\n".join(re.findall(".*,flying,.*", rows)) for rows in (few, many))
        assert few == many and few.count(",flying,") > 80
    run = read_run(tmp_path / "3")
    assert list(run.telemetry) == ["dog", "cat", "mouse"]
    assert run.telemetry["dog"][-1].position != run.telemetry["cat"][-1].position


@given(
    st.lists(
        st.lists(st.tuples(*[st.floats(-50, 50)] * 3, st.booleans()), min_size=4, max_size=4),
        min_size=1,
        max_size=6,
    )
)
def test_the_least_distances_are_those_of_all_periods(
    periods: list[list[tuple[float, float, float, bool]]],
) -> None:
    separation = Separation("abcd")
    expected: dict[tuple[str, str], float] = {}
    for time, vehicles in enumerate(periods):
        places = [Point(x, y, z) for x, y, z, _ in vehicles]
        separation.update(time, places, [aloft for *_, aloft in vehicles])
        for i, j in combinations(range(4), 2):
            if vehicles[i][3] or vehicles[j][3]:
                pair = "abcd"[i], "abcd"[j]
                apart = distance(places[i], places[j])
                expected[pair] = min(apart, expected.get(pair, apart))
    found = {pair.vehicles: pair.distance for pair in separation.nearest()}
    assert found == pytest.approx(expected)
    for (a, b), apart, time in separation.nearest():
        row = periods[int(time)]
        ends = [Point(*row["abcd".index(name)][:3]) for name in (a, b)]
        assert distance(*ends) == pytest.approx(apart)


# -- what is wrong with a fleet ------------------------------------------------------------------


AT_9 = "start: {at: [9, 0]}"
NEAR = f"a: {{mission: h.yaml, {AT_9}}}, b: {{{AT_9.replace('0]', '0.6]')}}}"


@pytest.mark.parametrize(
    ("vehicles", "code", "severity"),
    [
        ("cat: {mission: h.yaml, color: rde}", "unknown-color", "error"),
        ("cat: {mission: h.yaml, start: {at: [0, 0, -1]}}", "start-in-ground", "error"),
        ("cat: {mission: h.yaml, start: {at: [0, 0], headng: 0}}", "unknown-key", "error"),
        ("cat: {mission: h.yaml, start: [0, 0]}", "wrong-type", "error"),
        (NEAR, "starts-overlap", "warning"),
        ("cat: {}", "no-mission", "error"),
        ("cat: {with: {height: 3}}", "missing-key", "error"),
        ("time: {mission: h.yaml}", "name-taken", "error"),
        ("cat: null", "wrong-type", "error"),
    ],
)  # fmt: skip
def test_faults_of_vehicles(write: Write, vehicles: str, code: str, severity: str) -> None:
    prepared = prepare_fleet(missions.find(write(f"fleet: f\nvehicles: {{{vehicles}}}\n", h=HOP)))
    ((found, how),) = {(fault.code, fault.severity) for fault in prepared.faults}
    assert (found, how) == (code, severity)
    assert prepared.may_fly == (severity == "warning")
    if severity == "error":
        with pytest.raises(UserError):
            prepared.require()


def test_a_start_in_a_thing_of_the_world(write: Write) -> None:
    fleet = write(
        "fleet: f\nworld: hut.yaml\nvehicles: {cat: {mission: h.yaml, start: {at: [5, 5]}}}\n",
        h=HOP,
        hut="world: hut\nboxes: {hut: {at: [5, 5], size: [1, 2, 3]}}\n"
        "fence: {through: [[-4, -4], [4, -4], [4, 4], [-4, 4]]}\n",
    )
    codes = [fault.code for fault in prepare_fleet(missions.find(fleet)).faults]
    assert codes == ["start-in-thing", "start-outside-fence"]
