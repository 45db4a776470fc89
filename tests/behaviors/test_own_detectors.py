"""Detectors in the Python files beside a mission."""

from __future__ import annotations

from pathlib import Path

import pytest

from behaviors import load_all, trusted
from behaviors.detector import OwnDetector
from runner import missions, prepare
from runner.geometry import Terms, check_geometry
from tests.cli.run_cli import run_cli
from vencejo.errors import UserError, Where
from vencejo.nodes import Scalar

CODE = """\
from behaviors import Sighting, action, detector


@detector
def lamps(frame, ground, least: int = 200):
    'Bright things.'
    return []


@action
def note() -> None:
    'Note.'
"""
MISSION = """\
mission: own
uses: [own.py]
states:
  up: {do: takeoff, with: {altitude: 4 m}, on: {done: look, failed: down}}
  look:
    do: sweep_detect
    with:
      area: [[0, 0], [8, 0], [8, 6]]
      detect: [DETECT]
    on: {done: down, failed: down}
  down: {do: land, on: {done: end}}
  end: {type: final}
"""


def scalar(name: str = "own.py") -> Scalar:
    return Scalar(name, Where("m.yaml", 2, 8))


def test_a_marked_function_is_a_detector_with_its_settings(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(CODE)
    own = load_all([(scalar(), tmp_path)])
    found = own["lamps"]
    assert isinstance(found, OwnDetector) and set(own) == {"lamps", "note"}
    assert found.help == "Bright things." and list(found.parameters) == ["least"]
    on_trust = trusted([(scalar(), tmp_path)], [])
    assert on_trust["lamps"] == OwnDetector("lamps")
    assert not isinstance(on_trust["note"], OwnDetector)


@pytest.mark.parametrize("name", ["people", "color", "fiducials", "goto", "limits"])
def test_its_name_must_be_free(tmp_path: Path, name: str) -> None:
    (tmp_path / "own.py").write_text(CODE.replace("lamps", name))
    with pytest.raises(UserError) as raised:
        load_all([(scalar(), tmp_path)])
    assert raised.value.faults[0].code == "name-taken"


@pytest.mark.parametrize(
    "head", ["def lamps(frame)", "def lamps()", "async def lamps(frame, ground)"]
)
def test_one_that_cannot_be_called_is_refused(tmp_path: Path, head: str) -> None:
    (tmp_path / "own.py").write_text(
        CODE.replace("def lamps(frame, ground, least: int = 200)", head)
    )
    with pytest.raises(UserError) as raised:
        load_all([(scalar(), tmp_path)])
    assert raised.value.faults[0].code == "broken-code"


@pytest.mark.parametrize(
    ("detect", "message"),
    [
        ("lamps", ""),
        ("{lamps: {least: 230}}", ""),
        ("lams", "there is no detector 'lams'"),
        ("{lamps: {lest: 230}}", "the detector 'lamps' has no setting 'lest'"),
        ("{lamps: {least: 2.5}}", "the detector 'lamps'"),
        ("note", "there is no detector 'note'"),
    ],
)
def test_a_mission_names_it_and_is_checked(tmp_path: Path, detect: str, message: str) -> None:
    (tmp_path / "own.py").write_text(CODE)
    (tmp_path / "own.yaml").write_text(MISSION.replace("DETECT", detect))
    prepared = prepare(missions.find(str(tmp_path / "own.yaml")))
    faults = check_geometry(prepared.graph, prepared.world, Terms()).faults
    if not message:
        assert faults == ()
        return
    (fault,) = faults
    assert fault.code == "unflyable" and message in fault.message
    assert fault.where is not None and fault.where.line == 9
    # Taken on trust it has any settings, but must be there.
    unread = prepare(missions.find(str(tmp_path / "own.yaml")), code=False)
    trusting = check_geometry(unread.graph, unread.world, Terms()).faults
    assert bool(trusting) == (detect in ("lams", "note"))


def test_it_is_listed_and_explained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(CODE)
    assert "lamps  Bright things." in run_cli("behaviors", "--uses", "own.py").out
    told = run_cli("behaviors", "--uses", "own.py", "lamps").out
    assert "a detector: name it under `detect`" in told and "least" in told
    assert '"detector": "lamps"' in run_cli("behaviors", "--uses", "own.py", "lamps", "--json").out
