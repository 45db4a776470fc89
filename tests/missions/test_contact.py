"""Missions whose vehicles hit, land on and ride on the things of a world."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from runner.testing import MissionFlight, fly_mission
from vencejo.geometry import distance

ACROSS = """
mission: across
world: w.yaml
states:
  up: {{do: takeoff, with: {{altitude: 3.6 m}}, on: {{done: go}}}}
  go: {{do: goto, with: {{to: [{x}, {y}, {z}], speed: 4 m/s}}, on: {{done: land, blocked: land}}}}
  land: {{do: land, on: {{done: finish}}}}
  finish: {{type: final}}
"""
RIDE = """
mission: ride
world: w.yaml
states:
  up: {do: takeoff, with: {altitude: 2.5 m}, on: {done: go, failed: land}}
  go: {do: goto, with: {to: [0, -3, 2.5]}, on: {done: wait, blocked: land}}
  wait: {do: hover, when: {time > 20 s: land}}
  land: {do: land, on: {done: ride, failed: ride}}
  ride: {after: {3 s: finish}}
  finish: {type: final}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def flown(folder: Path, mission: str, world: str) -> MissionFlight:
    (folder / "w.yaml").write_text("world: w\n" + world)
    (folder / "m.yaml").write_text(mission)
    return fly_mission("m.yaml")


def heard(flight: MissionFlight) -> list[tuple[str, Any]]:
    """The events of the vehicle, and the things that they name."""
    return [
        (fields["name"].removeprefix("vehicle."), fields["fields"]["thing"])
        for _, kind, fields in flight.records
        if kind == "event" and fields["name"].startswith("vehicle.")
    ]


def test_a_hit_on_the_shoulder_of_a_ball_is_told_and_it_lands_beside(folder: Path) -> None:
    ball = "spheres: {ball: {at: [10, 0], radius: 2 m}}\n"
    flight = flown(folder, ACROSS.format(x=20, y=0, z=3.4), ball)
    assert flight.outcome == "done"
    assert heard(flight) == [("collision", "ball"), ("unstable", "ball")]
    assert flight.end.z == pytest.approx(0, abs=0.01) and flight.end.x < 8.0


@pytest.mark.parametrize("radius", [0.4, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("aside", [(0.0, 0.0), (0.1, 0.2)])
def test_from_the_top_of_a_ball_it_comes_to_the_ground(
    folder: Path, radius: float, aside: tuple[float, float]
) -> None:
    ball = f"spheres: {{ball: {{at: [10, 0, -0.5], radius: {radius} m}}}}\n"
    over = {"x": 10 + aside[0], "y": aside[1], "z": 2 * radius + 2}
    flight = flown(folder, ACROSS.format(**over), ball)
    assert flight.outcome == "done" and ("unstable", "ball") in heard(flight)
    assert flight.end.z == pytest.approx(0, abs=0.01)
    assert distance(flight.end[:2], (over["x"], over["y"])) >= 1.0


def test_on_a_large_steep_roof_it_has_failed_and_is_landed_beside(folder: Path) -> None:
    eaves, top = 8, 8
    (folder / "roof.obj").write_text(
        f"v -{eaves} -30 0\nv {eaves} -30 0\nv 0 -30 {top}\n"
        f"v -{eaves} 30 0\nv {eaves} 30 0\nv 0 30 {top}\n"
        "f 1 2 3\nf 6 5 4\nf 2 5 6 3\nf 4 1 3 6\nf 1 4 5 2\n"
    )
    roof = "meshes: {roof: {at: [12, 0], file: roof.obj}}\n"
    flight = flown(folder, ACROSS.format(x=12.5, y=0, z=12), roof)
    assert flight.outcome == "failed"
    assert flight.reason.endswith("land refused: it does not stand on the roof")
    events = heard(flight)
    assert events.count(("unstable", "roof")) == 4
    assert flight.end.z == pytest.approx(0, abs=0.01) and flight.end.x > 20


@pytest.mark.parametrize("speed", [0.25, 0.5])
def test_it_lands_on_the_pad_that_comes_by_and_rides_on_it(folder: Path, speed: float) -> None:
    """The pad is below the vehicle at 23 s."""
    west = 5.0 - speed * 23
    pad = (
        "start: {at: [5, 3]}\nboxes: {pad: {size: [3, 3, 0.3], "
        f"moves: {{through: [[{west}, 0], [{west + 60}, 0]], speed: {speed} m/s}}}}}}\n"
    )
    flight = flown(folder, RIDE, pad)
    assert flight.outcome == "done" and heard(flight) == []
    landed = next(
        time
        for time, kind, fields in flight.records
        if fields.get("name") == "done" and fields["state"] == "land"
    )
    assert 22.5 < landed < 24.0
    riding = [(time, place) for time, place in flight.track if time > landed]
    (began, start), (ended, end) = riding[0], riding[-1]
    assert start.z == pytest.approx(0.3, abs=0.01) and end.z == pytest.approx(0.3, abs=0.01)
    assert ended - began > 2.9
    assert end.x - start.x == pytest.approx(speed * (ended - began), abs=0.02)
    assert end.y == pytest.approx(start.y, abs=0.01)
