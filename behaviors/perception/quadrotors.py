"""Quadrotors of a known size and colour in an image: in which direction, how far, where.

Seen from its own height a quadrotor is a bar, the edge of its rotors and guards, over the narrower
box of its hull. The bar is a fifth wider across the corners than along the axes, so its width alone
tells the range to 5 % at best. But the hull is longer than wide, and the share of the bar that it
takes up tells how the quadrotor is turned: it is compared with that of each heading, and each
heading gives a range.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, inf, sin, sqrt, tan

import cv2
import numpy as np

from behaviors.perception.blobs import Blob, blobs, touches_edge
from behaviors.perception.color import ColorRange, mask
from behaviors.perception.projection import directions
from hal.scene.arrays import Float64s, Int32s, Pixels
from hal.vehicle import Frame
from vencejo.geometry import Point

# The proportions of an AR.Drone with its hull; those of a 450-class frame are nearly the same.
_ARM = 0.35
"""From the middle to a rotor, as a share of its size."""
_GUARD = 0.242
"""Radius of a rotor with its guard."""
_HULL = (0.5, 0.2)
"""Length and width of the hull."""

_HEADINGS = np.radians(np.arange(0.0, 91.0, 3.0))
"""Of the target from the line of sight; the others look the same."""
_CORNERS = _HEADINGS[:, None] + np.radians([45.0, 135.0, 225.0, 315.0])
_AHEAD, _ASIDE = _ARM * np.cos(_CORNERS), _ARM * np.sin(_CORNERS)
_SHARES = (_HULL[0] * np.sin(_HEADINGS) + _HULL[1] * np.cos(_HEADINGS)) / (
    2 * (_ASIDE.max(1) + _GUARD)
)
"""The share of the bar that the hull takes up, for each heading."""
_SHARE_ERROR = 0.03
"""Standard deviation of a measured share."""
_ANY_HEADING = 0.02
"""Weight of a heading that does not fit at all: what is not a share of a hull tells nothing."""
_HALF_SEEN = 0.5
"""Standard deviation of a range, as a share of it, where no hull is below the bar: far away it may
be the hull that is seen, and the bar that is not.
"""
_ROUND = 0.8
"""Height over width from which on a thing is taken for a ball."""
_PIXEL = 1.0
"""Standard deviation of a place in the image, pixels."""
_END = 12
"""The ends of the bar are this part of its width."""
_BAR = 0.75
"""Rows that are filled over more than this share of the width are of the bar."""
_BELOW = 0.07
"""Rows below the bar in which the hull is looked for, as a share of its width."""
_CLOSED = np.ones((3, 5), np.uint8)
"""Gaps that are closed in a mask: far away the bar is thinner than a pixel."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """What may be the target in one frame; axes and origin as the frame's pose has them."""

    pixel: tuple[float, float]
    """Its middle."""
    direction: Point
    """Unit vector from the camera to it."""
    range: float
    """Metres from the camera; infinite where the edge of the image cuts it."""
    deviation: float
    """Standard deviation of the range, metres."""
    area: float
    """Pixels."""
    eye: Point
    """Where the camera was."""
    outline: Int32s
    """(n, 2), the pixels along its edge."""

    def position(self, range_: float | None = None) -> Point:
        """Where it is; at another range if one is given, metres."""
        far = self.range if range_ is None else range_
        x, y, z = self.direction
        return self.eye.plus((x * far, y * far, z * far))

    def covariance(self, focal: float, range_: float | None = None) -> Float64s:
        """That of the position, m²: the range along the line of sight, a pixel across it.

        ``focal``: of the camera, pixels. For another range that one is doubtful by a third.
        """
        far = self.range if range_ is None else range_
        along = self.deviation if range_ is None else far / 3
        across = (_PIXEL * far / focal) ** 2
        line = np.outer(self.direction, self.direction)
        return np.asarray(along**2 * line + across * (np.eye(3) - line), np.float64)


