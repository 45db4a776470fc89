"""Targets of a known size: a coloured thing, or a fiducial marker, and where images show them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import asin, pi, sin
from typing import Any, Protocol

import numpy as np

from behaviors.perception.blobs import Blob, blobs, touches_edge
from behaviors.perception.color import ColorRange, mask, read_color
from behaviors.perception.fiducials import FiducialDetector
from behaviors.perception.marker_pose import Posture, marker_pose
from behaviors.perception.projection import directions
from hal.scene.arrays import Float64s
from hal.vehicle import Frame
from vencejo.errors import nearest
from vencejo.geometry import Point, wrap

LEAST_AREA = 12.0
"""Pixels that a coloured thing covers at least."""
_MOST_BLOBS = 5
"""The number of coloured things in an image that are looked at, the largest ones."""
_EDGE_NOISE = 0.7
"""Standard deviation of where the edge of a coloured thing is, pixels."""
_CUT_OFF = 0.3
"""Standard deviation of the range of what the image cuts off, as a share of it."""
_COLORED, _MARKED = ("color", "size"), ("id", "size", "dictionary", "inside")
_PLAIN = ("id", "size", "dictionary")


@dataclass(frozen=True, eq=False)
class Sighting:
    """A target in one image; world axes of the frame's pose."""

    position: Point
    """Of its middle, metres."""
    covariance: Float64s
    """(3, 3), m²."""
    heading: float | None
    """The direction in which the top of a marker points if it lies, in which it faces otherwise,
    radians; None for what has none."""
    outline: Float64s
    """(n, 2), pixels: of a marker its corners."""


@dataclass(frozen=True, eq=False)
class Look:
    """What one image shows."""

    sightings: tuple[Sighting, ...]
    """The largest first."""
    rejected: tuple[Float64s, ...] = ()
    """Outlines of what is no target, pixels."""


class Target(Protocol):
    """What is looked for."""

    def look(self, frame: Frame) -> Look:
        """Where the target is in an image: nowhere, once, or in several places that look so."""


class ColorTarget:
    """A thing of a colour; ``size`` is its diameter or largest width, metres."""

    def __init__(self, color: ColorRange, size: float) -> None:
        self._color, self._size = color, size

    def look(self, frame: Frame) -> Look:
        found = blobs(mask(frame.image, self._color), LEAST_AREA)[:_MOST_BLOBS]
        return Look(tuple(self._sighting(frame, blob) for blob in found))

    def _sighting(self, frame: Frame, blob: Blob) -> Sighting:
        """The range by the angle that it is wide; the sides of the image hide a part of it."""
        left, top, right, bottom = blob.box
        if right - left >= bottom - top:
            ends = (left - 0.5, blob.y), (right - 0.5, blob.y)
        else:
            ends = (blob.x, top - 0.5), (blob.x, bottom - 0.5)
        a, b, ray = directions(frame, [*ends, (blob.x, blob.y)])
        width = 2 * asin(min(1.0, float(np.linalg.norm(a - b)) / 2))
        far = self._size / 2 / sin(width / 2)
        pixel = 1 / frame.intrinsics.fx
        along = far * _EDGE_NOISE * pixel / width
        if touches_edge(blob, frame.image):
            along += far * _CUT_OFF
        across = far * _EDGE_NOISE * pixel
        outer = np.outer(ray, ray)
        covariance = along**2 * outer + across**2 * (np.eye(3) - outer)
        x, y, z = (far * ray).tolist()
        outline = np.array([(left, top), (right, top), (right, bottom), (left, bottom)], float)
        return Sighting(frame.position.plus((x, y, z)), covariance, None, outline)


@dataclass(frozen=True, slots=True)
class MarkerSpec:
    """One marker, as world files and missions write it."""

    id: int
    size: float
    """Side of its black square, metres."""
    dictionary: str = "4X4_50"


