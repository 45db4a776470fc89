"""Videos of runs, and where a run says that its pictures are."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import cv2
import pytest

from cli.live_view import LiveView
from cli.run import _PictureNews
from runner import missions
from runner.loop import fly
from runner.plan import Plan
from runner.preparation import prepare
from runner.recorder import Recorder
from tests.cli.run_cli import run_cli
from tests.cli.terminal import Terminal
from tests.cli.test_output import on_a_terminal

Write = Callable[[str, str], str]
pytestmark = pytest.mark.usefixtures("undrawn")

BEHAVIOR = """\
import numpy as np

from behaviors import Behavior

class Show(Behavior):
    '''Show two pictures, and read the camera, in every period for a second.'''

    outcomes = {"done": None}
    requires = ("camera.front",)

    def start(self, flight, progress=None):
        self.begin = flight.now
        self.camera = flight.camera("front")

    def step(self, flight):
        self.camera.latest()
        flight.picture("bright", lambda: np.full((48, 64, 3), 200, np.uint8))
        flight.picture("dark", lambda: np.zeros((48, 64, 3), np.uint8))
        return "done" if flight.now - self.begin >= 0.97 else None
"""
MISSION = """\
mission: shower
uses: [show.py]
states:
  show: {do: show, on: {done: over}}
  over: {type: final}
