"""What the simulator says of legs before they are flown agrees with their flight."""

from __future__ import annotations

from pathlib import Path

import pytest

from hal import flight_model
from runner.loop import fly
from runner.missions import find
from runner.plan import Plan
from runner.preparation import prepare
from runner.testing import fly_mission
from vencejo.geometry import Point

MISSION = """
mission: leg
world: open.yaml
states:
  up: {{do: takeoff, with: {{altitude: 2 m}}, on: {{done: go}}}}
  go: {{do: {do}, on: {{done: down{blocked}}}}}
  down: {{do: land, on: {{done: end}}}}
  end: {{type: final}}
"""


def taken(
    tmp_path: Path, do: str, blocked: str = ", blocked: down", model: str = "ardrone2"
) -> float:
    """The share of the battery that a mission takes."""
    path = tmp_path / "leg.yaml"
    (tmp_path / "open.yaml").write_text(f"world: open\nmodel: {model}\n")
    path.write_text(MISSION.format(do=do, blocked=blocked))
    plan = Plan.alone(prepare(find(str(path))))
    flown = fly(plan).alone
    assert flown.outcome == "done"
    return 1 - flown.battery


@pytest.mark.parametrize(
    ("end", "speed"),
    [((30.0, 0.0, 2.0), 2.0), ((60.0, 20.0, 12.0), 4.0), ((4.0, 0.0, 2.0), 2.0), ((0, 0, 20.0), 2)],
)
def test_a_leg_takes_what_was_said(
    tmp_path: Path, end: tuple[float, float, float], speed: float
) -> None:
    model = flight_model("sim")
    assert model is not None
    here, to = Point(0.0, 0.0, 2.0), Point(*end)
    rest = f"speed: {speed} m/s, tolerance: 5 cm, heading: keep"
    both = f"route, with: {{points: [{list(to)}, {list(here)}], {rest}}}"
    stay = f"route, with: {{points: [{list(here)}], {rest}}}"
    there_and_back = taken(tmp_path, both) - taken(tmp_path, stay)
    said = 2 * model.leg_charge(here, to, speed, 0.0)
    assert there_and_back == pytest.approx(said, rel=0.12)


def test_a_stay_takes_what_was_said(tmp_path: Path) -> None:
    model = flight_model("sim")
    assert model is not None
    here = Point(0.0, 0.0, 2.0)
    dwell = "route, with: {points: [{at: [0, 0, 2], dwell: %s}]}"
    longer = taken(tmp_path, dwell % "30 s") - taken(tmp_path, dwell % "10 s")
    assert longer == pytest.approx(model.leg_charge(here, here, None, 20.0), rel=0.05)


def test_the_vehicle_returns_as_high_as_was_said(tmp_path: Path) -> None:
    model = flight_model("sim")
    assert model is not None
    path = tmp_path / "home.yaml"
    path.write_text(
        "mission: home\nstates:\n"
        "  up: {do: takeoff, with: {altitude: 2 m}, on: {done: go}}\n"
        "  go: {do: goto, with: {to: [4, 0, 2]}, on: {done: back, blocked: back}}\n"
        "  back: {do: return_home, on: {done: end}}\n  end: {type: final}\n"
    )
    assert fly_mission(path).highest == pytest.approx(model.return_height, abs=0.1)


def test_a_fast_leg_takes_the_power_of_its_drag(tmp_path: Path) -> None:
    """At 12 m/s a 450-class frame draws 1.3 times the power of hovering."""
    model = flight_model("sim", "f450")
    assert model is not None
    here, to = Point(0.0, 0.0, 2.0), Point(400.0, 0.0, 2.0)
    rest = "speed: 12 m/s, tolerance: 5 cm, heading: keep"
    both = f"route, with: {{points: [{list(to)}, {list(here)}], {rest}}}"
    stay = f"route, with: {{points: [{list(here)}], {rest}}}"
    flown = taken(tmp_path, both, model="f450") - taken(tmp_path, stay, model="f450")
    assert flown == pytest.approx(2 * model.leg_charge(here, to, 12.0, 0.0), rel=0.12)
    hovering = model.leg_charge(to, to, None, 2 * 400 / 12)
    assert flown > 1.1 * hovering, "more than the time alone"
