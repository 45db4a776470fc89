"""Fiducial markers: found in images by their dictionary and ids, with sub-pixel corners.

S. Garrido-Jurado et al., *Automatic generation and detection of highly reliable fiducial markers
under occlusion*, 2014; the dictionaries of AprilTag: E. Olson, *AprilTag: A robust and flexible
visual fiducial system*, 2011. OpenCV finds both (``cv2.aruco.ArucoDetector``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from hal.scene.arrays import Float64s, Pixels
from vencejo.errors import nearest

REFINEMENTS = {"none": 0, "subpix": 1, "contour": 2, "apriltag": 3}
"""OpenCV's methods of corner refinement (CORNER_REFINE_…) by name."""
DEFAULTS: Mapping[str, float | str] = {
    "cornerRefinementMethod": "subpix",
    # Where a square at the edge of the image is dropped too soon, OpenCV 4 takes one inside it for
    # the marker: 10 pixels off.
    "minDistanceToBorder": 0,
}
"""The parameters that differ from OpenCV's, unless others are given."""
_EDGE = 5.0
"""A marker with a corner nearer to the edge of the image than this may be cut off, pixels; as much
as the refinement of corners moves one."""
_SMALLEST = 16
"""Images with a side below this show no marker, and OpenCV refuses some of them, pixels."""
_MOST = 2**31
"""OpenCV's whole numbers are smaller."""


@dataclass(frozen=True, eq=False)
class Fiducial:
    """A marker in an image."""

    id: int
    corners: Float64s
    """(4, 2) pixels, clockwise in the marker's own picture from its upper left; a pixel's centre is
    a whole number."""

    @property
    def centre(self) -> tuple[float, float]:
        """Where the diagonals meet, pixels: the image of the marker's centre."""
        a, b, c, d = self.corners
        along, across = c - a, d - b
        area = along[0] * across[1] - along[1] * across[0]
        from_a = b - a
        share = (from_a[0] * across[1] - from_a[1] * across[0]) / area if area else 0.5
        x, y = (a + share * along).tolist()
        return x, y

    @property
    def side(self) -> float:
        """The mean length of its sides, pixels."""
        sides = self.corners - np.roll(self.corners, -1, axis=0)
        return float(np.hypot(sides[:, 0], sides[:, 1]).mean())


@dataclass(frozen=True, eq=False)
class Detections:
    """What was found in one image."""

    found: tuple[Fiducial, ...]
    """The largest first."""
    rejected: tuple[Float64s, ...]
    """Corners (4, 2) of squares that are no marker of the ids wanted, pixels."""


class FiducialDetector:
    """Finds markers of one dictionary.

    ``dictionary`` is OpenCV's name, with or without ``DICT_`` (``4X4_50``, ``APRILTAG_36h11``).
    Only ``ids`` are looked for, all of the dictionary when it is None: the fewer, the faster, and
    the fewer false ones (the 587 of ``APRILTAG_36h11`` cost 8 ms an image, 30 of them 1 ms).
    ``parameters`` are OpenCV's DetectorParameters by name; ``cornerRefinementMethod`` may be one of
    REFINEMENTS. Raises ValueError, with a sentence for people, for what OpenCV does not have.
    """

    def __init__(
        self,
        dictionary: str,
        ids: Iterable[int] | None = None,
        parameters: Mapping[str, object] | None = None,
    ) -> None:
        whole = _dictionary(dictionary)
        wanted_ids = range(len(whole.bytesList)) if ids is None else set(map(_number, ids))
        self.ids = tuple(sorted(wanted_ids))
        """The ids that it looks for."""
        for number in self.ids:
            if not 0 <= number < len(whole.bytesList):
                most = len(whole.bytesList) - 1
                raise ValueError(f"{dictionary} has the markers 0 to {most}, not {number}")
        if not self.ids:
            raise ValueError("there is no id to look for")
        wanted = cv2.aruco.Dictionary(
            whole.bytesList[list(self.ids)], whole.markerSize, whole.maxCorrectionBits
        )
        settings = _settings({**DEFAULTS, **(parameters or {})})
        self._detector = cv2.aruco.ArucoDetector(wanted, settings)
        try:
            self._detector.detectMarkers(_picture(wanted))
        except cv2.error as error:
            raise ValueError(f"OpenCV refuses these parameters: {error.err}") from error

    def detect(self, image: Pixels) -> Detections:
        """Find the markers in an image, (height, width) grey or (height, width, 3) BGR."""
        height, width = image.shape[:2]
        if min(height, width) < _SMALLEST:
            return Detections((), ())
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
        try:
            squares, numbers, rejected = self._detector.detectMarkers(grey)
        except cv2.error:
            # With good parameters: it gives up on some images of nothing but noise.
            return Detections((), ())
        found = []
        for square, number in zip(squares, [] if numbers is None else numbers.flat, strict=True):
            corners = np.asarray(square, np.float64).reshape(4, 2)
            far = (corners >= _EDGE) & (corners <= (width - 1 - _EDGE, height - 1 - _EDGE))
            if far.all():
                found.append(Fiducial(self.ids[int(number)], corners))
        found.sort(key=lambda each: -each.side)
        others = tuple(np.asarray(each, np.float64).reshape(4, 2) for each in rejected)
        return Detections(tuple(found), others)


def _number(given: object) -> int:
    """The id of a marker. Raises ValueError for what is none."""
    if isinstance(given, (int, np.integer)) and not isinstance(given, bool):
        return int(given)
    raise ValueError(f"the ids of markers are whole numbers, not {given!r:.40}")


def _dictionary(name: str) -> cv2.aruco.Dictionary:
    """OpenCV's predefined dictionary. Raises ValueError."""
    short = name.removeprefix("DICT_")
    known = [each.removeprefix("DICT_") for each in dir(cv2.aruco) if each.startswith("DICT_")]
    if short not in known:
        raise ValueError(f"no marker dictionary is called '{name}' ({nearest(short, known)})")
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{short}"))


def _picture(dictionary: cv2.aruco.Dictionary) -> Pixels:
    """A picture of the first marker, to try parameters on."""
    marker = cv2.aruco.generateImageMarker(dictionary, 0, 8 * (dictionary.markerSize + 2))
    return np.pad(marker, 32, constant_values=255)


def _settings(given: Mapping[str, object]) -> cv2.aruco.DetectorParameters:
    """OpenCV's parameters of these values. Raises ValueError."""
    settings = cv2.aruco.DetectorParameters()
    known = [
        each
        for each in dir(settings)
        if not each.startswith("_") and not callable(getattr(settings, each))
    ]
    for name, value in given.items():
        if name not in known:
            hint = nearest(name, known)
            raise ValueError(f"OpenCV's marker detector has no parameter '{name}' ({hint})")
        setattr(settings, name, _value(name, value, getattr(settings, name)))
    return settings


def _value(name: str, value: object, default: object) -> object:
    """A parameter's value in the type that OpenCV wants. Raises ValueError."""
    if name == "cornerRefinementMethod":
        if value in REFINEMENTS:
            return REFINEMENTS[str(value)]
        raise ValueError(f"{name} is one of {', '.join(REFINEMENTS)}, not {value!r}")
    if isinstance(default, bool):
        if isinstance(value, bool):
            return value
        raise ValueError(f"{name} is true or false, not {value!r}")
    if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < _MOST:
        if isinstance(default, float):
            return float(value)
        if value == int(value):
            return int(value)
    kind = "a number" if isinstance(default, float) else "a whole number"
    raise ValueError(f"{name} is {kind}, not {value!r}")
