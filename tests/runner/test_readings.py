"""Sensor readings in the run folder: what a behaviour read, once, as it was."""

from __future__ import annotations

import json
from math import inf
from pathlib import Path

import pytest

from fsm import parse_parameters
from runner import Plan, Recorder, fly, missions, prepare, read_run

MEASURE = """\
from behaviors import Behavior


class Measure(Behavior):
    \"\"\"Reads the rangefinder in every period.\"\"\"

    outcomes = {}
    controls = ()

    def step(self, flight):
        self.last = flight.sensor("down").latest()
"""
MISSION = """\
mission: measured
uses: [measure.py]
states:
  watched:
    do: measure
    on: {failed: land}
    states:
      up: {do: takeoff, with: {altitude: 3 m}, on: {done: stay}}
      stay: {after: {500 ms: land}}
  land: {do: land, on: {done: over}}
  over: {type: final}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "measure.py").write_text(MEASURE)
    (tmp_path / "measured.yaml").write_text(MISSION)
    ordered = prepare(missions.find(str(tmp_path / "measured.yaml")))
    settings = {"sensors": {"down": {"max_range": 2.0, "rate": 10.0}}}
    plan = Plan.alone(ordered, parse_parameters(ordered.graph, {}), settings=settings)
    made = tmp_path / "run"
    made.mkdir()
    recorder = Recorder(made)
    summary = fly(plan, lambda: recorder)
    recorder.write_summary(summary)
    assert summary.alone.outcome == "done"
    return made


def test_each_reading_is_kept_once(folder: Path) -> None:
    run = read_run(folder)
    readings = run.readings
    assert run.missing == ()
    assert {(each.vehicle, each.sensor) for each in readings} == {("drone", "down")}
    times = [each.reading.time for each in readings]
    assert times == pytest.approx([0.1 * number for number in range(len(times))])
    heights = [each.reading.values["distance"] for each in readings]
    assert heights[0] == pytest.approx(0.06, abs=0.01)
    assert heights[-1] == inf, "3 m are out of its range"
    assert heights == sorted(heights)
    lines = (folder / "readings.jsonl").read_text().splitlines()
    assert json.loads(lines[0]) == {"format": "vencejo.readings", "version": 1}
    assert json.loads(lines[-1])["values"] == {"distance": "inf"}


def test_a_last_line_that_was_cut_off_is_left_out(folder: Path) -> None:
    whole = read_run(folder).readings
    file = folder / "readings.jsonl"
    file.write_bytes(file.read_bytes()[:-5])
    cut = read_run(folder)
    assert cut.readings == whole[:-1]
    assert any("readings.jsonl" in what for what in cut.missing)


def test_a_flight_that_reads_no_sensor_leaves_no_file(tmp_path: Path) -> None:
    ordered = prepare(missions.find("first_flight"))
    plan = Plan.alone(ordered, parse_parameters(ordered.graph, {}))
    fly(plan, lambda: Recorder(tmp_path))
    assert not (tmp_path / "readings.jsonl").exists()
    assert read_run(tmp_path).readings == ()
