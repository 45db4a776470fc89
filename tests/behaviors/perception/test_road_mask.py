"""Roads in pictures: in sun and shade, and through noise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from behaviors.perception.color import ColorRange, read_color
from behaviors.perception.road_mask import road_mask, shaded
from hal.scene.arrays import Pixels

ASPHALT, GRASS = (75, 70, 70), (60, 130, 85)
INSIDE = np.s_[:, 138:182]
OUTSIDE = np.s_[:, :118]


def picture() -> Pixels:
    """A road from top to bottom on grass, with a shadow across both."""
    image = np.empty((240, 320, 3), np.uint8)
    image[:] = GRASS
    image[:, 130:190] = ASPHALT
    image[100:160] = (image[100:160] * 0.55).astype(np.uint8)
    return image


def gaussian(image: Pixels, random: np.random.Generator) -> Pixels:
    """A tenth of the grey levels in each pixel."""
    return np.clip(image + random.normal(0, 25, image.shape), 0, 255).astype(np.uint8)


def salt_and_pepper(image: Pixels, random: np.random.Generator) -> Pixels:
    """A tenth of the pixels white or black."""
    noisy, draw = image.copy(), random.random(image.shape[:2])
    noisy[draw < 0.05], noisy[draw > 0.95] = 0, 255
    return noisy


@pytest.mark.parametrize("noise", [gaussian, salt_and_pepper, lambda image, random: image])
def test_a_road_is_told_from_grass(
    noise: Callable[[Pixels, np.random.Generator], Pixels],
) -> None:
    found = road_mask(
        noise(picture(), np.random.default_rng(3)), shaded(read_color("asphalt"), 0.5)
    )
    assert found.shape == (240, 320)
    assert (found[INSIDE] > 127).mean() > 0.98
    assert (found[OUTSIDE] > 127).mean() < 0.002


def test_shade_is_for_hues_only() -> None:
    assert shaded(ColorRange((0, 10, 80), (179, 60, 120)), 0.5).low == (0, 10, 40)
    rgb = ColorRange((10, 10, 80), (20, 20, 120), "rgb")
    assert shaded(rgb, 0.5) == rgb
    plain = read_color("asphalt")
    assert shaded(plain, 0.0) == plain


def test_small_pictures_have_small_masks() -> None:
    assert road_mask(np.zeros((16, 16, 3), np.uint8), read_color("asphalt")).shape == (16, 16)
