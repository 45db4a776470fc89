from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

MISSION = """\
mission: hop
description: Up and down.
parameters: {height: {default: 1 m, min: 50 cm, max: 5 m}}
states:
  takeoff: {do: takeoff, with: {altitude: $height}, on: {done: land}}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def hop(tmp_path: Path) -> str:
    """A short mission."""
    (tmp_path / "hop.yaml").write_text(MISSION)
    return "hop.yaml"


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs without their picture, which takes longer than the flight."""
    monkeypatch.setattr("cli.run._draw", lambda folder: None)


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str, str], str]:
    def write_file(name: str, text: str) -> str:
        (tmp_path / name).write_text(text)
        return name

    return write_file
