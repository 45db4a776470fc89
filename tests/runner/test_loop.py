"""The flying loop with several vehicles in the simulator, and where vehicles and links fail."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from behaviors import Pilot
from behaviors.channel import Channel
from cli.plot import draw
from cli.plot.flight import flights_of
from fsm import parse_parameters
from fsm.engine.instance import Record
from hal import Limits, Options, Session
from hal.fake import FakeSession, FakeVehicle
from hal.vehicle import Answer
from runner import (
    Assignment,
    Plan,
    Prepared,
    Recorder,
    Summary,
    fly,
    missions,
    prepare,
    read_run,
)
from runner.call_limit import CallLimit
from runner.run_folder import summary_fields
from tests.hal.test_contract import example_session
from vencejo.errors import Stopped, UserError, VehicleError
from vencejo.geometry import Point

HOP = """\
mission: hop
parameters: {height: 1 m}
states:
  up: {do: takeoff, with: {altitude: $height}, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
WAIT = """\
mission: wait
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: stay}}
  stay: {do: hover, after: {3 s: down}}
  down: {do: land, on: {done: over}}
  over: {type: final, outcome: given_up, output: {seconds: 3}}
"""
LONG = WAIT.replace("{3 s:", "{30 s:")


def prepared(folder: Path, text: str, world: str | None = None) -> Prepared:
    path = folder / f"{text.split()[1]}.yaml"
    path.write_text(text)
    return prepare(missions.find(str(path)), world)


def two(folder: Path, *texts: str) -> Plan:
    """The cat flies the first mission, the mouse the second."""
    cat, mouse = (prepared(folder, text) for text in texts)
    values = parse_parameters(cat.graph, {"height": "1.5 m"} if "height" in texts[0] else {})
    return Plan({"cat": Assignment(cat, values), "mouse": Assignment(mouse)}, seed=5)


class Witness:
    """Remembers who was shown, period by period, and may ask all to stop."""

    def __init__(self, stop_at: float | None = None, times: int = 1) -> None:
        self.shown: list[tuple[float, str, float]] = []
        self.kinds: list[tuple[str, str]] = []
        self.count = 0
        self._stop_at = stop_at
        self._times = times

    def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
        seen = pilot.channel.world
        self.shown.append((seen.time, pilot.vehicle.name, seen.position.z))
        self.kinds += [(pilot.vehicle.name, kind) for kind, _ in records]
        if self._stop_at is not None and seen.time >= self._stop_at:
            self.count = self._times


def test_each_vehicle_flies_its_own_mission_to_its_own_end(tmp_path: Path) -> None:
    plan, witness = two(tmp_path, HOP, WAIT), Witness()
    folder = tmp_path / "run"
    folder.mkdir()
    recorder = Recorder(folder)
    summary = fly(plan, lambda: recorder, [witness])
    recorder.write_summary(summary)
    cat, mouse = summary.vehicles["cat"], summary.vehicles["mouse"]
    assert list(summary.vehicles) == ["cat", "mouse"]
    assert (cat.outcome, cat.output, cat.reason) == ("done", {}, "")
    assert (mouse.outcome, mouse.output, mouse.reason) == ("given_up", {"seconds": 3}, "")
    assert cat.max_altitude == pytest.approx(1.5, abs=0.1)
    assert mouse.max_altitude == pytest.approx(2.0, abs=0.1)
    assert cat.distance == pytest.approx(3.0, abs=0.3)
    assert cat.mission_time + 2 < mouse.mission_time == summary.mission_time
    assert summary.exit_code == 1

    run = read_run(folder)
    assert run.missing == ()
    assert {name: mission.name for name, mission in run.header.missions.items()} == {
        "cat": "hop",
        "mouse": "wait",
    }
    assert run.header.missions["cat"].parameters == {"height": 1.5}
    assert [event.sequence for event in run.events] == list(range(len(run.events)))
    entered = {"cat": ["", "up", "down", "over"], "mouse": ["", "up", "stay", "down", "over"]}
    for name, states in entered.items():
        own = [event for event in run.events if event.vehicle == name]
        assert [event.fields["state"] for event in own if event.kind == "enter"] == states
        assert own[-1].kind == "outcome"
        # In lockstep, a row each period, to the end of its own flight.
        times = [sample.time for sample in run.telemetry[name]]
        assert times == pytest.approx([0.025 * n for n in range(1, len(times) + 1)])
        assert times[-1] == pytest.approx(summary.vehicles[name].mission_time)
        assert [sample.states for sample in run.telemetry[name]][-1] == ()
    apart = run.telemetry["mouse"][0].position.minus(run.telemetry["cat"][0].position)
    assert apart.norm() == pytest.approx(2.0, abs=0.01)
    assert run.summary is not None
    assert summary_fields(run.summary, folder) | {"wall_time_s": 0, "realtime_factor": 0} == (
        summary_fields(summary, folder) | {"wall_time_s": 0, "realtime_factor": 0}
    )
    lanes = {flight.vehicle: flight.lanes for flight in flights_of(run)}
    states = {name: [[bar.state for bar in lane] for lane in own] for name, own in lanes.items()}
    assert states == {"cat": [["up", "down"]], "mouse": [["up", "stay", "down"]]}
    assert draw(folder).read_bytes().startswith(b"\x89PNG")

    shown = [(time, name) for time, name, _ in witness.shown]
    assert shown[:4] == [(0.025, "cat"), (0.025, "mouse"), (0.05, "cat"), (0.05, "mouse")]
    for name in ("cat", "mouse"):
        assert [time for time, who in shown if who == name] == pytest.approx(
            [sample.time for sample in run.telemetry[name]]
        )
        assert [kind for who, kind in witness.kinds if who == name] == [
            event.kind for event in run.events if event.vehicle == name
        ]


def test_all_done_is_a_success_and_equal_runs_give_equal_bytes(tmp_path: Path) -> None:
    plan = two(tmp_path, HOP, HOP)
    for name in "ab":
        (tmp_path / name).mkdir()
        summary = fly(plan, lambda name=name: Recorder(tmp_path / name))  # type: ignore[misc]
        assert summary.exit_code == 0
    for name in ("events.jsonl", "telemetry/cat.csv", "telemetry/mouse.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


@pytest.mark.parametrize(("times", "past_the_mission"), [(1, False), (2, True)])
def test_a_request_to_stop_lands_all(times: int, past_the_mission: bool, tmp_path: Path) -> None:
    plan = two(tmp_path, LONG, LONG)
    asked = Witness(stop_at=2.5, times=times)
    summary = fly(plan, watchers=[asked], stops=asked)
    assert summary.exit_code == 130
    assert [flown.outcome for flown in summary.vehicles.values()] == ["aborted", "aborted"]
    assert summary.mission_time < 10
    for name in ("cat", "mouse"):
        heights = [z for _, who, z in asked.shown if who == name]
        assert max(heights) > 1.5
        assert heights[-1] == pytest.approx(0.0, abs=0.05)
        assert (name, "landing") in asked.kinds
        assert ((name, "reaction") in asked.kinds) != past_the_mission


def test_a_run_that_cannot_be_recorded_any_more_lands_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken, witness = Recorder.take, Witness()

    def full_for_the_mouse(self: Recorder, pilot: Pilot) -> list[Record]:
        if pilot.vehicle.name == "mouse" and pilot.channel.now > 2.5:
            raise UserError("cannot-record", "no room")
        return taken(self, pilot)

    monkeypatch.setattr(Recorder, "take", full_for_the_mouse)
    summary = fly(two(tmp_path, LONG, LONG), lambda: Recorder(tmp_path), [witness])
    assert (summary.unrecorded, summary.exit_code) == ("error: no room [cannot-record]", 4)
    for name in ("cat", "mouse"):
        heights = [(time, z) for time, who, z in witness.shown if who == name]
        assert max(z for _, z in heights) > 1.5
        assert heights[-1][0] < 10 and heights[-1][1] == pytest.approx(0.0, abs=0.05)


def test_one_vehicle_may_have_any_name(tmp_path: Path) -> None:
    plan = Plan({"cat": Assignment(prepared(tmp_path, HOP))})
    summary = fly(plan, lambda: Recorder(tmp_path))
    assert summary.alone.outcome == "done"
    run = read_run(tmp_path)
    assert (list(run.header.missions), list(run.telemetry)) == (["cat"], ["cat"])


def test_a_plan_without_vehicles_or_with_two_worlds_is_refused(tmp_path: Path) -> None:
    yard, empty = (Assignment(prepared(tmp_path, HOP, world)) for world in ("yard", "empty"))
    for assignments in ({}, {"cat": yard, "mouse": empty}):
        with pytest.raises(ValueError, match="at least one vehicle, and all missions in one world"):
            Plan(assignments)


# -- vehicles and links that fail, without physics ----------------------------------------------

Incident = Callable[[FakeSession], None]


class Eventful(FakeSession):
    """Something happens to it once, so many seconds after the start."""

    def __init__(self, options: Options, at: float, incident: Incident) -> None:
        super().__init__((each.name for each in options.vehicles), options=options)
        self._at, self._incident = round(at * 40), incident

    def wait(self) -> float:
        if self.periods == self._at:
            self._incident(self)
        return super().wait()


@pytest.fixture
def happens(monkeypatch: pytest.MonkeyPatch) -> Callable[[float, Incident], list[Eventful]]:
    """Let the next runs fly on fake vehicles to which something happens; the sessions opened."""

    def prepare_for(at: float, incident: Incident) -> list[Eventful]:
        opened: list[Eventful] = []

        def open_it(name: str, options: Options) -> Session:
            opened.append(Eventful(options, at, incident))
            return opened[-1]

        monkeypatch.setattr("runner.loop.open_backend", open_it)
        return opened

    return prepare_for


def breaks(session: FakeSession) -> None:
    raise VehicleError("closed", "the simulator is gone")


def mouse_of(session: FakeSession) -> FakeVehicle:
    return session.vehicles["mouse"]


def test_a_backend_that_fails_in_flight_leaves_a_landing_ordered_and_a_whole_run(
    tmp_path: Path, happens: Callable[[float, Incident], list[Eventful]]
) -> None:
    opened = happens(2.5, breaks)
    recorder, witness = Recorder(tmp_path), Witness()
    summary = fly(two(tmp_path, LONG, LONG), lambda: recorder, [witness])
    recorder.write_summary(summary)
    assert summary.exit_code == 3
    (session,) = opened
    run = read_run(tmp_path)
    assert run.missing == () and run.summary is not None and run.summary.exit_code == 3
    for name, flown in summary.vehicles.items():
        assert session.vehicles[name].verbs == ["takeoff", "land"]
        assert (flown.outcome, flown.reason) == ("failed", "the simulator is gone")
        assert flown.failure == "the simulator is gone"
        kinds = [event.kind for event in run.events if event.vehicle == name]
        assert kinds[-2:] == ["outcome", "landing"]
        assert kinds == [kind for who, kind in witness.kinds if who == name]
        # A row for each period, and none for the one that never came.
        times = [sample.time for sample in run.telemetry[name]]
        assert times == pytest.approx([0.025 * n for n in range(1, 101)])
        assert flown.mission_time == pytest.approx(2.5)


def test_a_backend_that_fails_after_the_mission_s_end_changes_no_outcome(
    tmp_path: Path, happens: Callable[[float, Incident], list[Eventful]]
) -> None:
    text = HOP.replace("{done: down}", "{done: over}").replace(
        "  down: {do: land, on: {done: over}}\n", ""
    )
    happens(1.5, breaks)
    flown = fly(Plan.alone(prepared(tmp_path, text)))
    assert (flown.alone.outcome, flown.alone.failure) == ("done", "the simulator is gone")
    assert flown.exit_code == 3


def test_a_link_that_is_gone_ends_one_flight_and_not_the_other(
    tmp_path: Path, happens: Callable[[float, Incident], list[Eventful]]
) -> None:
    opened = happens(2.5, lambda session: setattr(mouse_of(session), "gone", True))
    recorder = Recorder(tmp_path)
    summary = fly(two(tmp_path, LONG.replace("given_up", "done"), LONG), lambda: recorder)
    recorder.write_summary(summary)
    assert summary.exit_code == 3
    cat, mouse = summary.vehicles["cat"], summary.vehicles["mouse"]
    assert (cat.outcome, cat.failure) == ("done", "") and cat.mission_time > 30
    assert (mouse.outcome, mouse.reason) == ("failed", "nothing handled link.lost")
    assert mouse.failure.startswith("the link to 'mouse' is gone; a landing was ordered")
    assert mouse_of(opened[0]).verbs == ["takeoff", "land"]
    run = read_run(tmp_path)
    assert run.missing == () and run.summary is not None and run.summary.exit_code == 3
    kinds = [event.kind for event in run.events if event.vehicle == "mouse"]
    assert {"link", "outcome", "landing"} <= set(kinds)
    assert run.telemetry["mouse"][-1].time < 7 < run.telemetry["cat"][-1].time


def test_a_vehicle_that_stays_silent_is_asked_to_land_and_leaves_a_summary(
    tmp_path: Path, happens: Callable[[float, Incident], list[Eventful]]
) -> None:
    opened = happens(2.5, lambda session: setattr(session.vehicles["drone"], "silent", True))
    summary = fly(Plan.alone(prepared(tmp_path, LONG)))
    assert summary.exit_code == 3 and 600 < summary.mission_time < 620
    assert summary.alone.failure == "the vehicle did not land within 600 s"
    assert opened[0].vehicles["drone"].verbs.count("land") > 100


def test_a_jump_of_the_origin_is_no_distance(
    tmp_path: Path, happens: Callable[[float, Incident], list[Eventful]]
) -> None:
    happens(2.5, lambda session: session.vehicles["drone"].jump(Point(30.0, -40.0, 7.0)))
    flown = fly(Plan.alone(prepared(tmp_path, WAIT))).alone
    assert flown.outcome == "given_up"
    assert flown.distance == pytest.approx(4.0, abs=0.5)
    assert flown.max_altitude == pytest.approx(2.0)


def test_a_vehicle_without_limits_flies_until_some_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("runner.loop.open_backend", lambda name, options: example_session(options))
    plan = Plan.alone(prepared(tmp_path, HOP))
    assert fly(plan).exit_code == 0
    with pytest.raises(UserError, match="no limits to change"):
        fly(replace(plan, limits=Limits(max_speed=1.0)))


OWN = """\
mission: own
uses: [own.py]
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: fly}}
  fly: {do: own, exit: {log: "left"}, on: {done: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
OWN_CODE = """\
from behaviors import Behavior

class Own(Behavior):
    def step(self, flight):
        return "done"
"""


def own(folder: Path, **methods: Callable[..., object]) -> Prepared:
    """A mission with a behaviour of its own, whose methods are these."""
    (folder / "own.py").write_text(OWN_CODE)
    mission = prepared(folder, OWN)
    for name, method in methods.items():
        setattr(mission.graph.vocabulary.behaviors["own"].implementation, name, method)
    return mission


def test_all_are_landed_from_within_a_call_that_does_not_return(tmp_path: Path) -> None:
    limit = CallLimit(None)
    landed: list[Summary] = []
    called: list[str] = []

    def step(self: object, flight: object) -> None:
        called.append("step")
        assert limit.land is not None
        landed.append(limit.land("it never returns"))
        raise Stopped  # stands for the end of the process

    def stop(self: object, flight: object) -> None:
        called.append("stop")

    (tmp_path / "run").mkdir()
    cat = Assignment(own(tmp_path, step=step, stop=stop))
    plan = Plan({"mouse": Assignment(prepared(tmp_path, LONG)), "cat": cat})
    with pytest.raises(Stopped):
        fly(plan, lambda: Recorder(tmp_path / "run"), limit=limit)
    assert called == ["step"] and limit.land is None
    (summary,) = landed
    assert {(f.outcome, f.reason, f.failure) for f in summary.vehicles.values()} == {
        ("failed", "it never returns", "")
    }
    run = read_run(tmp_path / "run")
    assert run.missing == ("summary.json is not there",)
    for vehicle in ("cat", "mouse"):
        last = run.telemetry[vehicle][-1]
        assert last.mode == "landed" and abs(last.position.z) < 0.05 and last.states == ()
        kinds = [entry.kind for entry in run.events if entry.vehicle == vehicle]
        assert kinds[-2:] == ["outcome", "landing"] and "log" not in kinds


def test_a_defect_in_a_period_is_shown_and_only_that_vehicle_lands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    send = Channel.send

    def broken(channel: Channel) -> Answer:
        if channel.vehicle.name == "cat" and channel.now > 3.0:
            raise ZeroDivisionError("by zero")
        return send(channel)

    monkeypatch.setattr(Channel, "send", broken)
    cat, mouse = fly(two(tmp_path, LONG.replace("long", "far"), WAIT)).vehicles.values()
    assert (cat.outcome, mouse.outcome) == ("failed", "given_up")
    assert cat.reason == "a defect of the program: ZeroDivisionError: by zero"
    assert cat.mission_time < 10.0
    assert capsys.readouterr().err.count("Traceback") == 1
