"""The wheel, installed into an empty environment far from the checkout."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]


def run(*command: str | Path, cwd: Path) -> str:
    done = subprocess.run(
        [str(word) for word in command], cwd=cwd, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def packaged() -> set[str]:
    """The files of the packages, those that are no code too."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    packages = project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    files = (path for package in packages for path in (ROOT / package).rglob("*.*"))
    return {str(path.relative_to(ROOT)) for path in files if path.suffix != ".pyc"}


def test_a_wheel_flies_missions_by_name_elsewhere(tmp_path: Path) -> None:
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet"]
    run(*pip, "wheel", "--no-deps", "--wheel-dir", tmp_path, ROOT, cwd=tmp_path)
    (wheel,) = tmp_path.glob("vencejo-*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert "runner/shipped/missions/first_flight.yaml" in names
    assert {"worlds/files/yard.yaml", "hal/sim/models/f450.yaml"} <= packaged() <= set(names)
    assert not [name for name in names if name.startswith(("tests", "bench", "docs"))]

    run(sys.executable, "-m", "venv", tmp_path / "env", cwd=tmp_path)
    constraints = ROOT / "constraints.txt"
    python = tmp_path / "env" / "bin" / "python"
    run(python, "-m", "pip", "install", "--quiet", "-c", constraints, wheel, cwd=tmp_path)
    command = tmp_path / "env" / "bin" / "drone-cli"
    away = tmp_path / "away"
    away.mkdir()
    for model in ("ardrone2", "f450"):
        flown = run(command, "run", "first_flight", "--model", model, "--json", cwd=away)
        assert json.loads(flown)["outcome"] == "done"
    run(command, "new", "mine", cwd=away)
    run(command, "run", "mine/mine.yaml", cwd=away)


def test_without_pybullet_it_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "pybullet.py").write_text("raise ImportError('No module named pybullet')\n")
    done = subprocess.run(
        [sys.executable, "-m", "tests.cli.drone_cli", "run", "first_flight"],
        cwd=tmp_path,
        env={"PATH": "/usr/bin:/bin", "PYTHONPATH": f"{tmp_path}:{ROOT}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 3
    assert "vencejo[bullet]" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "runs").exists()
