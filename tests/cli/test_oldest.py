"""The oldest versions the dependencies' bounds allow: the same tests, in an environment of them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BEHAVIORS = ROOT / "tests" / "behaviors"
SIGHTED = [
    str(path.relative_to(ROOT))
    for path in sorted(BEHAVIORS.glob("test_*.py"))
    if "tests.behaviors.sighted" in path.read_text("utf-8")
]
"""The tests of behaviours that see."""
TESTS = (
    *SIGHTED,
    "tests/cli/test_run.py",
    "tests/cli/test_pieces.py",
    "tests/runner/test_camera_logs.py",
    "tests/runner/test_frames.py",
    "tests/runner/test_loop.py",
    "tests/runner/test_pace.py",
    "tests/runner/test_recorder.py",
    "tests/runner/test_run_folder.py",
    "tests/behaviors/perception",
    "tests/hal/test_contract.py",
    "tests/hal/test_sim_cameras.py",
    "tests/hal/test_textures.py",
    "tests/fsm",
)


def test_behaviours_that_see_are_among_them() -> None:
    assert "tests/behaviors/test_detect_tags.py" in SIGHTED


@pytest.mark.slow
def test_everything_works_with_the_oldest_versions(tmp_path: Path) -> None:
    environment = tmp_path / "env"
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    python = environment / "bin" / "python"
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    oldest = [
        "-c",
        ROOT / "constraints-oldest.txt",
        "-e",
        f"{ROOT}[mujoco]",
        "pytest",
        "hypothesis",
    ]
    subprocess.run([*install, *oldest], check=True, capture_output=True)
    done = subprocess.run(
        [python, "-m", "pytest", *TESTS, "-p", "no:cacheprovider"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:]
