"""Writes the camera frames that a mission read: JPEG files, and ``frames.jsonl`` about them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hal.vehicle import Frame, Intrinsics
from runner.appended_file import AppendedFile, encode, writing
from runner.run_folder import FRAMES, frame_fields, frame_file, frames_header, photo_file
from vencejo.files import write_whole

QUALITY = 90
"""Quality of the JPEGs, 0 to 100: files are a quarter smaller than at OpenCV's default of 95."""
_HINT = "make room, fly with --no-frames, or choose another --runs-dir"


def write_picture(path: Path, frame: Frame) -> None:
    """Write a frame as a JPEG. Raises UserError (``cannot-record``)."""
    import cv2  # late: runs that read no frame start without it

    with writing(path, _HINT):
        _, data = cv2.imencode(".jpg", frame.image, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))
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
        write_picture(self._folder / photo_file(vehicle, name, number), frame)


class FrameFiles:
    """Writes frames into a run folder, each once; without frames it writes nothing at all."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lines: AppendedFile | None = None
        self._last: dict[tuple[str, str], tuple[int, Intrinsics]] = {}
        """Sequence number and intrinsics of the last frame written, by vehicle and camera."""

    def write(self, vehicle: str, camera: str, frame: Frame) -> None:
        """Keep a frame, world frame. Raises UserError (``cannot-record``)."""
        last = self._last.get((vehicle, camera))
        if last is not None and last[0] == frame.sequence:
            return
        path = self._folder / frame_file(vehicle, camera, frame)
        write_picture(path, frame)
        changed = last is None or last[1] != frame.intrinsics
        self._append(frame_fields(vehicle, camera, frame, with_intrinsics=changed))
        self._last[vehicle, camera] = frame.sequence, frame.intrinsics

    def _append(self, line: dict[str, Any]) -> None:
        if self._lines is None:
            self._lines = AppendedFile(self._folder / FRAMES, _HINT)
            self._lines.append([encode(frames_header())])
        self._lines.append([encode(line)])

    def close(self) -> None:
        if self._lines is not None:
            self._lines.close()