class MarkerTarget:
    """A marker, and perhaps a smaller one inside, for when not all of the outer one is seen.

    Each has its own detector: of two nested markers of one dictionary OpenCV finds one. As the
    inner one hides some of its bits, errors of the outer one are corrected, as far as the
    dictionary allows.
    """

    def __init__(self, markers: Sequence[MarkerSpec], posture: Posture) -> None:
        """``markers`` are in each other, the outer one first. Raises ValueError."""
        self._posture: Posture = posture
        self.largest, self.smallest = markers[0].size, markers[-1].size
        """Sides of the outer one and of the one inside, metres."""
        dictionaries = [marker.dictionary.removeprefix("DICT_") for marker in markers]
        if len(set(dictionaries)) < len(markers):
            raise ValueError(
                "of two markers of one dictionary that lie in each other only one is found: the "
                "one inside needs another dictionary"
            )
        settings = {"errorCorrectionRate": 1.0} if len(markers) > 1 else {}
        self._detectors = [
            (FiducialDetector(marker.dictionary, [marker.id], settings), marker)
            for marker in markers
        ]

    def look(self, frame: Frame) -> Look:
        rejected: list[Float64s] = []
        for detector, marker in self._detectors:
            detections = detector.detect(frame.image)
            rejected += detections.rejected
            poses = (
                (found, marker_pose(frame, found.corners, marker.size, self._posture))
                for found in detections.found
            )
            turn = pi / 2 if self._posture == "level" else 0.0
            sightings = tuple(
                Sighting(pose.position, pose.covariance, wrap(pose.heading + turn), found.corners)
                for found, pose in poses
                if pose is not None
            )
            # The inner one is asked only where the outer one is not seen: from far away the outer
            # one's square can be taken for it.
            if sightings:
                return Look(sightings, tuple(rejected))
        return Look((), tuple(rejected))


def read_target(given: object, posture: Posture) -> Target:
    """The target that a person writes: ``{color, size}``, or ``{id, size, dictionary, inside}``.

    ``inside`` is a smaller marker, ``{id, size, dictionary}``. Raises ValueError, with a message
    for that person.
    """
    if isinstance(given, Mapping) and "color" in given:
        _known(given, _COLORED)
        return ColorTarget(read_color(given["color"]), _size(given))
    if isinstance(given, Mapping) and "id" in given:
        return read_marker(given, posture)
    raise ValueError("a target is {color: …, size: …} or a marker, {id: …, size: …}")


def read_marker(given: object, posture: Posture) -> MarkerTarget:
    """The marker that a person writes. Raises ValueError, with a message for that person."""
    if not isinstance(given, Mapping):
        raise ValueError("a marker is {id: …, size: …, dictionary: …, inside: {…}}")
    _known(given, _MARKED)
    markers = [_marker(given)]
    inside = given.get("inside")
    if inside is not None:
        if not isinstance(inside, Mapping):
            raise ValueError("the marker `inside` is {id: …, size: …, dictionary: …}")
        _known(inside, _PLAIN)
        markers.append(_marker(inside))
        if markers[1].size >= markers[0].size:
            raise ValueError("the marker `inside` is smaller than the outer one")
    return MarkerTarget(markers, posture)


def _known(given: Mapping[Any, Any], words: Sequence[str]) -> None:
    """Raises ValueError for a key that is not among the words."""
    for key in given:
        if key not in words:
            raise ValueError(f"'{key}' is not known here ({nearest(str(key), words)})")


def _marker(given: Mapping[Any, Any]) -> MarkerSpec:
    number, dictionary = given.get("id"), given.get("dictionary", "4X4_50")
    if not isinstance(number, (int, float)) or isinstance(number, bool) or number != int(number):
        raise ValueError("a marker has an `id`, a whole number")
    if not isinstance(dictionary, str):
        raise ValueError("a `dictionary` is a name, like 4X4_50")
    return MarkerSpec(int(number), _size(given), dictionary)


def _size(given: Mapping[Any, Any]) -> float:
    size = given.get("size")
    if not isinstance(size, (int, float)) or isinstance(size, bool) or not 0.001 <= size <= 100.0:
        raise ValueError("its `size` is needed to tell how far it is: from 1 mm to 100 m")
    return float(size)
