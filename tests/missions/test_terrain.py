"""Flights over terrain in the simulator."""

from __future__ import annotations

from pathlib import Path

import pytest

from runner.testing import fly_mission
from vencejo.geometry import distance

HILL = """
world: hill
ground:
  terrain:
    size: 40 m
    heights: [[0, 0, 0, 0, 0], [0, 2, 4, 2, 0], [0, 4, 8, 4, 0], [0, 2, 4, 2, 0], [0, 0, 0, 0, 0]]
start: {at: [-15, 0]}
"""
OVER = """
mission: over
world: hill.yaml
states:
  takeoff: {do: takeoff, with: {altitude: 3 m}, on: {done: go}}
  go:
    do: goto
    with: {to: {x: 15, y: 0, above_ground: 4 m}, tolerance: 5 cm}
    on: {done: on, blocked: stray}
  on:
    do: route
    with:
      tolerance: 20 cm
      points: [{at: {x: 0, y: 5, frame: world, above_ground: 2 m}, dwell: 1 s}]
    on: {done: land, blocked: stray}
  stray: {type: final, outcome: stray}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


def test_heights_above_ground_are_those_of_the_hill(tmp_path: Path) -> None:
    (tmp_path / "hill.yaml").write_text(HILL)
    path = tmp_path / "over.yaml"
    path.write_text(OVER)
    flight = fly_mission(str(path))
    assert flight.outcome == "done"
    # Home is at 2 m, or a little more: the vehicle stands above the highest ground under it.
    (top,) = [
        place
        for time, kind, fields in flight.records
        if kind == "enter" and fields["state"] == "on"
        for at, place in flight.track
        if abs(at - time) < 1e-6
    ]
    assert distance(top, (15, 0, 10)) < 0.15
    heights = [place.z for _, place in flight.track if distance(place, (15, 5, place.z)) < 0.1]
    assert max(heights) == pytest.approx(6.0, abs=0.2)
