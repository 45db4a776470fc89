"""Frames that behaviours read are kept, once each, and change nothing else."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import pytest

from tests.cli.run_cli import run_cli

Write = Callable[[str, str], str]
pytestmark = pytest.mark.usefixtures("undrawn")

BEHAVIOR = """\
from behaviors import Behavior, BehaviorParams, param

class Look(Behavior):
    '''Read a camera every period, twice, until some pictures were seen.'''

    class Params(BehaviorParams):
        pictures: int = param(5, help="how many")

    outcomes = {"done": None}
    requires = ("camera.front",)

    def start(self, flight, progress=None):
        self.camera = flight.camera("front")
        self.seen = set()

    def step(self, flight):
        for camera in (self.camera, flight.camera("front")):
            self.seen.add(camera.latest().sequence)
        return "done" if len(self.seen) == self.params.pictures else None
"""
MISSION = """\
mission: looker
uses: [look.py]
states:
  wait: {after: {1 s: look}}
  look: {do: look, on: {done: over}}
  over: {type: final}
"""
CAMERA = ("--camera", "front:64x48@20")


@pytest.fixture
def looker(write: Write) -> str:
    write("look.py", BEHAVIOR)
    return write("looker.yaml", MISSION)


def only(folder: str) -> Path:
    (found,) = Path(folder).iterdir()
    return found


def lines(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "frames.jsonl").read_text().splitlines()]


def test_every_frame_that_was_read_is_kept_once(looker: str) -> None:
    assert run_cli("run", looker, *CAMERA).code == 0
    folder = only("runs")
    first, *kept = lines(folder)
    assert first == {"format": "vencejo.frames", "version": 1}
    numbers = [line["sequence"] for line in kept]
    assert numbers == [*range(numbers[0], numbers[0] + 5)]
    assert [line["t"] for line in kept] == pytest.approx([number / 20 for number in numbers])
    files = [f"frames/drone/front/{number:06d}.jpg" for number in numbers]
    assert [line["file"] for line in kept] == files
    written = [path for path in folder.glob("frames/**/*") if path.is_file()]
    assert sorted(path.relative_to(folder).as_posix() for path in written) == files
    assert {cv2.imread(str(path)).shape for path in written} == {(48, 64, 3)}
    assert set(kept[0]) == {
        "t", "vehicle", "camera", "sequence", "file", "position", "attitude", "intrinsics"
    }  # fmt: skip
    assert all(set(kept[0]) - set(line) == {"intrinsics"} for line in kept[1:])
    assert kept[0]["intrinsics"]["width"] == 64
    assert kept[0]["position"][0] == pytest.approx(0.2, abs=0.01)


def test_the_log_does_not_tell_whether_frames_were_kept(looker: str) -> None:
    assert run_cli("run", looker, *CAMERA, "--noise", "1", "--runs-dir", "a").code == 0
    assert (
        run_cli("run", looker, *CAMERA, "--noise", "1", "--runs-dir", "b", "--no-frames").code == 0
    )
    kept, left_out = only("a"), only("b")
    for name in ("events.jsonl", "telemetry.csv"):
        assert (kept / name).read_bytes() == (left_out / name).read_bytes()
    assert {path.name for path in kept.iterdir()} - {path.name for path in left_out.iterdir()} == {
        "frames",
        "frames.jsonl",
    }


def test_equal_runs_keep_equal_pictures(looker: str) -> None:
    for name in "ab":
        assert run_cli("run", looker, *CAMERA, "--runs-dir", name).code == 0
    first, second = only("a"), only("b")
    pictures = sorted(path.relative_to(first) for path in first.glob("frames/**/*.jpg"))
    assert len(pictures) == 5
    for name in (*pictures, "frames.jsonl"):
        assert (first / name).read_bytes() == (second / name).read_bytes()


def test_without_reads_there_is_neither_file_nor_folder_nor_opencv(hop: str) -> None:
    code = """
import sys
from cli import run as module
module._draw = lambda folder: None
try:
    module.run(["hop.yaml", "--json"], standalone_mode=False)
except SystemExit as end:
    print(end.code, "cv2" in sys.modules, file=sys.stderr)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == "0 False\n"
    assert not list(only("runs").glob("frames*"))


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
@pytest.mark.parametrize("name", ["frames.jsonl", "events.jsonl", "telemetry.csv"])
def test_a_full_disk_is_explained(
    name: str, looker: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def full(parent: Path, stamp: str, mission: str) -> Path:
        folder = tmp_path / "full"
        folder.mkdir()
        (folder / name).symlink_to("/dev/full")
        return folder

    monkeypatch.setattr("cli.run.new_folder", full)
    result = run_cli("run", looker, *CAMERA)
    # The first lines of the others are written before take-off.
    assert result.code == (4 if name == "frames.jsonl" else 2)
    assert f"{name}: error: cannot write into the run folder: No space left" in result.err
    assert ("--no-frames" in result.err) == (name == "frames.jsonl")
    assert "Traceback" not in result.err
