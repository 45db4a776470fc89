"""Videos: every picture at its time, decoded back image by image."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest

from hal.scene.arrays import Pixels
from runner.video import Reel, Still, film, rate_of, repeats
from vencejo.errors import UserError


def shade(number: int) -> int:
    """The grey of the picture of that number."""
    return 20 + 20 * number


def reel(
    folder: Path, times: Sequence[float], sizes: Sequence[tuple[int, int]] = ((48, 64),)
) -> Reel:
    """Pictures of one grey each, whose sizes go round."""
    stills = []
    for number, time in enumerate(times):
        path = folder / f"{number:06d}.jpg"
        image = np.full((*sizes[number % len(sizes)], 3), shade(number), np.uint8)
        assert cv2.imwrite(str(path), image)
        stills.append(Still(time, path))
    return Reel("picture", "drone", "view", tuple(stills))


def decoded(file: Path) -> tuple[list[Pixels], float]:
    """All images of a video, and its rate."""
    video = cv2.VideoCapture(str(file))
    images = []
    while True:
        there, image = video.read()
        if not there:
            return images, video.get(cv2.CAP_PROP_FPS)
        images.append(np.asarray(image, np.uint8))


def numbers(images: Sequence[Pixels]) -> list[int]:
    """The numbers of the pictures that the images of a video show."""
    return [round((float(image.mean()) - 20) / 20) for image in images]


def test_every_picture_is_shown_from_its_time_on(tmp_path: Path) -> None:
    file = tmp_path / "videos" / "view.webm"
    film(reel(tmp_path, [3.0, 3.2, 3.4, 3.6, 4.2, 4.4]), file)
    images, rate = decoded(file)
    assert rate == 5.0
    assert numbers(images) == [0, 1, 2, 3, 3, 3, 4, 5]
    assert {image.shape for image in images} == {(48, 64, 3)}
    assert [path.name for path in file.parent.iterdir()] == ["view.webm"]


def test_it_is_webm_with_vp8(tmp_path: Path) -> None:
    file = tmp_path / "view.webm"
    film(reel(tmp_path, [0.0, 0.2]), file)
    data = file.read_bytes()
    assert data.startswith(b"\x1a\x45\xdf\xa3")  # EBML
    assert b"webm" in data[:64] and b"V_VP8" in data


def test_the_rate_is_that_of_the_pictures() -> None:
    def at(*times: float) -> list[Still]:
        return [Still(time, Path()) for time in times]

    assert rate_of(at(0.0, 0.05, 0.1, 0.15, 9.0)) == 20.0
    assert rate_of(at(0.0, 1.0, 2.0)) == 5.0
    assert rate_of(at(0.0, 0.001, 0.002)) == 30.0
    assert rate_of(at(0.0)) == rate_of(at(1.0, 1.0)) == 5.0


def test_an_image_shows_the_last_picture_until_half_an_image_later() -> None:
    assert repeats([0.0, 0.1, 0.2], 10.0) == [1, 1, 1]
    assert repeats([5.0, 5.12, 5.18, 5.3], 10.0) == [1, 1, 1, 1]
    assert repeats([0.0, 0.01, 0.02, 0.1], 10.0) == [0, 0, 1, 1]
    assert repeats([0.0, 1.0], 10.0) == [10, 1]
    assert repeats([7.0], 10.0) == [1]


@pytest.mark.parametrize("size", [(48, 64), (49, 65), (1, 1), (16, 16), (3, 200)])
def test_every_size_of_picture_can_be_shown(size: tuple[int, int], tmp_path: Path) -> None:
    file = tmp_path / "view.webm"
    film(reel(tmp_path, [0.0, 0.2], [size]), file)
    images, _ = decoded(file)
    assert len(images) == 2
    height, width = images[0].shape[:2]
    assert height >= max(16, size[0]) and width >= max(16, size[1])
    assert height % 2 == width % 2 == 0


def test_pictures_of_other_sizes_are_fitted_into_the_first(tmp_path: Path) -> None:
    file = tmp_path / "view.webm"
    film(reel(tmp_path, [0.0, 0.2, 0.4], [(48, 64), (96, 256), (12, 16)]), file)
    _, wide, small = decoded(file)[0]
    assert wide[:20].mean() == pytest.approx(shade(1), abs=4) and wide[28:].mean() < 8
    assert small.mean() == pytest.approx(shade(2), abs=4)


def test_pictures_that_cannot_be_read_are_left_out(tmp_path: Path) -> None:
    made = reel(tmp_path, [0.0, 0.2, 0.4])
    made.stills[1].path.write_bytes(b"no picture")
    film(made, tmp_path / "view.webm")
    assert numbers(decoded(tmp_path / "view.webm")[0]) == [0, 2, 2]
    for still in made.stills:
        still.path.write_bytes(b"")
    with pytest.raises(UserError, match="none of the pictures of 'view' can be read"):
        film(made, tmp_path / "other.webm")
    assert not (tmp_path / "other.webm").exists()


def test_a_video_that_cannot_be_written_is_explained(tmp_path: Path) -> None:
    made = reel(tmp_path, [0.0, 0.2])
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="this video cannot be written"):
        film(made, tmp_path / "file" / "view.webm")


NO_ROOM = """
import resource, sys
from pathlib import Path
from runner.video import film
from tests.runner.test_video import reel
from vencejo.errors import UserError

folder = Path(sys.argv[1])
made = reel(folder, [0.2 * number for number in range(11)], [(240, 320)])
resource.setrlimit(resource.RLIMIT_FSIZE, (300, 300))  # the files of pictures are there already
try:
    film(made, folder / "view.webm")
except UserError as error:
    print(error)
"""


def test_a_video_for_which_there_is_no_room_is_explained(tmp_path: Path) -> None:
    command = [sys.executable, "-c", NO_ROOM, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "error: the video could not be made: no room for it" in done.stdout
    assert done.stderr == ""
    assert not (tmp_path / "view.webm").exists()


def test_opencv_says_nothing_and_standard_error_is_there_afterwards(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    film(reel(tmp_path, [0.0, 0.2]), tmp_path / "view.webm")
    os.write(2, b"still there")
    assert capfd.readouterr() == ("", "still there")