"""
CAMERA = ("--camera", "front:64x48@20")


@pytest.fixture
def shower(write: Write) -> str:
    write("show.py", BEHAVIOR)
    return write("shower.yaml", MISSION)


@pytest.fixture
def folder(shower: str) -> Path:
    """A run with pictures and frames."""
    assert run_cli("run", shower, *CAMERA).code == 0
    return only("runs")


def only(folder: str) -> Path:
    (found,) = Path(folder).iterdir()
    return found


def length(file: Path | str) -> tuple[int, float]:
    """The number of images of a video, counted, and their rate."""
    video = cv2.VideoCapture(str(file))
    images = 0
    while video.read()[0]:
        images += 1
    return images, video.get(cv2.CAP_PROP_FPS)


def test_a_run_makes_its_videos_and_says_where_everything_is(shower: str) -> None:
    result = run_cli("run", shower, *CAMERA, "--video")
    folder = only("runs")
    assert (result.code, result.err) == (0, "")
    assert result.out.splitlines()[-5:] == [
        f"pictures: {folder}/pictures/drone/bright",
        f"pictures: {folder}/pictures/drone/dark",
        f"video: {folder}/pictures/drone/bright.webm",
        f"video: {folder}/pictures/drone/dark.webm",
        f"run folder: {folder}",
    ]
    assert length(folder / "pictures/drone/bright.webm") == (5, 5.0)
    assert not list(folder.glob("frames/**/*.webm"))


def test_a_flight_says_where_its_pictures_are_while_it_goes_on(shower: str) -> None:
    out = run_cli("run", shower, *CAMERA).out
    folder = only("runs")
    line = f"            pictures: {folder}/pictures/drone/bright\n"
    assert out.count(line) == 1
    assert out.index("→ show") < out.index(line) < out.index("ended in 'done'")


def test_the_live_view_says_so_too(shower: str) -> None:
    terminal = Terminal(100, 30)
    prepared = prepare(missions.find(shower))
    made: list[Recorder] = []

    def record() -> Recorder:
        made.append(Recorder(Path("run")))
        return made[0]

    Path("run").mkdir()
    camera = {"front": {"width": 64, "height": 48, "rate": 20.0}}
    plan = Plan.alone(prepared, {}, settings={"cameras": camera})
    with LiveView(terminal.console, None, 1.0) as view:
        fly(plan, record, [view, _PictureNews(made, view.note)])
    assert terminal.row_of("pictures: ") == terminal.row_of("pictures/drone/bright")
    assert terminal.row_of("pictures/drone/dark") > terminal.row_of("pictures/drone/bright")


@pytest.mark.slow
def test_a_terminal_shows_where_they_are(shower: str, tmp_path: Path) -> None:
    code, text = on_a_terminal(f"run {shower} --speed 1 --camera front:64x48@20", tmp_path)
    assert code == 0
    assert re.search(r"pictures: runs/\S+/pictures/drone/bright", text)


def test_json_alone_is_printed(shower: str) -> None:
    result = run_cli("run", shower, *CAMERA, "--video", "--json")
    assert json.loads(result.out)["outcome"] == "done"
    assert (only("runs") / "pictures/drone/dark.webm").exists()


def test_videos_of_a_run_are_made_afterwards(folder: Path) -> None:
    result = run_cli("video", str(folder))
    files = [folder / f"pictures/drone/{name}.webm" for name in ("bright", "dark")]
    assert (result.code, result.err) == (0, "")
    assert result.out.splitlines() == [str(file) for file in files]
    assert [length(file) for file in files] == [(5, 5.0)] * 2


@pytest.mark.parametrize(
    ("chosen", "made", "images"),
    [
        (["--picture", "dark"], "pictures/drone/dark.webm", (5, 5.0)),
        (["--camera", "front"], "frames/drone/front.webm", (21, 20.0)),
        (["--camera", "front", "--vehicle", "drone"], "frames/drone/front.webm", (21, 20.0)),
    ],
)
def test_one_of_them_is_chosen(
    chosen: list[str], made: str, images: tuple[int, float], folder: Path
) -> None:
    result = run_cli("video", str(folder), *chosen)
    assert (result.code, result.out) == (0, f"{folder / made}\n")
    assert length(folder / made) == images
    assert [path.relative_to(folder).as_posix() for path in folder.glob("**/*.webm")] == [made]


def test_one_video_goes_where_it_is_wanted(folder: Path) -> None:
    result = run_cli("video", str(folder), "--picture", "dark", "-o", "new/dark.webm")
    assert (result.code, result.out) == (0, "new/dark.webm\n")
    assert length("new/dark.webm") == (5, 5.0)


def test_a_run_without_annotated_pictures_shows_its_cameras(folder: Path) -> None:
    (folder / "pictures.jsonl").unlink()
    assert run_cli("video", str(folder)).out == f"{folder}/frames/drone/front.webm\n"


def test_a_killed_run_has_videos_of_what_there_is(folder: Path) -> None:
    log = folder / "pictures.jsonl"
    log.write_bytes(log.read_bytes()[:-5])
    (folder / "summary.json").unlink()
    (folder / "pictures/drone/bright/000002.jpg").unlink()
    assert run_cli("video", str(folder)).code == 0
    assert length(folder / "pictures/drone/bright.webm") == (5, 5.0)
    assert length(folder / "pictures/drone/dark.webm") == (4, 5.0)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            ["--picture", "drak"],
            "there are no pictures of the picture 'drak' in this run [no-video]\n"
            "  hint: did you mean 'dark'?",
        ),
        (["--camera", "ventral"], "hint: --picture bright, --picture dark, --camera front"),
        (["--vehicle", "dorne"], "no pictures of the vehicle 'dorne' in this run [no-video]\n"),
        (["--camera", "front", "--picture", "dark"], "are of two videos: give one [bad-usage]"),
        (["-o", "two.webm"], "there are 2 videos, and one name for them [bad-usage]\n"),
        (["-o", "view.mp4"], "'view.mp4' does not end in .webm, the one format of videos"),
    ],
)
def test_what_cannot_be_made_is_explained(given: list[str], told: str, folder: Path) -> None:
    result = run_cli("video", str(folder), *given)
    assert (result.code, result.out) == (2, "")
    assert told in result.err
    assert not list(Path().glob("**/*.webm"))


def test_a_folder_that_is_no_run_is_told() -> None:
    result = run_cli("video", "nowhere")
    assert result.code == 2 and "'nowhere' is no run folder" in result.err


def test_a_run_without_pictures_has_no_video(hop: str) -> None:
    result = run_cli("run", hop, "--video")
    assert result.code == 0
    assert result.err == (
        f"no video: {only('runs')}: error: there are no pictures in this run [no-video]\n"
        "  hint: behaviours that read a camera leave some, unless it was flown with --no-frames\n"
    )
    assert "pictures:" not in result.out
    refused = run_cli("run", hop, "--video", "--no-frames")
    assert refused.code == 2
    assert "--video is made of the pictures that --no-frames leaves out" in refused.err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_a_full_disk_behind_a_video_is_told(folder: Path) -> None:
    Path("full.webm").symlink_to("/dev/full")
    result = run_cli("video", str(folder), "--picture", "dark", "-o", "full.webm")
    assert result.code == 4
    assert "full.webm: error: this video cannot be written: No space left on device" in result.err


def test_a_stop_leaves_no_half_video(
    shower: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("runner.video._fitted", stopped)
    assert run_cli("video", str(folder)).code == 130
    assert not list(folder.glob("**/*.webm*"))
