"""The files of frames, and what becomes of a flight whose files cannot be written."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from behaviors import Pilot
from fsm import parse_parameters
from fsm.engine.instance import Record
from hal.vehicle import Frame, Intrinsics
from runner import missions
from runner.appended_file import AppendedFile
from runner.frames import FrameFiles
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from vencejo.errors import UserError
from vencejo.geometry import Point

LENS = Intrinsics(64, 48, 50.0, 50.0, 31.5, 23.5, ())


def lines(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "frames.jsonl").read_text().splitlines()]


def frame(sequence: int, lens: Intrinsics = LENS) -> Frame:
    image = np.full((48, 64, 3), 10 * sequence, np.uint8)
    return Frame(image, sequence, sequence / 20, lens, Point(1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0))


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
    plan = Plan.alone(prepared, parse_parameters(prepared.graph, {}))
    summary = fly(plan, lambda: Recorder(tmp_path), [Watch()])
    assert (summary.unrecorded, summary.exit_code) == ("error: no room [cannot-record]", 4)
    assert seen[0][0] < 3 < seen[-1][0] < 12
    assert any(flying for time, flying in seen if time > 3)
    assert not seen[-1][1]


def test_lines_are_on_their_way_at_once(tmp_path: Path) -> None:
    file = AppendedFile(tmp_path / "log")
    file.append(["a", "b"])
    assert (tmp_path / "log").read_text() == "a\nb\n"
    file.close()
    file.close()
