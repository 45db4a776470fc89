from __future__ import annotations

import pytest

from fsm.coverage import Coverage
from fsm.testing import Trial, ends
from tests.fsm.toy import graph_of

SURVEY = """
mission: survey
data: {laps: 0}
states:
  up: {do: rise, with: {height: 2 m}, on: {done: fly, failed: end}}
  fly:
    on: {battery.low: home, blocked: home, failed: home}
    when: {vehicle.altitude > 100: home}
    states:
      lap:
        do: go
        with: {to: [1, 2]}
        on: {done: {target: lap, actions: {set: {laps: "${laps + 1}"}, log: "lap $laps"}}}
  home: {do: settle, on: {done: end, failed: end}}
  end: {type: final, outcome: over}
"""
SCRIPT = {"rise": ends(after=1.0), "go": ends(after=0.5), "home": ends(after=0.2)}


def trial() -> Trial:
    return Trial(graph_of(SURVEY), SCRIPT)


def test_a_mission_is_led_to_a_state_and_to_its_end() -> None:
    run = trial().until("fly.lap")
    assert (run.active, round(run.time, 3)) == (["fly.lap"], 1.0)
    run.advance(1.2).send("battery.low", level=0.2)
    assert run.end() == "over"
    run.assert_path("up", "fly.lap", "fly.lap", "fly.lap", "home", "end")
    assert (run.logged, run.value("laps")) == (["lap 1", "lap 2"], 2)


def test_what_comes_about_in_the_last_moment_is_not_missed() -> None:
    assert trial().until("fly.lap", within=1.0).time == 1.0
    run = trial().until("fly.lap").send("battery.low", level=0.1)
    assert (run.end(within=0.2), run.time) == ("over", pytest.approx(1.225))
    ended = Trial(graph_of("states: {a: {type: final}}"))
    assert ended.end(within=0.0) == "done"


def test_host_values_are_set_field_by_field() -> None:
    run = trial().until("fly.lap").set(vehicle={"altitude": 101.0}).until("home", within=0.1)
    assert run.active == ["home"]


def test_a_state_may_end_otherwise_than_others_with_its_behaviour() -> None:
    run = Trial(graph_of(SURVEY), {**SCRIPT, "fly.lap": ends("blocked", after=0.1, by="a tree")})
    assert run.end() == "over"
    run.assert_path("up", "fly.lap", "home", "end")


def test_what_does_not_come_about_fails_with_the_story() -> None:
    with pytest.raises(AssertionError, match=r"not reached within 2 s\nit is in fly.lap"):
        trial().until("home", within=2.0)
    with pytest.raises(AssertionError, match="did not end within 3 s"):
        trial().end(within=3.0)
    with pytest.raises(AssertionError, match=r"it took up → fly.lap"):
        trial().until("fly.lap").assert_path("up")


def test_misspelt_names_are_told() -> None:
    graph = graph_of(SURVEY)
    with pytest.raises(ValueError, match="is 'goo': did you mean 'go'"):
        Trial(graph, {"goo": ends()})
    with pytest.raises(ValueError, match="'go' has no outcome 'bloked': did you mean 'blocked'"):
        Trial(graph, {"go": ends("bloked")})
    with pytest.raises(ValueError, match="no parameter 'speed'"):
        Trial(graph, parameters={"speed": 1.0})
    with pytest.raises(ValueError, match="no state 'hom': did you mean 'home'"):
        trial().until("hom")
    with pytest.raises(ValueError, match=r"no 'vehicle.altitud' here: did you mean 'altitude'"):
        trial().set(vehicle={"altitud": 3.0})
    with pytest.raises(ValueError, match="no 'vehicel' here: did you mean 'vehicle'"):
        trial().set(vehicel={})


def test_coverage_names_what_was_not_visited() -> None:
    coverage = Coverage()
    for _ in range(2):
        graph = graph_of(SURVEY)
        coverage.watch(graph)
        Trial(graph, SCRIPT).until("fly.lap").send("battery.low", level=0.1).advance(0.1)
    other = Coverage()
    other.add(coverage.to_json())
    assert list(other.lines()) == list(coverage.lines())
    assert list(coverage.lines()) == [
        "m.yaml (survey): 4 of 5 states, 2 of 9 transitions",
        "  m.yaml:15:3: state end",
        "  m.yaml:5:63: up → end by on failed",
        "  m.yaml:7:38: fly → home by on blocked",
        "  m.yaml:7:52: fly → home by on failed",
        "  m.yaml:8:36: fly → home by when vehicle.altitude > 100",
        "  m.yaml:13:20: fly.lap → fly.lap by on done",
        "  m.yaml:14:33: home → end by on done",
        "  m.yaml:14:46: home → end by on failed",
    ]
