"""Oriented roundels in images: centre, size and angle (worlds.roundel has what one looks like).

A roundel is a dark component whose outline is an ellipse, with a bright hole in its middle, and
beside it a dark bar at the right distance. The ellipse gives the affine map between the image and
the disc, so that distance and bar are measured on the disc, however obliquely it is seen.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import atan2, hypot, pi, sqrt

import cv2
import numpy as np

from hal.scene.arrays import Float64s, Int32s, Pixels
from worlds.roundel import HOLE, LINE, LINE_AT

_LEVELS = (0.25, 0.5)
"""Shares of the image's range of grey at which dark is told from bright: the lower one is for a
roundel in the shade of a bright scene."""
_SMALLEST = 10
"""Diameter of the smallest disc that is looked for, pixels."""
_SHORTEST = 8
"""Pixels of the shortest outline that is looked at: of the hole in the smallest disc."""
_FLATTEST = 0.3
"""Least ratio of the axes of the ellipse: seen more obliquely it is none."""
_ROUNDNESS = 0.12
"""Largest deviation of the outline's area from its ellipse's, as a share of it."""
INSCRIBED = 1 / sqrt(2)
"""Side of the square in a disc over its diameter."""
_SQUARE = ((-1, 1), (1, 1), (1, -1), (-1, -1))
_HOLE_SHARE = HOLE[0] * HOLE[1] / (pi / 4)
"""Area of the hole over that of the disc."""


@dataclass(frozen=True, slots=True)
class Roundel:
    """A roundel in an image; pixels, x to the right and y down."""

    x: float
    y: float
    """Centre of the disc."""
    diameter: float
    """Along the longer axis."""
    right: tuple[float, float]
    """The vector from the centre to the rim of the disc on the line's side."""
    ahead: tuple[float, float]
    """That to the rim in the direction in which it points."""

    @property
    def angle(self) -> float:
        """Radians, clockwise; 0 when it points up in the image, with the line at its right."""
        return atan2(self.right[1], self.right[0])

    @property
    def corners(self) -> Float64s:
        """The corners of the upright square in the disc, (4, 2), clockwise from its upper left, as
        those of a marker; its side is INSCRIBED diameters of the disc.
        """
        centre, right, ahead = (
            np.array(each) for each in ((self.x, self.y), self.right, self.ahead)
        )
        return np.array([centre + (u * right + v * ahead) / sqrt(2) for u, v in _SQUARE])


def roundels(image: Pixels) -> list[Roundel]:
    """The roundels in an image, largest first; BGR or grey, of any size."""
    if min(image.shape[:2]) < _SMALLEST:
        return []
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    grey = np.asarray(cv2.medianBlur(grey, 3), np.uint8)
    low, high, _, _ = cv2.minMaxLoc(grey)
    found: list[Roundel] = []
    for share in _LEVELS:
        rings, bars = _outlines(grey, low + share * (high - low))
        for outline, hole in rings:
            x, y = outline.mean(0).tolist()
            if any(hypot(x - other.x, y - other.y) < other.diameter / 2 for other in found):
                continue
            disc = _disc_of(outline, hole)
            seen = disc.with_line(bars) if disc else None
            if seen is not None:
                found.append(seen)
    return sorted(found, key=lambda seen: -seen.diameter)


def _outlines(grey: Pixels, level: float) -> tuple[list[tuple[Int32s, Int32s]], list[Int32s]]:
    """The outlines (n, 2) in what is darker than a level: those with a hole, each with that of its
    largest hole, and those without.
    """
    _, dark = cv2.threshold(grey, level, 255, cv2.THRESH_BINARY_INV)
    outlines, hierarchy = cv2.findContours(dark, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return [], []
    parents = np.asarray(hierarchy, np.int32).reshape(-1, 4)[:, 3].tolist()
    # Noise makes many outlines, all short.
    long = {
        k: np.asarray(outline, np.int32).reshape(-1, 2)
        for k, outline in enumerate(outlines)
        if len(outline) >= _SHORTEST
    }
    holes: dict[int, list[Int32s]] = {}
    for k, outline in long.items():
        if parents[k] in long:
            holes.setdefault(parents[k], []).append(outline)
    rings = [(long[k], max(inside, key=cv2.contourArea)) for k, inside in holes.items()]
    return rings, [long[k] for k in long if parents[k] < 0 and k not in holes]


@dataclass(frozen=True, slots=True, eq=False)
class _Disc:
    """An ellipse, as the image of a disc of radius 1."""

    centre: Float64s
    to_image: Float64s
    """From the disc to the image, but for a turn of the disc, (2, 2)."""
    from_image: Float64s
    """Its inverse."""
    diameter: float

    def on_disc(self, pixels: Int32s | Float64s) -> Float64s:
        """Pixels in radii of the disc."""
        return np.asarray((pixels - self.centre) @ self.from_image.T, np.float64)

    def with_line(self, bars: Iterable[Int32s]) -> Roundel | None:
        """The roundel of this disc, if one of the bars is its line."""
        for bar in bars:
            line = self._place_of_line(bar)
            if line is not None:
                return self._roundel(line)
        return None

    def _place_of_line(self, outline: Int32s) -> Float64s | None:
        """The point of a bar that is nearest to the centre, radii; None if it is not the line.

        That is the foot of a perpendicular, so that it is right also where the bar is cut by the
        image's border.
        """
        middle = self.on_disc(outline.mean(0))
        if not 0.8 < float(np.hypot(*middle)) / (2 * LINE_AT) < 1.6:
            return None
        points = self.on_disc(outline)
        along = np.linalg.svd(points - middle, full_matrices=False)[2][0]
        across = np.array([-along[1], along[0]])
        length, width = np.ptp(points @ along) / 2, np.ptp(points @ across) / 2
        away = float(middle @ across)
        fits = (
            0.6 < length / LINE[1] < 1.2
            and width < 0.5 * length
            and abs(abs(away) / (2 * LINE_AT) - 1) < 0.15
        )
        return across * away if fits else None

    def _roundel(self, line: Float64s) -> Roundel:
        right = line / np.hypot(*line)
        ahead = np.array([right[1], -right[0]])
        (x, y), (u, v), (p, q) = self.centre, self.to_image @ right, self.to_image @ ahead
        return Roundel(
            float(x), float(y), self.diameter, (float(u), float(v)), (float(p), float(q))
        )


def _disc_of(outline: Int32s, hole: Int32s) -> _Disc | None:
    """The disc whose outline it may be, with its largest hole; None for what is no disc."""
    area = cv2.contourArea(outline)
    share = cv2.contourArea(hole) / area if area else 0.0
    if not 0.4 < share / _HOLE_SHARE < 2.0 or np.ptp(outline, axis=0).max() < _SMALLEST - 1:
        return None
    (x, y), axes, turn = cv2.fitEllipse(outline)
    ellipse = pi / 4 * axes[0] * axes[1]
    if min(axes) < _FLATTEST * max(axes) or abs(area - ellipse) > _ROUNDNESS * ellipse:
        return None
    angle = np.deg2rad(turn)
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    # The outline runs through the middle of the outermost pixels: it is half a pixel too near.
    sides = np.array(axes) + 1
    to_image = turned * sides / 2
    disc = _Disc(np.array([x, y]), to_image, np.linalg.inv(to_image), float(sides.max()))
    off = disc.on_disc(hole.mean(0))
    return disc if float(np.hypot(*off)) < 0.25 else None
