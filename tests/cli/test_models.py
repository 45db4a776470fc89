"""Models of vehicles on the command line: listed, checked against, flown, flown again."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import hal.sim
from tests.cli.run_cli import run_cli

pytestmark = pytest.mark.usefixtures("undrawn")
Write = Callable[[str, str], str]
CRAZYFLIE = (Path(hal.sim.__file__).parent / "models/crazyflie.yaml").read_text()
EYES = """
from behaviors import Behavior, BehaviorParams

class _Look(Behavior):
    class Params(BehaviorParams):
        pass
    outcomes = {"done": None}
    controls = ()
    def step(self, flight):
        for word in self.requires:
            name = word.partition(".")[2]
            assert flight.camera(name).latest() is not None
        return "done"

class LookAhead(_Look):
    requires = ("camera.front",)

class LookDown(_Look):
    requires = ("camera.ventral",)

class WatchAhead(_Look):
    outcomes = {"lost": None}
    requires = ("camera.front",)
    def step(self, flight):
        return None

class LookAround(_Look):
    requires = ("camera.front", "camera.ventral")
"""
LOOK = """
mission: look
uses: [eyes.py]
states:
  takeoff: {do: takeoff, with: {altitude: 1 m}, on: {done: ahead}}
  ahead: {do: look_ahead, on: {done: down}}
  down: {do: look_down, on: {done: land}}
  land: {do: land, on: {done: end}}
  end: {type: final}
"""
HOP = """
mission: hop
states:
  takeoff: {do: takeoff, with: {altitude: 1 m}, on: {done: land}}
  land: {do: land, on: {done: end}}
  end: {type: final}
"""


def header(folder: Path) -> dict[str, Any]:
    with (folder / "events.jsonl").open() as file:
        found: dict[str, Any] = json.loads(file.readline())
    return found


def only(folder: str) -> Path:
    (found,) = Path(folder).iterdir()
    return found


def test_models_are_listed_with_their_main_figures() -> None:
    listed = run_cli("models")
    assert listed.code == 0
    lines = listed.out.splitlines()
    assert "mass" in lines[0] and "thrust / weight" in lines[0] and "top speed" in lines[0]
    assert [line.split()[0] for line in lines[1:5]] == ["ardrone1", "ardrone2", "crazyflie", "f450"]
    facts = json.loads(run_cli("models", "--json").out)
    assert [each["model"] for each in facts] == ["ardrone1", "ardrone2", "crazyflie", "f450"]
    assert facts[2]["cameras"] == [] and facts[3]["mass_kg"] == 1.2


def test_one_model_is_shown() -> None:
    shown = run_cli("models", "ardrone2").out
    assert "cameras          front, ventral (one active at a time)" in shown
    assert "  indoor: max_speed 2 m/s, max_climb 0.7 m/s" in shown
    wrong = run_cli("models", "ardrone3")
    assert (wrong.code, "did you mean 'ardrone2'?" in wrong.err) == (2, True)


def test_a_model_without_cameras_is_refused_where_one_is_needed(write: Write) -> None:
    write("eyes.py", EYES)
    write("m.yaml", LOOK)
    assert run_cli("check", "m.yaml").code == 0
    result = run_cli("check", "m.yaml", "--model", "crazyflie")
    assert result.code == 2
    told = "which the model 'crazyflie' of the backend 'sim' does not offer [missing-capability]"
    assert f"m.yaml:6:3: error: 'look_ahead' needs 'camera.front', {told}" in result.err
    assert f"m.yaml:7:3: error: 'look_down' needs 'camera.ventral', {told}" in result.err
    flown = run_cli("run", "m.yaml", "--model", "crazyflie")
    assert flown.code == 2 and not Path("runs").exists()
    assert "which the model 'crazyflie' does not have" in flown.err


def test_a_worlds_model_is_checked_against_and_the_command_line_counts_over_it(
    write: Write,
) -> None:
    write("eyes.py", EYES)
    write("m.yaml", LOOK.replace("uses:", "world: w.yaml\nuses:"))
    write("w.yaml", "world: w\nmodel: crazyflie\n")
    assert "the model 'crazyflie'" in run_cli("check", "m.yaml").err
    assert run_cli("check", "m.yaml", "--model", "f450").code == 0
    write("w.yaml", "world: w\nmodel: crazyfli\n")
    result = run_cli("check", "m.yaml")
    assert (result.code, "did you mean 'crazyflie'?" in result.err) == (2, True)
    assert "w.yaml: error: no model is called 'crazyfli'" in result.err


def test_each_behaviour_gets_the_camera_it_needs(write: Write) -> None:
    write("eyes.py", EYES)
    write("m.yaml", LOOK)
    result = run_cli("run", "m.yaml", "--model", "ardrone1", "--no-frames")
    assert result.code == 0, result.err
    assert "ardrone1" in result.out.splitlines()[-2]


PHOTO = """
mission: photo
parameters: {eye: ventral}
states:
  takeoff: {do: takeoff, with: {altitude: 1 m}, on: {done: one}}
  one: {do: photo, with: {camera: CAMERA}, on: {done: two, failed: lost}}
  two: {do: photo, with: {camera: front}, on: {done: land, failed: lost}}
  lost: {do: land, on: {done: grounded}}
  land: {do: land, on: {done: end}}
  end: {type: final}
  grounded: {type: final, outcome: grounded}
