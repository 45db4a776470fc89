"""Distortion, motion blur and noise: what a lens and an image sensor add to a pinhole image."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist

import cv2
import numpy as np

from hal.scene.arrays import Float32s, Pixels
from hal.scene.distortion import pixels_of, rays_of
from hal.sim.sensors.camera_spec import CameraSpec
from hal.vehicle import Intrinsics
from vencejo.errors import UserError
from vencejo.seeds import generator

_SHIFTS = 128
"""Pixels by which the noise is larger than an image, along each axis: it is shifted by chance."""
_WIDEST = 4.0
"""Largest ratio of the pinhole image's width or height to the distorted image's."""
_TOLERANCE = 0.05
"""Pixels by which the inverse of a distortion may miss."""


class Lens:
    """One camera's lens and image sensor. Equal seeds and names give equal noise."""

    def __init__(self, spec: CameraSpec, seed: int, names: tuple[str, ...]) -> None:
        """``names`` name the random generator of the noise, beside the run's seed.

        Raises UserError (``bad-setting``) for a distortion that cannot be inverted in the image.
        """
        self.pinhole: Intrinsics = spec.intrinsics
        """The camera, without distortion, that the renderer is to render."""
        self._maps: tuple[Float32s, Float32s] | None = None
        if any(spec.distortion):
            self.pinhole, self._maps = _undistorted(spec.intrinsics)
        self._seed = seed
        self._names = names
        self._noise = _noise_masks(spec, seed, names) if spec.noise else None

    def develop(self, images: Sequence[Pixels], sequence: int) -> Pixels:
        """The camera's image of that number, from the pinhole images of one exposure; read-only."""
        image = images[0] if len(images) == 1 else _mean(images)
        if self._maps is not None:
            # With four channels and float maps it takes half the time.
            distorted = cv2.remap(
                cv2.cvtColor(image, cv2.COLOR_BGR2BGRA),
                *self._maps,
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )
            image = np.asarray(cv2.cvtColor(distorted, cv2.COLOR_BGRA2BGR), np.uint8)
        if self._noise is not None:
            draw = generator(self._seed, *self._names, str(sequence))
            down, right = draw.randrange(_SHIFTS), draw.randrange(_SHIFTS)
            height, width = image.shape[:2]
            part = np.s_[down : down + height, right : right + width]
            brighter, darker = (mask[part] for mask in self._noise)
            image = np.asarray(cv2.subtract(cv2.add(image, brighter), darker), np.uint8)
        image.flags.writeable = False
        return image


def _mean(images: Sequence[Pixels]) -> Pixels:
    total = np.zeros(images[0].shape, np.float32)
    for image in images:
        cv2.accumulate(image, total)
    return np.asarray(cv2.convertScaleAbs(total, alpha=1 / len(images)), np.uint8)


def _undistorted(lens: Intrinsics) -> tuple[Intrinsics, tuple[Float32s, Float32s]]:
    """A pinhole camera that sees all that a distorted one does, and the maps between them.

    The maps (for ``cv2.remap``) give x and y in the pinhole image for each pixel of the distorted
    one.
    """
    x, y = np.meshgrid(np.arange(lens.width), np.arange(lens.height))
    pixels = np.stack([x, y], -1).reshape(-1, 2).astype(np.float64)
    rays = rays_of(pixels, lens).reshape(lens.height, lens.width, 2)
    error = max(
        float(np.abs(pixels_of(row, lens) - pixel).max())
        for row, pixel in zip(rays, pixels.reshape(rays.shape), strict=True)
    )
    low, high = rays.reshape(-1, 2).min(0), rays.reshape(-1, 2).max(0)
    left, top = np.floor(low * (lens.fx, lens.fy)).astype(int) - 1
    right, bottom = np.ceil(high * (lens.fx, lens.fy)).astype(int) + 1
    width, height = int(right - left) + 1, int(bottom - top) + 1
    too_large = width > _WIDEST * lens.width or height > _WIDEST * lens.height
    if error > _TOLERANCE or too_large:
        raise UserError(
            "bad-setting",
            f"a distortion of {', '.join(f'{k:g}' for k in lens.distortion)} bends the edge of "
            "the picture too far",
            hint="it was measured for another field of view, perhaps",
        )
    pinhole = Intrinsics(width, height, lens.fx, lens.fy, float(-left), float(-top))
    places = (rays * (lens.fx, lens.fy) - (left, top)).astype(np.float32)
    return pinhole, (places[..., 0].copy(), places[..., 1].copy())


def _noise_masks(spec: CameraSpec, seed: int, names: tuple[str, ...]) -> tuple[Pixels, Pixels]:
    """Normal noise, larger than an image: what to add and what to subtract, grey levels.

    Drawn once and shifted for each image, since to draw it anew takes milliseconds.
    """
    shape = spec.height + _SHIFTS, spec.width + _SHIFTS, 3
    count = shape[0] * shape[1] * shape[2]
    drawn = np.frombuffer(generator(seed, *names, "noise").randbytes(2 * count), np.uint16)
    normal = NormalDist(0.0, spec.noise)
    steps = 4096
    table = np.rint([normal.inv_cdf((k + 0.5) / steps) for k in range(steps)])
    noise = np.clip(table, -255, 255).astype(np.int16)[drawn % steps].reshape(shape)
    return np.maximum(noise, 0).astype(np.uint8), np.maximum(-noise, 0).astype(np.uint8)
