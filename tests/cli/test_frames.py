"""Frames that behaviours read are kept, once each, and change nothing else."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from behaviors import Pilot
from cli import missions
from cli.appending import AppendedFile
from cli.flight import Plan, fly
from cli.frames import FrameFiles
from cli.prepare import prepare
from cli.recorder import Recorder
from fsm import parse_parameters
from fsm.engine.instance import Record
from hal.vehicle import Frame, Intrinsics
from tests.cli.run_cli import run_cli
from vencejo.errors import UserError
from vencejo.geometry import Point

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
LENS = Intrinsics(64, 48, 50.0, 50.0, 31.5, 23.5, ())
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


def frame(sequence: int, lens: Intrinsics = LENS) -> Frame:
    image = np.full((48, 64, 3), 10 * sequence, np.uint8)
    return Frame(image, sequence, sequence / 20, lens, Point(1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0))


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


def test_intrinsics_are_told_once_by_camera_and_when_they_change(tmp_path: Path) -> None:
    wide = Intrinsics(64, 48, 30.0, 30.0, 31.5, 23.5, ())
    files = FrameFiles(tmp_path)
    files.write("drone", "front", frame(1))
    files.write("drone", "ventral", frame(1))
    files.write("cat", "front", frame(1))
    files.write("drone", "front", frame(1))
    files.write("drone", "front", frame(2))
    files.write("drone", "front", frame(4, wide))
    files.write("drone", "front", frame(5, wide))
    files.close()
    told = [
        (line["vehicle"], line["camera"], line["sequence"], line.get("intrinsics", {}).get("fx"))
        for line in lines(tmp_path)[1:]
    ]
    assert told == [
        ("drone", "front", 1, 50.0),
        ("drone", "ventral", 1, 50.0),
        ("cat", "front", 1, 50.0),
        ("drone", "front", 2, None),
        ("drone", "front", 4, 30.0),
        ("drone", "front", 5, None),
    ]


def test_what_is_written_is_whole_before_the_run_ends(tmp_path: Path) -> None:
    files = FrameFiles(tmp_path)
    files.write("drone", "front", frame(7))
    line = lines(tmp_path)[-1]  # not closed: as if it had been killed here
    files.close()
    picture = cv2.imread(str(tmp_path / line["file"]))
    assert np.abs(picture.astype(int) - 70).max() <= 2
    assert [path.name for path in (tmp_path / "frames/drone/front").iterdir()] == ["000007.jpg"]


def test_a_kill_while_a_picture_is_written_leaves_no_line_and_no_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(path: Path, data: bytes) -> int:
        raise KeyboardInterrupt

    files = FrameFiles(tmp_path)
    files.write("drone", "front", frame(1))
    monkeypatch.setattr(Path, "write_bytes", killed)
    with pytest.raises(KeyboardInterrupt):
        files.write("drone", "front", frame(2))
    files.close()
    assert [line["sequence"] for line in lines(tmp_path)[1:]] == [1]
    assert [path.name for path in tmp_path.glob("frames/**/*.jpg")] == ["000001.jpg"]


def test_a_folder_that_cannot_be_written_is_explained(tmp_path: Path) -> None:
    (tmp_path / "frames").write_text("in the way")
    with pytest.raises(UserError) as caught:
        FrameFiles(tmp_path).write("drone", "front", frame(1))
    assert str(caught.value) == (
        f"{tmp_path}/frames/drone/front/000001.jpg: error: cannot write into the run folder: "
        "Not a directory [cannot-record]\n"
        "  hint: make room, fly with --no-frames, or choose another --runs-dir"
    )


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
    assert result.code == 2
    assert f"{name}: error: cannot write into the run folder: No space left" in result.err
    assert ("--no-frames" in result.err) == (name == "frames.jsonl")
    assert "Traceback" not in result.err


def test_a_flight_that_cannot_be_recorded_any_more_lands_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[float, bool]] = []

    class Watch:
        def show(self, pilot: Pilot, records: Sequence[Record]) -> None:
            here = pilot.vehicle.observe()
            seen.append((here.time, here.flying))

    def full_after_3_s(self: Recorder, pilot: Pilot) -> list[Record]:
        if pilot.channel.now > 3:
            raise UserError("cannot-record", "no room")
        return taken(self, pilot)

    taken = Recorder.take
    monkeypatch.setattr(Recorder, "take", full_after_3_s)
    prepared = prepare(missions.find("first_flight"))
    plan = Plan(prepared, parse_parameters(prepared.graph, {}))
    with pytest.raises(UserError, match="no room"):
        fly(plan, lambda: Recorder(tmp_path), [Watch()])
    assert seen[0][0] < 3 < seen[-1][0] < 12
    assert any(flying for time, flying in seen if time > 3)
    assert not seen[-1][1]


def test_lines_are_on_their_way_at_once(tmp_path: Path) -> None:
    file = AppendedFile(tmp_path / "log")
    file.append(["a", "b"])
    assert (tmp_path / "log").read_text() == "a\nb\n"
    file.close()
    file.close()