"""


@pytest.mark.parametrize("camera", ["ventral", "$eye"])
def test_a_picture_is_taken_by_the_camera_it_names(camera: str, write: Write) -> None:
    write("m.yaml", PHOTO.replace("CAMERA", camera))
    result = run_cli("run", "m.yaml")
    assert result.code == 0, result.err
    assert "camera" not in run_cli("check", "m.yaml").err


def test_a_camera_that_the_vehicle_does_not_have_is_told_before_the_flight(write: Write) -> None:
    write("m.yaml", PHOTO.replace("CAMERA", "ventrl"))
    result = run_cli("run", "m.yaml")
    assert result.code == 2
    assert "m.yaml:6:3: error: 'photo' needs 'camera.ventrl', which the model 'ard" in result.err
    checked = run_cli("check", "m.yaml", "--model", "f450")
    assert checked.code == 2 and "'f450' of the backend 'sim' does not offer" in checked.err
    assert ": warning: 'photo' needs 'camera.ventrl'" in run_cli("check", "m.yaml").err


WIND = """
mission: windy
states:
  takeoff: {do: takeoff, with: {altitude: 1 m}, on: {done: wait}}
  wait: {do: hover, when: {"vehicle.wind.x > 9 m/s": land}, after: {1 s: land}}
  land: {do: land, on: {done: end}}
  end: {type: final}
"""


def test_a_mission_that_asks_for_the_wind_needs_a_model_that_estimates_it(write: Write) -> None:
    write("m.yaml", WIND)
    result = run_cli("run", "m.yaml", "--model", "crazyflie")
    assert result.code == 2
    told = "m.yaml:5:29: error: 'vehicle.wind' needs 'wind', which the model 'crazyflie'"
    assert told in result.err
    assert told in run_cli("check", "m.yaml", "--model", "crazyflie").err
    assert run_cli("run", "m.yaml", "--model", "f450").code == 0


NESTED = """
mission: look
uses: [eyes.py]
states:
  takeoff: {do: takeoff, with: {altitude: 1 m}, on: {done: both}}
  both: BOTH
  land: {do: land, on: {done: end}}
  end: {type: final}
"""


@pytest.mark.parametrize(
    ("both", "severity", "told"),
    [
        ("{do: look_around, on: {done: land}}", "error", "'look_around' needs the cameras"),
        (
            "{do: watch_ahead, on: {lost: land}, states: {a: {do: look_down, on: {done: land}}}}",
            "warning",
            "can be active together and need the cameras 'front' and 'ventral'",
        ),
        (
            "{type: parallel, after: {2 s: land}, states: {a: {do: look_down, on: {done: {}}}, "
            "d: {do: watch_ahead, on: {lost: land}}}}",
            "warning",
            "can be active together and need the cameras 'front' and 'ventral'",
        ),
    ],
)
def test_two_cameras_at_once_are_told_of_a_model_with_one_active(
    both: str, severity: str, told: str, write: Write
) -> None:
    write("eyes.py", EYES)
    write("m.yaml", NESTED.replace("BOTH", both))
    result = run_cli("check", "m.yaml")
    found = [line for line in result.err.splitlines() if "[two-cameras]" in line]
    assert len(found) == 1 and told in found[0] and f": {severity}: " in found[0]
    assert "of which the model 'ardrone2' has one active at a time" in found[0]
    if severity == "error":
        assert run_cli("run", "m.yaml").code == 2
    assert "two-cameras" not in run_cli("check", "m.yaml", "--model", "f450").err


TOGGLE = """
mission: toggle
uses: [eyes.py]
states:
  takeoff: {do: takeoff, with: {altitude: 1 m}, on: {done: down}}
  down:
    entry: {call: {camera: CAMERA}}
    do: look_where
    on: {done: land, failed: land, error.execution: lost}
  lost: {do: land, on: {done: {target: end}}}
  land: {do: land, on: {done: seen}}
  seen: {type: final}
  end: {type: final, outcome: lost}
"""
WHERE = """
from behaviors import Behavior
from hal import Unavailable

class LookWhere(Behavior):
    outcomes = {"done": None}
    def step(self, flight):
        assert flight.camera("ventral").latest() is not None
        try:
            flight.camera("front").latest()
        except Unavailable as error:
            assert "'front' is not active, 'ventral' is" in str(error)
            return "done"