def sightings(
    frame: Frame, wanted: ColorRange, size: float, min_area: float = 8.0
) -> list[Sighting]:
    """What may be a quadrotor of a colour in a frame, largest first.

    ``size``: along its body axes, guards included, metres; ``min_area``: pixels. A thing about as
    high as wide is taken for a ball of that diameter.
    """
    colored = mask(frame.image, wanted)
    closed = np.asarray(cv2.morphologyEx(colored, cv2.MORPH_CLOSE, _CLOSED), np.uint8)
    return [_sighting(frame, blob, colored, size) for blob in blobs(closed, min_area)]


def _sighting(frame: Frame, blob: Blob, colored: Pixels, size: float) -> Sighting:
    left, top, right, bottom = blob.box
    outline, angle = _upright(blob)
    along, down = outline[:, 0], outline[:, 1]
    begin, end = float(along.min()) - 0.5, float(along.max()) + 0.5
    middle = (begin + end) / 2, float(down.min() + down.max()) / 2
    pixels = _turned(np.array([[begin, middle[1]], [end, middle[1]], middle]), angle)
    one, other, ahead = directions(frame, pixels)
    if touches_edge(blob, frame.image):
        far, deviation = inf, inf
    else:
        half = tan(float(np.arccos(np.clip(one @ other, -1.0, 1.0))) / 2)
        if bottom - top >= _ROUND * (right - left):
            far, deviation = size / 2 * sqrt(1 + 1 / half**2), 0.0
        else:
            far, deviation = _range(_share(colored[top:bottom, left:right], angle), half, size)
        deviation = sqrt(deviation**2 + (far * _PIXEL / (end - begin)) ** 2)
    pixel = float(pixels[2, 0]), float(pixels[2, 1])
    direction = Point(*map(float, ahead))
    return Sighting(pixel, direction, far, deviation, blob.area, frame.position, blob.contour)


def _upright(blob: Blob) -> tuple[Float64s, float]:
    """The outline (n, 2) along and across its bar, pixels, and the angle by which that is turned,
    clockwise.
    """
    points = blob.contour.astype(np.float64)
    left, _, right, _ = blob.box
    end = max(1, (right - left) // _END)
    one = points[points[:, 0] < left + end].mean(0)
    other = points[points[:, 0] >= right - end].mean(0)
    angle = atan2(other[1] - one[1], max(1.0, other[0] - one[0]))
    return _turned(points, -angle), angle


def _turned(points: Float64s, angle: float) -> Float64s:
    """Points (n, 2) of an image turned clockwise about its corner, radians."""
    turn = np.array([[cos(angle), sin(angle)], [-sin(angle), cos(angle)]])
    return np.asarray(points @ turn, np.float64)


def _share(colored: Pixels, angle: float) -> float:
    """The share of its bar that a quadrotor's hull takes up, in the box that holds it; 0 where that
    is not to be seen.

    It is looked for right below the bar: farther below are lamps.
    """
    rows, columns = np.nonzero(colored)
    width = colored.shape[1]
    rows = np.rint(rows - tan(angle) * (columns - width / 2)).astype(int)
    rows -= rows.min()
    first, last = np.full(rows.max() + 1, width), np.full(rows.max() + 1, -1)
    np.minimum.at(first, rows, columns)
    np.maximum.at(last, rows, columns)
    spans = last - first + 1
    bar = int(np.flatnonzero(spans > _BAR * width)[-1]) + 1 if spans.max() > _BAR * width else 0
    hull = spans[bar : bar + max(2, round(_BELOW * width))]
    hull = hull[hull > 0]
    return float(np.median(hull)) / width if len(hull) else 0.0


def _range(share: float, half: float, size: float) -> tuple[float, float]:
    """The range of a quadrotor, and its standard deviation by what its heading may be; metres.

    ``half``: tangent of half the angle at which it is seen. From a range r a corner that lies a
    metres ahead of the middle and b aside, with a guard of radius g, has its edge at
    (b + g) / (r - a); the outermost is seen.
    """
    ranges = size * (_AHEAD + (_ASIDE + _GUARD) / half).max(1)
    weights = np.exp(-0.5 * ((_SHARES - share) / _SHARE_ERROR) ** 2) + _ANY_HEADING
    weights /= weights.sum()
    mean = float(weights @ ranges)
    doubt = 0.0 if share > 0 else _HALF_SEEN * mean
    return mean, sqrt(max(0.0, float(weights @ (ranges - mean) ** 2)) + doubt**2)
