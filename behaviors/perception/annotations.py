"""Annotations: what was found, drawn on a copy of the image it was found in.

For people, inside the ``draw`` of :meth:`behaviors.flight.Flight.picture`. Every function gives a
new image, so that they follow one another; what is not finite, or lies beside the image, is not
drawn. Lines and letters grow with the image.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import ArrayLike

from behaviors.perception.blobs import Blob
from behaviors.perception.projection import pixels_of
from hal.scene.arrays import Float64s, Pixels
from hal.scene.transforms import rotation_matrix
from hal.vehicle import Frame
from vencejo.geometry import Quaternion

Color = tuple[int, int, int]
"""Blue, green, red."""
GREEN: Color = (60, 210, 60)
BLUE: Color = (240, 120, 30)
RED: Color = (50, 50, 235)
YELLOW: Color = (40, 220, 250)
WHITE: Color = (255, 255, 255)
_HEIGHT = 240
"""Pixels: an image of this height has lines one pixel wide."""
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_LETTERS, _ROW = 0.4, 16
"""Size of letters, and pixels of a line of them, in an image of that height."""
_SHIFT = 3
"""Fractional bits of the coordinates given to OpenCV."""
_FARTHEST = 4000.0
"""Pixels from the origin: lines that lead farther are cut off there, since OpenCV counts in int."""
_PARTS = 16
"""Parts of a straight line in the world, which a lens bends."""


def text_line(image: Pixels, words: str, row: int = 0, color: Color = WHITE) -> Pixels:
    """A line of text on a dark ground, ``row`` lines below the top of the image."""
    drawn = image.copy()
    step = _ROW * _thickness(image)
    if 0 <= row * step < image.shape[0]:
        _write(drawn, words, (0, (row + 1) * step), color)
    return drawn


def section(
    image: Pixels,
    left: Sequence[float],
    right: Sequence[float],
    reference: Sequence[float] | None = None,
    color: Color = BLUE,
) -> Pixels:
    """A section of a road: its ends with a line between, and the reference point steered for."""
    drawn = image.copy()
    _polyline(drawn, np.array([left, right], float), color)
    for end in (left, right):
        _cross(drawn, end, color, 3)
    if reference is not None:
        _disc(drawn, reference, RED, 3)
    return drawn


def blob(image: Pixels, found: Blob, label: str = "", color: Color = GREEN) -> Pixels:
    """A blob: its contour, its box, a cross at its centroid, and a label above."""
    drawn = image.copy()
    contour = np.asarray(found.contour, float)
    _polyline(drawn, contour, color, closed=True)
    left, top, right, bottom = found.box
    corners = [(left, top), (right - 1, top), (right - 1, bottom - 1), (left, bottom - 1)]
    _polyline(drawn, np.array(corners, float), YELLOW, closed=True)
    _cross(drawn, (found.x, found.y), RED, 4)
    _write(drawn, label, (left, top - 2), YELLOW)
    return drawn


def marker(image: Pixels, corners: ArrayLike, label: str = "", color: Color = GREEN) -> Pixels:
    """A square marker by its corners (4, 2), clockwise in its own picture from its upper left.

    With its outline, a dot at the first corner, and the axes in its plane: x (red) and y (green)
    from its centre to the middle of its right and upper sides.
    """
    drawn = image.copy()
    square = np.asarray(corners, np.float64).reshape(4, 2)
    _polyline(drawn, square, color, closed=True)
    _disc(drawn, square[0], YELLOW, 2)
    centre, right, upper = _on_square(square, ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
    _arrow(drawn, centre, right, RED)
    _arrow(drawn, centre, upper, GREEN)
    if np.isfinite(square).all():
        _write(drawn, label, (square[:, 0].min(), square[:, 1].min() - 4), YELLOW)
    return drawn


def axes(
    image: Pixels, frame: Frame, position: Sequence[float], turn: Quaternion, length: float
) -> Pixels:
    """The axes of something in the world, ``length`` metres long: x red, y green, z blue.

    ``turn`` leads from its axes to those of the frame's pose.
    """
    drawn = image.copy()
    with np.errstate(over="ignore", invalid="ignore"):
        arms = np.vstack([np.zeros(3), length * rotation_matrix(turn).T])
        ends = arms + np.asarray(position, float)
    origin, *tips = pixels_of(frame, ends)
    for tip, color in zip(tips, (RED, GREEN, BLUE), strict=True):
        _arrow(drawn, origin, tip, color)
    return drawn


def rejected(image: Pixels, candidates: Iterable[ArrayLike], color: Color = RED) -> Pixels:
    """Outlines (n, 2) of what might have been a marker, or a blob, and is none."""
    drawn = image.copy()
    for outline in candidates:
        points = np.asarray(outline, np.float64).reshape(-1, 2)
        _polyline(drawn, points, color, closed=True, thin=True)
    return drawn


def circle(
    image: Pixels, centre: Sequence[float], radius: float, color: Color = GREEN, label: str = ""
) -> Pixels:
    """A circle in pixels with a label beside it."""
    drawn = image.copy()
    if np.isfinite([*centre, radius]).all() and 0 < radius < _FARTHEST and _is_near(centre):
        whole = _fixed(np.array(centre, float)), round(radius * 2**_SHIFT)
        cv2.circle(drawn, *whole, color, _thickness(drawn) + 1, cv2.LINE_AA, _SHIFT)
        _write(drawn, label, (centre[0] + radius + 3, centre[1] + 8), color)
    return drawn


def path(image: Pixels, frame: Frame, points: ArrayLike, color: Color = YELLOW) -> Pixels:
    """A line through points (n, 3) of the world, axes of the frame's pose, as it is seen."""
    drawn = image.copy()
    given = np.asarray(points, np.float64).reshape(-1, 3)
    for begin, end in pairwise(given):
        shares = np.linspace(0.0, 1.0, _PARTS + 1)[:, None]
        with np.errstate(over="ignore", invalid="ignore"):
            parts = begin + shares * (end - begin)
        _polyline(drawn, pixels_of(frame, parts), color)
    return drawn