"""


@pytest.mark.parametrize(
    ("camera", "outcome"), [("ventral", 0), ("toggle", 0), ("{name: ventral}", 0), ("rear", 1)]
)
def test_a_mission_switches_the_active_camera(camera: str, outcome: int, write: Write) -> None:
    write("eyes.py", WHERE)
    write("m.yaml", TOGGLE.replace("CAMERA", camera))
    result = run_cli("run", "m.yaml", "--no-frames")
    assert (result.code, "failed" in result.out) == (outcome, False), result.out


def test_a_model_of_ones_own_is_kept_with_the_run_and_flown_again(write: Write) -> None:
    Path("mine").mkdir()
    write("m.yaml", HOP)
    own = CRAZYFLIE.replace("model: crazyflie", "model: heavier").replace("27 g", "28 g")
    write("mine/own.yaml", own)
    result = run_cli("run", "m.yaml", "--model", "mine/own.yaml", "--limit", "indoor")
    assert result.code == 0, result.err
    folder = only("runs")
    assert (folder / "own.yaml").read_text() == own
    found = header(folder)
    assert (found["model"], found["settings"]["model"]) == ("heavier", "own.yaml")
    assert json.loads((folder / "summary.json").read_text())["model"] == "heavier"
    Path("mine/own.yaml").unlink()
    again = run_cli("run", "--again", str(folder), "--runs-dir", "again")
    assert again.code == 0, again.err
    assert (only("again") / "events.jsonl").read_bytes() == (folder / "events.jsonl").read_bytes()
    (folder / "own.yaml").write_text(own.replace("28 g", "29 g"))
    changed = run_cli("run", "--again", str(folder), "--runs-dir", "again")
    assert (changed.code, "own.yaml: error: this copy is not" in changed.err) == (2, True)


def test_a_model_that_a_world_names_is_kept_with_the_world(write: Write) -> None:
    write("m.yaml", HOP.replace("states:", "world: w.yaml\nstates:"))
    write("w.yaml", "world: w\nmodel: own.yaml\n")
    write("own.yaml", CRAZYFLIE.replace("model: crazyflie", "model: own"))
    assert run_cli("run", "m.yaml").code == 0
    folder = only("runs")
    assert header(folder)["model"] == "own" and (folder / "own.yaml").is_file()
    Path("own.yaml").unlink()
    again = run_cli("run", "--again", str(folder), "--runs-dir", "again")
    assert again.code == 0, again.err


FLEET = """
fleet: two
vehicles:
  big: {mission: m.yaml, model: f450, start: {at: [0, 0]}}
  small: {mission: m.yaml, model: own.yaml, start: {at: [3, 0]}}
"""


def test_the_vehicles_of_a_fleet_are_of_different_models(write: Write) -> None:
    Path("there").mkdir()
    write("there/m.yaml", HOP)
    write("there/own.yaml", CRAZYFLIE.replace("model: crazyflie", "model: own"))
    write("there/fleet.yaml", FLEET)
    assert run_cli("check", "there/fleet.yaml").code == 0
    assert run_cli("run", "there/fleet.yaml").code == 0
    folder = only("runs")
    vehicles = header(folder)["vehicles"]
    assert {name: each["model"] for name, each in vehicles.items()} == {
        "big": "f450",
        "small": "own",
    }
    again = run_cli("run", "--again", str(folder), "--runs-dir", "again")
    assert again.code == 0, again.err
    assert (only("again") / "events.jsonl").read_bytes() == (folder / "events.jsonl").read_bytes()
    over = run_cli("run", "there/fleet.yaml", "--model", "crazyflie", "--runs-dir", "over")
    assert over.code == 0, over.err
    vehicles = header(only("over"))["vehicles"]
    assert {each["model"] for each in vehicles.values()} == {"crazyflie"}
    write("there/fleet.yaml", FLEET.replace("f450", "f45"))
    wrong = run_cli("check", "there/fleet.yaml")
    assert (wrong.code, "did you mean 'f450'?" in wrong.err) == (2, True)
    assert "fleet.yaml:4:33: error: no model is called 'f45'" in wrong.err


def test_a_model_on_a_backend_without_models_is_refused(write: Write) -> None:
    write("m.yaml", HOP)
    result = run_cli("check", "m.yaml", "--backend", "mavlink", "--model", "f450")
    assert (result.code, "[no-models]" in result.err) == (2, True)


def test_a_profile_that_a_model_lacks_is_told(write: Write) -> None:
    write("m.yaml", HOP)
    result = run_cli("check", "m.yaml", "--model", "crazyflie", "--limit", "outdoor")
    assert (result.code, "there is no profile 'outdoor'" in result.err) == (2, True)


def test_what_a_model_can_fly_is_checked_with_its_own_battery(write: Write) -> None:
    far = HOP.replace("on: {done: land}", "on: {done: far}", 1).replace(
        "  land:",
        "  far: {do: goto, with: {to: [700, 0, 1]}, on: {done: land, blocked: land}}\n  land:",
    )
    write("m.yaml", far)
    assert "battery" not in run_cli("check", "m.yaml").err
    assert "battery" in run_cli("check", "m.yaml", "--model", "crazyflie").err
