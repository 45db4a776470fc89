"""The pixels of a road: those of its colour, in sun and shade, without the noise of the picture."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from behaviors.perception.color import ColorRange, mask
from hal.scene.arrays import Pixels

_SPECKS = 3
"""Side of the square whose median takes single wrong pixels out, pixels."""
_GRAIN = 7
"""Side of the square over which what is left of the noise is averaged, pixels."""
_HOLES = 5
"""Side of the square over which the pixels that are road are averaged, pixels."""


def shaded(wanted: ColorRange, shade: float) -> ColorRange:
    """A range of colours with those that a shadow makes of it, which takes a share of the light.

    A shadow keeps hue and saturation; a range of red, green and blue is left as it is.
    """
    if wanted.space == "rgb" or shade <= 0:
        return wanted
    hue, saturation, value = wanted.low
    return replace(wanted, low=(hue, saturation, round(value * (1 - shade))))


def road_mask(image: Pixels, wanted: ColorRange) -> Pixels:
    """How much the pixels of a BGR image are in a range of colours, 255 for those that are.

    Noise is taken out before: a tenth of the pixels may be black or white, or all of them be off by
    25 grey levels.
    """
    clean = cv2.blur(cv2.medianBlur(image, _SPECKS), (_GRAIN, _GRAIN))
    found = mask(np.asarray(clean, np.uint8), wanted)
    return np.asarray(cv2.blur(found, (_HOLES, _HOLES)), np.uint8)
