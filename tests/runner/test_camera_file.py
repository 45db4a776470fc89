"""Cameras from a file."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest

from runner.camera_file import joined, read_camera_file
from vencejo.errors import UserError

GOOD = """\
front: {width: 640, height: 480, noise: 3, distortion: [-0.28, 0.09, 0.001, -0.0008, 0]}
left: {at: [0, 10 cm, 0], pan: 90 deg, view: 80 deg, rate: 10 Hz, exposure: 8 ms}
ventral: false
"""


def test_units_are_read_and_what_is_left_out_stays(tmp_path: Path) -> None:
    path = tmp_path / "c.yaml"
    path.write_text(GOOD)
    assert read_camera_file(path) == {
        "front": {
            "width": 640,
            "height": 480,
            "noise": 3.0,
            "distortion": (-0.28, 0.09, 0.001, -0.0008, 0.0),
        },
        "left": {
            "at": (0.0, pytest.approx(0.1), 0.0),
            "pan": pytest.approx(pi / 2),
            "view": pytest.approx(pi * 80 / 180),
            "rate": 10.0,
            "exposure": pytest.approx(0.008),
        },
        "ventral": None,
    }


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    path = tmp_path / "c.yaml"
    path.write_text("front: {widht: 640, pan: 3 m}\nleft: {at: [0, 1]}\nLeft: true\n")
    with pytest.raises(UserError) as raised:
        read_camera_file(path)
    found = [(f.where.line, f.where.column, f.code) for f in raised.value.faults if f.where]
    assert found == [
        (1, 9, "unknown-key"),
        (1, 26, "wrong-dimension"),
        (2, 12, "wrong-type"),
        (3, 1, "bad-name"),
        (3, 7, "wrong-type"),
    ]


def test_the_command_line_counts_over_the_file() -> None:
    file = {"front": {"width": 640, "noise": 3.0}, "left": None, "rear": {"rate": 5.0}}
    given = {"front": {"width": 320}, "left": {"rate": 9.0}, "rear": None}
    assert joined(file, given) == {
        "front": {"width": 320, "noise": 3.0},
        "left": {"rate": 9.0},
        "rear": None,
    }
