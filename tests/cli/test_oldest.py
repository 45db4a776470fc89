"""The oldest versions the dependencies' bounds allow: the same tests, in an environment of them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TESTS = (
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
    "tests/fsm",
)


@pytest.mark.slow
def test_everything_works_with_the_oldest_versions(tmp_path: Path) -> None:
    environment = tmp_path / "env"
    subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    python = environment / "bin" / "python"
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    oldest = ["-c", ROOT / "constraints-oldest.txt", "-e", ROOT, "pytest", "hypothesis"]
    subprocess.run([*install, *oldest], check=True, capture_output=True)
    done = subprocess.run(
        [python, "-m", "pytest", *TESTS, "-p", "no:cacheprovider"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:]
