from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.run_cli import run_cli


def test_what_new_makes_checks_flies_and_passes_its_tests(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("cli.run._draw", lambda folder: None)
    assert run_cli("new", "my_trip").code == 0
    assert sorted(path.name for path in Path("my_trip").iterdir()) == [
        "my_trip.yaml",
        "my_trip_behaviors.py",
        "test_my_trip.py",
    ]
    assert run_cli("check", "--strict", "my_trip/my_trip.yaml").code == 0
    assert run_cli("run", "my_trip/my_trip.yaml").code == 0
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "my_trip"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout


@pytest.mark.parametrize("name", ["My Trip", "9lives", "../up", ""])
def test_a_bad_name_is_refused(name: str) -> None:
    assert run_cli("new", name).code == 2
    assert list(Path().iterdir()) == []


def test_nothing_is_written_over() -> None:
    Path("mine").mkdir()
    result = run_cli("new", "mine")
    assert result.code == 2
    assert "exists already" in result.err
