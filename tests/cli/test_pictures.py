"""Annotated pictures: drawn only when they are kept, and changing nothing else of a flight."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import pytest

from runner import read_run
from tests.cli.run_cli import run_cli

Write = Callable[[str, str], str]
pytestmark = pytest.mark.usefixtures("undrawn")

BEHAVIOR = """\
from pathlib import Path

import numpy as np

from behaviors import Behavior, BehaviorParams, param

class Show(Behavior):
    '''Show two pictures in every period for a second; their blue tells how many were drawn.'''

    class Params(BehaviorParams):
        mistake: str = param("", help="what goes wrong")

    outcomes = {"done": None}

    def start(self, flight, progress=None):
        self.begin, self.drawn = flight.now, 0

    def step(self, flight):
        flight.picture(self.params.mistake or "view", self._draw)
        flight.picture("dark", lambda: np.zeros((48, 64, 3), np.uint8))
        return "done" if flight.now - self.begin >= 0.97 else None

    def _draw(self):
        if self.params.mistake == "raises":
            return 1 // 0
        if self.params.mistake == "grey":
            return np.zeros((48, 64), np.uint8)
        if self.params.mistake == "nothing":
            return None
        if self.params.mistake == "large":
            return np.zeros((20000, 2, 3), np.uint8)
        if self.params.mistake == "mirrored":
            return np.zeros((48, 64, 3), np.uint8)[:, ::-2]
        self.drawn += 1
        with Path("drawn").open("a") as log:
            log.write("x")
        picture = np.zeros((48, 64, 3), np.uint8)
        picture[:, :, 0] = min(40 * self.drawn, 255)
        return picture
"""
MISSION = """\
mission: shower
parameters: {mistake: {type: text, default: ""}}
uses: [show.py]
states:
  show: {do: show, with: {mistake: $mistake}, on: {done: over, failed: wrong}}
  over: {type: final}
  wrong: {type: final, outcome: failed}
