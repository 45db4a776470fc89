"""Missions that land for their battery: it is swapped or charged, and they go on."""

from __future__ import annotations

from pathlib import Path

import pytest

from runner.testing import MissionFlight, fly_mission

WORLD = """\
world: low
battery: 31 %
boxes: {pad: {at: [6, 0], size: [2, 2, 0.2], charges: 1200 W}}
"""
SWAP = """\
mission: relay
world: low.yaml
data: {landings: 0}
states:
  up: {do: takeoff, with: {altitude: 2 m}, on: {done: out}}
  out: {do: goto, with: {to: [6, 0, 2]}, on: {done: wait, blocked: down, battery.low: down}}
  wait: {do: hover, after: {8 s: home}, on: {battery.low: down}}
  down: {do: land, on: {done: fresh}}
  fresh: {entry: [{set: {landings: "${landings + 1}"}}, call: swap_battery], after: {1 s: up}}
  home: {do: goto, with: {to: [0, 0, 2]}, on: {done: end, blocked: end}}
  end: {do: land, on: {done: over}}
  over: {type: final, output: {landings: $landings, left: $vehicle.battery}}
"""


def flown(tmp_path: Path, mission: str) -> MissionFlight:
    (tmp_path / "low.yaml").write_text(WORLD)
    (tmp_path / "relay.yaml").write_text(mission)
    return fly_mission(tmp_path / "relay.yaml")


def test_a_mission_swaps_its_battery_and_flies_on(tmp_path: Path) -> None:
    flight = flown(tmp_path, SWAP)
    assert flight.outcome == "done", flight.reason
    assert flight.states == [
        *("up", "out", "wait", "down", "fresh", "up", "out", "wait", "home", "end", "over")
    ]
    assert flight.output["landings"] == 1 and 0.95 < flight.output["left"] < 0.99
    heard = [f for _, kind, f in flight.records if kind == "event" and f["name"] == "battery.low"]
    assert len(heard) == 1


def test_a_mission_charges_on_a_pad_and_flies_on(tmp_path: Path) -> None:
    mission = SWAP.replace(", call: swap_battery], after: {1 s: up}", "], after: {1 min: up}")
    mission = mission.replace("fresh: {", "fresh: {when: {vehicle.battery > 50 %: up}, ")
    flight = flown(tmp_path, mission)
    assert flight.outcome == "done", flight.reason
    assert flight.output["landings"] == 1 and 0.45 < flight.output["left"] < 0.5


@pytest.mark.parametrize("aloft", [True, False])
def test_a_battery_is_not_swapped_elsewhere(aloft: bool, tmp_path: Path) -> None:
    mission = SWAP.replace(", call: swap_battery", "")
    call = "entry: [call: swap_battery]"
    if aloft:
        mission = mission.replace("wait: {", f"wait: {{{call}, ")
    else:  # its motors run for a moment before it rises
        swap = f"swap: {{{call}, after: {{1 s: out}}}}"
        mission = mission.replace(
            "{altitude: 2 m}, on: {done: out}}",
            f"{{altitude: 2 m}}, on: {{done: out}}, after: {{25 ms: swap}}}}\n  {swap}",
        )
    flight = flown(tmp_path, mission)
    assert flight.outcome == "failed"
    told = "the vehicle is in the air" if aloft else "the motors are running"
    assert f"the battery cannot be swapped now: {told}" in flight.reason
