"""The option --engine, wherever missions fly in the simulator."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.run_cli import run_cli
from tests.hal.engines import ENGINES

PACKAGES = {"bullet": "pybullet", "mujoco": "mujoco"}


@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_names_its_engine_and_again_keeps_it(hop: str, engine: str) -> None:
    result = run_cli("run", hop, "--engine", engine, "--runs-dir", "first", "--json")
    assert result.code == 0
    summary = json.loads(result.out)
    assert summary["engine"].split()[0] == PACKAGES[engine]
    (first,) = Path("first").iterdir()
    result = run_cli("run", "--again", str(first), "--runs-dir", "again", "--json")
    assert json.loads(result.out)["engine"] == summary["engine"]
    (again,) = Path("again").iterdir()
    for file in ("events.jsonl", "telemetry.csv"):
        assert (again / file).read_bytes() == (first / file).read_bytes()


@pytest.mark.parametrize("engine", ENGINES)
def test_check_flies_with_it(hop: str, engine: str) -> None:
    result = run_cli("check", hop, "--fly", "1", "--engine", engine, "--json")
    (report,) = json.loads(result.out)
    assert result.code == 0 and report["flights"][0]["outcome"] == "done"


@pytest.mark.parametrize("command", ["run", "check"])
def test_another_name_is_refused_with_the_nearest(command: str, hop: str) -> None:
    result = run_cli(command, hop, "--engine", "mujco")
    assert result.code == 2
    assert "'mujco' is none of bullet, mujoco; did you mean 'mujoco'?" in result.err
