"""Videos of a run: what its cameras saw, or its behaviours showed, at the true times.

They are VP8 in WebM, which browsers play and the wheels of OpenCV write. H.264 these do not have,
and the MPEG-4 that they do have no browser plays.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import groupby, pairwise
from math import ceil
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Literal, NamedTuple

import cv2
import numpy as np

from hal.scene.arrays import Pixels
from runner.run_folder import Run
from vencejo.errors import UserError, Where, cannot_write
from vencejo.files import write_whole

ENDING = ".webm"
_LEAST_RATE, _MOST_RATE = 5.0, 30.0
"""Images a second that a video has."""
_LEAST_SIDE = 16
"""Pixels: players show no smaller video."""


class Still(NamedTuple):
    """One picture."""

    time: float
    """Seconds of the vehicle's clock."""
    path: Path


@dataclass(frozen=True)
class Reel:
    """The pictures of one camera, or the annotated ones of one name, of one vehicle."""

    kind: Literal["camera", "picture"]
    vehicle: str
    name: str
    stills: tuple[Still, ...]
    """In the order of their times."""

    @property
    def file(self) -> Path:
        """Where its video belongs: beside the folder of its pictures."""
        return self.stills[0].path.parent.with_suffix(ENDING)


def reels_of(run: Run) -> list[Reel]:
    """All reels of a run, of annotated pictures first; pictures that are not there are left out."""
    shown = [("picture", p.vehicle, p.name, Still(p.time, p.path)) for p in run.pictures]
    seen = [("camera", f.vehicle, f.camera, Still(f.time, f.path)) for f in run.frames]
    whole = sorted(each for each in (*shown, *seen) if each[3].path.exists())
    reels = [
        Reel("camera" if kind == "camera" else "picture", vehicle, name, tuple(s for *_, s in each))
        for (kind, vehicle, name), each in groupby(whole, lambda each: each[:3])
    ]
    return sorted(reels, key=lambda reel: reel.kind, reverse=True)


def film(reel: Reel, file: Path) -> None:
    """Write a video of a reel: each picture from its time on until the next one.

    Raises UserError: ``no-video`` where no picture can be read, ``cannot-write``.
    """
    rate = rate_of(reel.stills)
    images = _images(reel.stills, rate)
    first = next(images, None)
    if first is None:
        message = f"none of the pictures of '{reel.name}' can be read"
        raise UserError("no-video", message, Where(str(reel.stills[0].path.parent)))
    with TemporaryDirectory() as folder:
        made = Path(folder) / f"video{ENDING}"
        _encode(first, images, made, rate)
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            write_whole(file, made.read_bytes())
        except OSError as error:
            message = "this video cannot be written"
            raise cannot_write(error, "cannot-write", message, Where(str(file))) from None


def rate_of(stills: Sequence[Still]) -> float:
    """Images a second at which a video shows these pictures when they were taken, nearly."""
    steps = [after.time - before.time for before, after in pairwise(stills)]
    step = median(step for step in steps if step > 0) if any(step > 0 for step in steps) else 1.0
    return min(_MOST_RATE, max(_LEAST_RATE, round(1 / step, 3)))


def repeats(times: Sequence[float], rate: float) -> list[int]:
    """How many images of a video each picture is shown in; none where the next one is as near.

    The k-th image, of the time k/rate after the first picture, is the last picture that was taken
    until half an image later. The last picture is shown once.
    """
    begins = [max(0, ceil((time - times[0]) * rate - 0.5)) for time in times]
    return [after - before for before, after in pairwise((*begins, begins[-1] + 1))]


def _images(stills: Sequence[Still], rate: float) -> Iterator[tuple[Pixels, int]]:
    """The pictures that can be read, each with the number of images it is shown in."""
    skipped = 0
    for still, shown in zip(stills, repeats([s.time for s in stills], rate), strict=True):
        if not shown:
            continue
        image = cv2.imread(str(still.path))
        if image is None:
            skipped += shown
            continue
        yield np.asarray(image, np.uint8), shown + skipped
        skipped = 0


def _encode(
    first: tuple[Pixels, int], rest: Iterator[tuple[Pixels, int]], file: Path, rate: float
) -> None:
    """Encode images, all in the size of the first. Raises UserError (``cannot-write``)."""
    height, width = first[0].shape[:2]
    size = tuple(max(_LEAST_SIDE, side + side % 2) for side in (width, height))
    code = cv2.VideoWriter.fourcc(*"VP80")
    written = 0
    with _quiet():
        writer = cv2.VideoWriter(str(file), cv2.CAP_FFMPEG, code, rate, size)
        for image, shown in (first, *rest):
            fitted = _fitted(image, size)
            for _ in range(shown):
                writer.write(fitted)
            written += shown
        writer.release()
        whole = _length(file) == written
    if not whole:
        message = "the video could not be made: no room for it, or an OpenCV without VP8"
        raise UserError("cannot-write", message, Where(str(file)))


def _fitted(image: Pixels, size: Sequence[int]) -> Pixels:
    """An image in a size, as large as it can be, on black."""
    height, width = image.shape[:2]
    if (width, height) == tuple(size):
        return image
    scale = min(size[0] / width, size[1] / height)
    if scale < 1 or scale >= 2:
        across, down = max(1, round(width * scale)), max(1, round(height * scale))
        image = np.asarray(cv2.resize(image, (across, down), interpolation=cv2.INTER_AREA))
    fitted = np.zeros((size[1], size[0], 3), np.uint8)
    fitted[: image.shape[0], : image.shape[1]] = image
    return fitted


def _length(file: Path) -> int:
    """The number of images of a video; 0 for none that can be read."""
    video = cv2.VideoCapture(str(file))
    length = round(video.get(cv2.CAP_PROP_FRAME_COUNT)) if video.isOpened() else 0
    video.release()
    return length


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what OpenCV's own code writes about every video out of standard error."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
