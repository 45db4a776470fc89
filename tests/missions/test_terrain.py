"""Flights over terrain in the simulator."""

from __future__ import annotations

from math import pi, tan
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


SLOPE = """
world: slope
ground:
  terrain:
    size: 40 m
    heights:
      - [0, 0, 0, 0, 0, 0, 0, 0, 0]
{rows}
      - [0, 0, 0, 0, 0, 0, 0, 0, 0]
start: {{at: [{x}, 0]}}
"""
UP = """
mission: up
world: slope.yaml
states:
  wait: {do: trim, on: {"*": stand}}
  stand: {after: {2 s: takeoff}}
  takeoff: {do: takeoff, with: {altitude: 2 m}, on: {done: high, failed: low}}
  high: {type: final, output: {height: $vehicle.altitude}}
  low: {type: final, outcome: low}
"""


@pytest.mark.parametrize("x", [-17.5, -19.9, -20.0, -20.1])
def test_a_take_off_from_a_steep_slope_and_from_its_foot(x: float, tmp_path: Path) -> None:
    """30°, more than it stands on; at the foot it begins on the slope, not in it."""
    rise = 5 * tan(pi / 6)
    row = [0.0, rise, 2 * rise, 3 * rise, 3 * rise, 3 * rise, 2 * rise, rise, 0.0]
    rows = "\n".join(f"      - {row}" for _ in range(7))
    (tmp_path / "slope.yaml").write_text(SLOPE.format(rows=rows, x=x))
    path = tmp_path / "up.yaml"
    path.write_text(UP)
    flight = fly_mission(str(path))
    assert flight.outcome == "done"
    assert flight.output["height"] > 1.7
    assert min(place.z for _, place in flight.track[:80]) > -0.2
