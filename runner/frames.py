"""Writes the camera frames that a mission read, its photos and annotated pictures, as JPEGs."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from behaviors.channel import Draw
from hal.vehicle import Frame, Intrinsics
from runner.appended_file import JsonLines, writing
from runner.run_folder import (
    FRAMES,
    PICTURES,
    frame_fields,
    frame_file,
    frames_header,
    photo_file,
    picture_fields,
    picture_file,
    pictures_header,
)
from vencejo.files import write_whole

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

QUALITY = 90
"""Quality of the JPEGs, 0 to 100: files are a quarter smaller than at OpenCV's default of 95."""
_HINT = "make room, fly with --no-frames, or choose another --runs-dir"
_EPSILON = 1e-6
"""Seconds within which two times count as equal."""


def write_picture(path: Path, image: NDArray[np.uint8]) -> None:
    """Write an image, BGR, as a JPEG. Raises UserError (``cannot-record``)."""
    import cv2  # late: runs that read no frame start without it

    with writing(path, _HINT):
        _, data = cv2.imencode(".jpg", image, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, data.data)


class PhotoFiles:
    """Writes frames that were taken under a name, each as a file of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._taken: dict[tuple[str, str], int] = {}
        """Photos by vehicle and name."""

    def write(self, vehicle: str, name: str, frame: Frame) -> None:
        """Keep a photo; the second one of a name has ``-2`` after it, and so on.

        Raises UserError (``cannot-record``).
        """
        number = self._taken[vehicle, name] = self._taken.get((vehicle, name), 0) + 1
        write_picture(self._folder / photo_file(vehicle, name, number), frame.image)


class FrameFiles:
    """Writes frames into a run folder, each once; without frames it writes nothing at all."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lines = JsonLines(folder / FRAMES, frames_header(), _HINT)
        self._last: dict[tuple[str, str], tuple[int, Intrinsics]] = {}
        """Sequence number and intrinsics of the last frame written, by vehicle and camera."""

    def write(self, vehicle: str, camera: str, frame: Frame) -> None:
        """Keep a frame, world frame. Raises UserError (``cannot-record``)."""
        last = self._last.get((vehicle, camera))
        if last is not None and last[0] == frame.sequence:
            return
        path = self._folder / frame_file(vehicle, camera, frame)
        write_picture(path, frame.image)
        changed = last is None or last[1] != frame.intrinsics
        self._lines.append(frame_fields(vehicle, camera, frame, with_intrinsics=changed))
        self._last[vehicle, camera] = frame.sequence, frame.intrinsics

    def close(self) -> None:
        self._lines.close()


class PictureFiles:
    """Writes annotated pictures into a run folder, none more often than its rate."""

    def __init__(self, folder: Path, rate: float) -> None:
        """``rate``: the most pictures of a name that are kept in a second."""
        self._folder = folder
        self._lines = JsonLines(folder / PICTURES, pictures_header(), _HINT)
        self._step = 1.0 / rate
        self._drawn: dict[tuple[str, str], tuple[int, float]] = {}
        """Number and time of the last picture, by vehicle and name."""
        self._unwritten: list[tuple[str, str, int, float, NDArray[np.uint8]]] = []
        """Vehicle, name, number, time and image of every picture drawn but not yet written."""

    @property
    def names(self) -> Sequence[tuple[str, str]]:
        """Vehicle and name of the pictures that were drawn, in the order of the first ones."""
        return tuple(self._drawn)

    def offer(self, vehicle: str, name: str, time: float, draw: Draw) -> None:
        """Draw the picture of that time, to be written later, if it is due."""
        number, last = self._drawn.get((vehicle, name), (0, -inf))
        if time - last < self._step - _EPSILON:
            return
        self._unwritten.append((vehicle, name, number + 1, time, draw()))
        self._drawn[vehicle, name] = number + 1, time

    def write(self) -> None:
        """Write what was drawn. Raises UserError (``cannot-record``)."""
        drawn, self._unwritten = self._unwritten, []
        for vehicle, name, number, time, image in drawn:
            write_picture(self._folder / picture_file(vehicle, name, number), image)
            self._lines.append(picture_fields(vehicle, name, number, time))

    def close(self) -> None:
        self._lines.close()
