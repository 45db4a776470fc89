"""Cameras from a file: `drone-cli run --cameras FILE`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.run_cli import run_cli

Write = Callable[[str, str], str]
pytestmark = pytest.mark.usefixtures("undrawn")

GOOD = """\
front: {width: 640, height: 480, noise: 3, distortion: [-0.28, 0.09, 0.001, -0.0008, 0]}
left: {at: [0, 10 cm, 0], pan: 90 deg, view: 80 deg, rate: 10 Hz, exposure: 8 ms}
ventral: false
"""


def test_a_run_with_cameras_of_a_file(write: Write, tmp_path: Path) -> None:
    write("c.yaml", GOOD)
    runs = tmp_path / "runs"
    result = run_cli(
        "run", "first_flight", "--speed", "max", "--cameras", "c.yaml", "--runs-dir", str(runs)
    )
    assert result.code == 0, result.err
    (folder,) = runs.iterdir()
    assert (folder / "c.yaml").read_text() == GOOD
    write("c.yaml", "front: {rate: 1000}\n")
    result = run_cli("run", "first_flight", "--cameras", "c.yaml", "--runs-dir", str(runs))
    assert (result.code, "has a rate of 1000" in result.err) == (2, True)
    result = run_cli("run", "first_flight", "--cameras", "no.yaml", "--runs-dir", str(runs))
    assert (result.code, "[no-such-file]" in result.err) == (2, True)
    assert len(list(runs.iterdir())) == 1
