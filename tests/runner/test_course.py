"""The states that a mission entered, and why, told from its records."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fsm import parse_parameters
from runner import Plan, Prepared, Recorder, fly, missions, prepare, read_run
from runner.course import Entered, entered, one_line
from runner.run_folder import LAST_ENTERED, summary_fields
from tests.behaviors.flying import Rig


def course(text: str, seconds: float = 60.0, events: dict[float, str] | None = None) -> list[str]:
    """The states entered in a flight, each with its cause; ``events`` are posted at these times."""
    rig = Rig(text)
    told: list[Entered] = []
    waiting = dict(events or {})
    while not rig.pilot.finished and rig.pilot.channel.now < seconds:
        for time in [time for time in waiting if time <= rig.pilot.channel.now]:
            rig.pilot.instance.post(waiting.pop(time), {})
        before = len(rig.records)
        rig.period()
        told += entered(rig.pilot.instance, rig.records[before:])
    return [f"{each.state} ({each.why})" if each.why else each.state for each in told]


def test_outcomes_events_timers_and_conditions_are_causes() -> None:
    text = """\
mission: causes
events: {operator.mark: {}}
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: wait}}
  wait: {after: {2 s: look}}
  look: {when: {vehicle.altitude > 1 m: listen}}
  listen: {on: {operator.mark: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
    assert course(text, events={8.0: "operator.mark"}) == [
        "up",
        "wait (done)",
        "look (after 2 s)",
        "listen (when vehicle.altitude > 1 m)",
        "down (operator.mark)",
        "over (done)",
    ]


BLOCKED = """\
mission: blocked
world: yard
states:
  up: {do: takeoff, with: {altitude: 1 m}, on: {done: shed}}
  shed:
    do: goto
    with: {to: [6, 2, 1], timeout: 1 s}
    on: {done: home, blocked: choose, vehicle.collision: bump}
  choose:
    always: [{guard: vehicle.altitude > 100 m, target: over}, home]
  bump: {after: {1 s: home}}
  home: {do: land, on: {done: over}}
  over: {type: final}
"""


def test_a_reason_goes_with_its_outcome_also_through_a_choice() -> None:
    assert course(BLOCKED) == [
        "up",
        "shed (done)",
        "home (blocked: not there within 1 s)",
        "over (done)",
    ]


def test_an_outcome_from_inside_names_its_state() -> None:
    text = """\
mission: inside
states:
  up: {do: takeoff, with: {altitude: 1 m}, on: {done: work}}
  work:
    on: {blocked: down}
    states:
      go: {do: goto, with: {to: [50, 0, 1], timeout: 1 s}, on: {done: go}}
  down: {do: land, on: {done: lost}}
  lost: {type: final, outcome: lost}
"""
    assert course(text) == [
        "up",
        "work.go (done)",
        "down (work.go blocked: not there within 1 s)",
        "lost (done)",
    ]


def test_each_region_has_its_own_cause() -> None:
    text = """\
mission: regions
states:
  both:
    type: parallel
    on: {done: over}
    states:
      left: {states: {a: {after: {1 s: b}}, b: {after: {1 s: c}}, c: {type: final}}}
      right: {states: {a: {when: {time > 1.01 s: b}}, b: {after: {1 s: c}}, c: {type: final}}}
  over: {type: final}
"""
    assert course(text) == [
        "both.left.a",
        "both.right.a",
        "both.left.b (after 1 s)",
        "both.right.b (when time > 1.01 s)",
        "over (done)",
    ]


def test_what_is_raised_is_the_cause_and_a_history_state_restores() -> None:
    text = """\
mission: back
events: {lap.over: {}, operator.mark: {}}
states:
  work:
    states:
      one: {after: {1 s: two}}
      two: {on: {operator.mark: {actions: {raise: lap.over}}}, after: {9 s: one}}
      last: {type: history, target: one}
    on: {lap.over: pause}
  pause: {after: {1 s: work.last, 5 s: over}}
  over: {type: final}
"""
    assert course(text, 5.0, events={2.0: "operator.mark"}) == [
        "work.one",
        "work.two (after 1 s)",
        "pause (lap.over)",
        "work.two (after 1 s)",
    ]


def test_reasons_are_one_line() -> None:
    assert one_line("motor 2:\r\n  \x1b[31mhot\x1b[0m\x00") == "motor 2: [31mhot [0m"


# -- in the summary --------------------------------------------------------------------------------


def written(folder: Path, text: str) -> Prepared:
    path = folder / "mission.yaml"
    path.write_text(text)
    return prepare(missions.find(str(path)))


def test_the_summary_tells_the_states_and_the_collisions(tmp_path: Path) -> None:
    prepared = written(tmp_path, BLOCKED)
    folder = tmp_path / "run"
    folder.mkdir()
    recorder = Recorder(folder)
    summary = fly(Plan.alone(prepared, parse_parameters(prepared.graph, {})), lambda: recorder)
    recorder.write_summary(summary)
    fields = json.loads((folder / "summary.json").read_text("utf-8"))
    assert [(each["state"], each["why"]) for each in fields["entered"]] == [
        ("up", None),
        ("shed", "done"),
        ("home", "blocked: not there within 1 s"),
        ("over", "done"),
    ]
    assert [each["t"] for each in fields["entered"]] == sorted(
        line.time
        for line in read_run(folder).events
        if line.kind == "enter" and line.fields["state"] in ("up", "shed", "home", "over")
    )
    assert fields["collisions"] == {}
    again = read_run(folder).summary
    assert again is not None
    assert again.alone.entered == summary.alone.entered
    rounded = {"wall_time_s": 0, "realtime_factor": 0}
    assert summary_fields(again, folder) | rounded == fields | rounded


def test_a_collision_is_counted_and_is_a_cause(tmp_path: Path) -> None:
    prepared = written(tmp_path, BLOCKED.replace("timeout: 1 s", "timeout: 60 s"))
    summary = fly(Plan.alone(prepared)).alone
    assert [(each.state, each.why) for each in summary.entered[2:4]] == [
        ("bump", "vehicle.collision: shed"),
        ("home", "after 1 s"),
    ]
    assert set(summary.collisions) == {"shed"}


def test_a_collision_that_no_state_hears_is_counted_too(tmp_path: Path) -> None:
    text = BLOCKED.replace(", vehicle.collision: bump", "").replace("timeout: 1 s", "timeout: 20 s")
    text = text.replace("  bump: {after: {1 s: home}}\n", "")
    summary = fly(Plan.alone(written(tmp_path, text))).alone
    assert summary.collisions["shed"] >= 1


def test_the_summary_of_a_long_flight_has_the_last_states(tmp_path: Path) -> None:
    text = """\
mission: long
data: {rounds: 0}
states:
  tick: {after: {0.1 s: tock}, entry: {set: {rounds: "${rounds + 1}"}}}
  tock: {after: {0.1 s: tick}, when: {rounds > 30: over}}
  over: {type: final}
"""
    entered = fly(Plan.alone(written(tmp_path, text))).alone.entered
    assert len(entered) == LAST_ENTERED
    assert entered[-1].state == "over"
    assert [each.state for each in entered[-3:-1]] == ["tick", "tock"]


@pytest.mark.parametrize("key", ["entered", "collisions"])
def test_a_summary_of_before_is_read(tmp_path: Path, key: str) -> None:
    prepared = written(tmp_path, "mission: none\nstates: {over: {type: final}}\n")
    folder = tmp_path / "run"
    folder.mkdir()
    recorder = Recorder(folder)
    recorder.write_summary(fly(Plan.alone(prepared), lambda: recorder))
    fields = json.loads((folder / "summary.json").read_text("utf-8"))
    del fields[key]
    (folder / "summary.json").write_text(json.dumps(fields) + "\n")
    summary = read_run(folder).summary
    assert summary is not None
    assert not getattr(summary.alone, key)