"""


@pytest.fixture
def shower(write: Write) -> str:
    write("show.py", BEHAVIOR)
    return write("shower.yaml", MISSION)


def only(folder: str) -> Path:
    (found,) = Path(folder).iterdir()
    return found


def lines(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "pictures.jsonl").read_text().splitlines()]


def drawn() -> int:
    path = Path("drawn")
    return len(path.read_text()) if path.exists() else 0


def test_five_pictures_a_second_are_drawn_and_kept(shower: str) -> None:
    assert run_cli("run", shower).code == 0
    folder = only("runs")
    first, *kept = lines(folder)
    assert first == {"format": "vencejo.pictures", "version": 1}
    views = [line for line in kept if line["name"] == "view"]
    begin = views[0]["t"]
    assert [line["t"] - begin for line in views] == pytest.approx([0, 0.2, 0.4, 0.6, 0.8])
    assert views[0] == {
        "t": begin,
        "vehicle": "drone",
        "name": "view",
        "number": 1,
        "file": "pictures/drone/view/000001.jpg",
    }
    blue = [round(cv2.imread(str(folder / line["file"]))[:, :, 0].mean()) for line in views]
    assert blue == pytest.approx([40, 80, 120, 160, 200], abs=2)
    assert len([line for line in kept if line["name"] == "dark"]) == 5
    assert drawn() == 5
    files = [path.relative_to(folder).as_posix() for path in folder.glob("pictures/**/*.*")]
    assert sorted(files) == sorted(line["file"] for line in kept)
    read = read_run(folder).pictures
    assert [(p.path, p.vehicle, p.name, p.number, p.time) for p in read] == [
        (folder / line["file"], "drone", line["name"], line["number"], line["t"]) for line in kept
    ]


@pytest.mark.parametrize(
    ("rate", "step"), [("1", 1.0), ("2.5Hz", 0.4), ("15", 0.075), ("100 Hz", 0.025)]
)
def test_as_many_are_kept_as_are_asked_for(rate: str, step: float, shower: str) -> None:
    assert run_cli("run", shower, "--picture-rate", rate).code == 0
    times = [p.time for p in read_run(only("runs")).pictures if p.name == "view"]
    steps = [after - before for before, after in pairwise(times)]
    assert steps == pytest.approx([step] * (len(times) - 1))
    assert drawn() == len(times) == int(0.999 / step) + 1


@pytest.mark.parametrize("rate", ["0", "-5Hz", "fast", "5m", "inf", "nan"])
def test_a_rate_that_is_none_is_refused(rate: str, shower: str) -> None:
    result = run_cli("run", shower, f"--picture-rate={rate}")
    assert (result.code, result.out) == (2, "")
    assert f"'{rate}' is no frequency above 0; for instance --picture-rate 10Hz" in result.err


def test_without_frames_none_is_drawn_and_nothing_else_changes(shower: str) -> None:
    assert run_cli("run", shower, "--noise", "1", "--runs-dir", "a").code == 0
    assert drawn() == 5
    assert run_cli("run", shower, "--noise", "1", "--runs-dir", "b", "--no-frames").code == 0
    assert drawn() == 5
    rate = ("--picture-rate", "40")
    assert run_cli("run", "--again", str(only("a")), "--runs-dir", "c", *rate).code == 0
    kept, left_out, often = only("a"), only("b"), only("c")
    for name in ("events.jsonl", "telemetry.csv"):
        assert (kept / name).read_bytes() == (left_out / name).read_bytes()
        assert (kept / name).read_bytes() == (often / name).read_bytes()
    assert {path.name for path in kept.iterdir()} - {path.name for path in left_out.iterdir()} == {
        "pictures",
        "pictures.jsonl",
    }
    assert len(read_run(often).pictures) > len(read_run(kept).pictures)


@pytest.mark.parametrize(
    ("mistake", "reason"),
    [
        ("raises", "ZeroDivisionError: integer division or modulo by zero (show.py:25)"),
        (
            "grey",
            "TypeError: a picture is of uint8 and (height, width, 3), not of uint8 and (48, 64) "
            "(show.py:19)",
        ),
        (
            "large",
            "ValueError: a picture of 2 x 20000 pixels is too large: 10000 a side (show.py:19)",
        ),
        ("nothing", "TypeError: a picture is an array of numpy, not a NoneType (show.py:19)"),
        (
            "no/name",
            "ValueError: 'no/name' is no name of a picture: up to 64 letters, digits, _ and - "
            "(show.py:19)",
        ),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_a_failure_of_its_behavior(
    mistake: str, reason: str, shower: str
) -> None:
    result = run_cli("run", shower, "-p", f"mistake={mistake}", "--json")
    assert result.code == 1
    assert json.loads(result.out)["entered"][-1]["why"] == f"failed: {reason}"
    assert not list(only("runs").glob("pictures*"))


def test_every_view_of_an_array_can_be_written(shower: str) -> None:
    assert run_cli("run", shower, "-p", "mistake=mirrored").code == 0
    picture = read_run(only("runs")).pictures[0]
    assert cv2.imread(str(picture.path)).shape == (48, 32, 3)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_a_full_disk_is_explained(
    shower: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def full(parent: Path, stamp: str, mission: str) -> Path:
        folder = tmp_path / "full"
        folder.mkdir()
        (folder / "pictures.jsonl").symlink_to("/dev/full")
        return folder

    monkeypatch.setattr("cli.run.new_folder", full)
    result = run_cli("run", shower)
    assert result.code == 4
    told = "pictures.jsonl: error: cannot write into the run folder: No space left on device"
    assert told in result.err and "--no-frames" in result.err


def test_a_kill_leaves_whole_pictures_and_lines(shower: str) -> None:
    assert run_cli("run", shower).code == 0
    folder = only("runs")
    log = folder / "pictures.jsonl"
    whole = log.read_bytes()
    log.write_bytes(whole[:-5])
    (folder / "summary.json").unlink()
    run = read_run(folder)
    assert len(run.pictures) == whole.count(b"\n") - 2
    assert run.missing == (
        "the last line of pictures.jsonl is cut off",
        "summary.json is not there",
    )


@pytest.mark.slow
@pytest.mark.parametrize("mission", ["land_on_pad", "tag_lights"])
def test_shipped_missions_fly_the_same_whether_they_are_drawn_or_not(mission: str) -> None:
    assert run_cli("run", mission, "--runs-dir", "a", "--picture-rate", "40").code == 0
    assert run_cli("run", mission, "--runs-dir", "b", "--no-frames").code == 0
    for name in ("events.jsonl", "telemetry.csv"):
        assert (only("a") / name).read_bytes() == (only("b") / name).read_bytes()
    assert read_run(only("a")).pictures and not read_run(only("b")).pictures
