"""What a lens and a sensor make of a pinhole picture: distortion, motion blur, noise."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hal.sim.sensors.camera import CameraSpec
from hal.vehicle import Intrinsics
from vencejo.errors import UserError
from vencejo.seeds import generator

Pixels = NDArray[np.uint8]
Floats = NDArray[np.float32]

_ROOM = 128
"""Pixels by which the field of noise is larger than a picture, to be shifted about in."""
_WIDEST = 4.0
"""How much larger than the picture the pinhole picture behind a lens may be."""


class Optics:
    """One camera's lens and sensor. Equal seeds and names give equal noise."""

    def __init__(self, spec: CameraSpec, seed: int, names: tuple[str, ...]) -> None:
        """Raises UserError for a distortion that bends the picture's edge out of all measure."""
        self.pinhole: Intrinsics = spec.intrinsics
        """What the renderer is to draw."""
        self._maps: tuple[Floats, Floats] | None = None
        if any(spec.distortion):
            self.pinhole, self._maps = _behind(spec.intrinsics)
        self._seed = seed
        self._names = names
        self._noise = _field(spec, seed, names) if spec.noise else None

    def develop(self, pictures: Sequence[Pixels], sequence: int) -> Pixels:
        """The camera's picture of that number, from those of one exposure; read-only."""
        image = pictures[0] if len(pictures) == 1 else _mean(pictures)
        if self._maps is not None:
            # With four channels and float maps it takes half the time.
            bent = cv2.remap(
                cv2.cvtColor(image, cv2.COLOR_BGR2BGRA),
                *self._maps,
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )
            image = np.asarray(cv2.cvtColor(bent, cv2.COLOR_BGRA2BGR), np.uint8)
        if self._noise is not None:
            draw = generator(self._seed, *self._names, str(sequence))
            down, right = draw.randrange(_ROOM), draw.randrange(_ROOM)
            height, width = image.shape[:2]
            part = np.s_[down : down + height, right : right + width]
            brighter, darker = (half[part] for half in self._noise)
            image = np.asarray(cv2.subtract(cv2.add(image, brighter), darker), np.uint8)
        image.flags.writeable = False
        return image


def _mean(pictures: Sequence[Pixels]) -> Pixels:
    total = np.zeros(pictures[0].shape, np.float32)
    for picture in pictures:
        cv2.accumulate(picture, total)
    return np.asarray(cv2.convertScaleAbs(total, alpha=1 / len(pictures)), np.uint8)


def _behind(lens: Intrinsics) -> tuple[Intrinsics, tuple[Floats, Floats]]:
    """The pinhole camera that sees all that a distorted one does, and the way from one to other."""
    matrix = np.array([[lens.fx, 0, lens.cx], [0, lens.fy, lens.cy], [0, 0, 1.0]])
    x, y = np.meshgrid(np.arange(lens.width), np.arange(lens.height))
    pixels = np.stack([x, y], -1).reshape(-1, 1, 2).astype(np.float64)
    # Without its criteria OpenCV stops after five rounds, up to a pixel off.
    ends = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-8)
    straight = cv2.undistortPoints(
        pixels, matrix, np.array(lens.distortion), R=None, P=None, criteria=ends
    )
    rays = np.asarray(straight).reshape(lens.height, lens.width, 2)
    astray = max(
        float(np.abs(_bent(row, matrix, lens.distortion) - pixel).max())
        for row, pixel in zip(rays, pixels.reshape(rays.shape), strict=True)
    )
    low, high = rays.reshape(-1, 2).min(0), rays.reshape(-1, 2).max(0)
    left, top = np.floor(low * (lens.fx, lens.fy)).astype(int) - 1
    right, bottom = np.ceil(high * (lens.fx, lens.fy)).astype(int) + 1
    width, height = int(right - left) + 1, int(bottom - top) + 1
    if astray > 0.05 or width > _WIDEST * lens.width or height > _WIDEST * lens.height:
        raise UserError(
            "bad-setting",
            f"a distortion of {', '.join(f'{k:g}' for k in lens.distortion)} bends the edge of "
            "the picture too far",
            hint="it was measured for another field of view, perhaps",
        )
    wide = Intrinsics(width, height, lens.fx, lens.fy, float(-left), float(-top))
    places = (rays * (lens.fx, lens.fy) - (left, top)).astype(np.float32)
    return wide, (places[..., 0].copy(), places[..., 1].copy())


def _bent(
    rays: NDArray[Any], matrix: NDArray[np.float64], distortion: tuple[float, ...]
) -> NDArray[np.float64]:
    """Where a distorted camera sees rays (n, 2), pixels."""
    # It makes 15 derivatives for each: of a whole picture at once they fill gigabytes.
    points = np.concatenate([rays, np.ones((len(rays), 1))], 1)
    seen = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix, np.array(distortion))[0]
    return np.asarray(seen, np.float64).reshape(-1, 2)


def _field(spec: CameraSpec, seed: int, names: tuple[str, ...]) -> tuple[Pixels, Pixels]:
    """Normal noise, larger than a picture: what to add, and what to take away.

    Drawn once, since drawing it anew for each picture takes milliseconds.
    """
    shape = spec.height + _ROOM, spec.width + _ROOM, 3
    count = shape[0] * shape[1] * shape[2]
    drawn = np.frombuffer(generator(seed, *names, "noise").randbytes(2 * count), np.uint16)
    normal = NormalDist(0.0, spec.noise)
    steps = 4096
    table = np.rint([normal.inv_cdf((k + 0.5) / steps) for k in range(steps)])
    noise = np.clip(table, -255, 255).astype(np.int16)[drawn % steps].reshape(shape)
    return np.maximum(noise, 0).astype(np.uint8), np.maximum(-noise, 0).astype(np.uint8)