# -- strokes, each onto the image it is given ------------------------------------------------------


def _thickness(image: Pixels) -> int:
    least: int = min(image.shape[:2])
    return max(1, round(least / _HEIGHT))


def _is_near(pixel: Sequence[float] | Float64s) -> bool:
    return bool(np.isfinite(pixel).all() and np.abs(pixel).max() <= _FARTHEST)


def _fixed(pixel: Float64s) -> tuple[int, int]:
    x, y = np.rint(pixel * 2**_SHIFT).astype(int).tolist()
    return x, y


def _polyline(
    drawn: Pixels, points: Float64s, color: Color, *, closed: bool = False, thin: bool = False
) -> None:
    """Straight lines between pixels (n, 2), but for those from or to one far from the image."""
    line = np.vstack([points, points[:1]]) if closed else points
    with np.errstate(invalid="ignore"):
        near = (np.abs(line) <= _FARTHEST).all(1)
    # Split where a pixel is not near, which belongs to no part.
    breaks = np.flatnonzero(~near)
    parts = np.split(line, breaks) if len(breaks) else [line]
    whole = [part if (np.abs(part[:1]) <= _FARTHEST).all() else part[1:] for part in parts]
    fixed = [np.rint(part * 2**_SHIFT).astype(np.int32) for part in whole if len(part) > 1]
    thickness = 1 if thin else _thickness(drawn)
    cv2.polylines(drawn, fixed, False, color, thickness, cv2.LINE_AA, _SHIFT)


def _arrow(drawn: Pixels, begin: Float64s, end: Float64s, color: Color) -> None:
    if _is_near(begin) and _is_near(end):
        thickness = _thickness(drawn)
        cv2.line(drawn, _fixed(begin), _fixed(end), color, thickness + 1, cv2.LINE_AA, _SHIFT)
        _disc(drawn, end, color, 2)


def _cross(drawn: Pixels, pixel: Sequence[float], color: Color, reach: int) -> None:
    x, y = pixel
    r = reach * _thickness(drawn)
    _polyline(drawn, np.array([(x - r, y), (x + r, y)], float), color)
    _polyline(drawn, np.array([(x, y - r), (x, y + r)], float), color)


def _disc(drawn: Pixels, pixel: Sequence[float] | Float64s, color: Color, radius: int) -> None:
    if _is_near(pixel):
        size = (radius * _thickness(drawn)) * 2**_SHIFT
        cv2.circle(drawn, _fixed(np.array(pixel, float)), size, color, -1, cv2.LINE_AA, _SHIFT)


def _write(drawn: Pixels, words: str, pixel: Sequence[float], color: Color) -> None:
    """Words on a darkened band whose lower left is at a pixel, moved into the image where it would
    stick out.
    """
    if not words or not _is_near(pixel):
        return
    # The letters that OpenCV's font has.
    shown = words.replace("°", " deg").encode("ascii", "replace").decode()
    thickness = _thickness(drawn)
    size, height = _LETTERS * thickness, _ROW * thickness
    width = cv2.getTextSize(shown, _FONT, size, thickness)[0][0] + 4 * thickness
    left = min(max(0, round(pixel[0])), max(0, drawn.shape[1] - width))
    bottom = min(max(height, round(pixel[1])), drawn.shape[0])
    band = drawn[max(0, bottom - height) : bottom, left : left + width]
    band[:] = band // 3
    at = (left + 2 * thickness, bottom - 5 * thickness)
    cv2.putText(drawn, shown, at, _FONT, size, color, thickness, cv2.LINE_AA)


def _on_square(corners: Float64s, places: Sequence[Sequence[float]]) -> Float64s:
    """The pixels (n, 2) of places on a square, x to its right and y upwards, 1 at its sides; NaN
    of one whose corners are not near the image.
    """
    if not _is_near(corners):
        return np.full((len(places), 2), np.nan)
    own = np.array([(-1, 1), (1, 1), (1, -1), (-1, -1)], np.float32)
    turn = cv2.getPerspectiveTransform(own, corners.astype(np.float32))
    given = np.column_stack([np.asarray(places, float), np.ones(len(places))])
    found = given @ np.asarray(turn, float).T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(found[:, :2] / found[:, 2:], np.float64)
