"""Tags in camera frames, markers and roundels alike: where in the picture, and where in the world.

A marker has an id, and so can tell one from another; a roundel only has a direction.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import atan2, hypot, pi

import numpy as np

from behaviors.perception.fiducials import FiducialDetector
from behaviors.perception.marker_pose import Posture, marker_pose
from behaviors.perception.projection import ground_points
from behaviors.perception.roundel import INSCRIBED, roundels
from hal.scene.arrays import Float64s
from hal.vehicle import Frame
from vencejo.geometry import Point, distance, turned, wrap

ROUNDEL = "roundel"
"""The kind of a roundel; that of a marker is its dictionary."""
_DOWN = 0.7
"""A camera whose direction has at least this share downwards sees markers that lie; others, markers
that stand. Roundels always lie."""
_GROUND_ERROR = 0.05
"""Standard deviation of the height of a tag that is taken to lie on the ground, metres."""
_SLANT = 0.02
"""That of its place on the ground, as a share of its distance."""


@dataclass(frozen=True, eq=False)
class Tag:
    """A tag in one picture."""

    kind: str
    """The dictionary of a marker, or ``roundel``."""
    id: int
    """Of a marker; 0 for every roundel."""
    pixel: tuple[float, float]
    """Its centre, pixels."""
    corners: Float64s
    """(4, 2) pixels, clockwise from its upper left: of a roundel, the square in its disc."""
    position: Point | None
    """Of its centre, in the world axes of the frame's pose; None where its size is not known and it
    is not seen from above."""
    covariance: Float64s
    """(3, 3) of the position, m²."""
    heading: float | None
    """Direction in which the top of one that lies points, or one that stands faces; radians."""
    distance: float | None
    """From the camera to its centre, metres; None where its position is not known."""

    @property
    def angle(self) -> float:
        """By how much it is turned clockwise in the picture, radians; 0 when it is upright."""
        upper_left, upper_right, lower_right, lower_left = self.corners
        x, y = upper_right + lower_right - upper_left - lower_left
        return atan2(y, x)


@dataclass(frozen=True)
class Place:
    """A place in a picture, from its middle."""

    left: float
    """To the left, as a share of half the picture's width."""
    up: float
    """Upwards, as a share of half the picture's height."""
    radius: float
    """Distance from the middle, pixels."""

    @classmethod
    def of(cls, frame: Frame, pixel: tuple[float, float]) -> Place:
        half_width, half_height = (
            (frame.intrinsics.width - 1) / 2,
            (frame.intrinsics.height - 1) / 2,
        )
        left, up = half_width - pixel[0], half_height - pixel[1]
        return cls(left / half_width, up / half_height, hypot(left, up))


class TagFinder:
    """Finds the markers of a dictionary, and roundels.

    ``dictionary`` has OpenCV's name; only ``ids`` are looked for, all of it when None, and none at
    all when empty. With ``size``, the side of a marker's black square or the diameter of a
    roundel's disc in metres, a tag is placed by how large it looks; without it, it is taken to lie
    on the ground. Raises ValueError, with a sentence for people, for what OpenCV does not have.
    """

    def __init__(
        self,
        dictionary: str = "4X4_50",
        ids: Iterable[int] | None = None,
        size: float | None = None,
        *,
        roundels: bool = True,
    ) -> None:
        wanted = None if ids is None else list(ids)
        self._dictionary = dictionary.removeprefix("DICT_")
        self._detector = None if wanted == [] else FiducialDetector(dictionary, wanted)
        self._finds_roundels = roundels
        self._size = size
        self.rejected: tuple[Float64s, ...] = ()
        """Corners (4, 2) of squares in the last frame that are no marker looked for, pixels."""

    def find(self, frame: Frame, ground: float = 0.0) -> list[Tag]:
        """The tags in a frame; ``ground`` is the height of the ground below, metres."""
        return [
            self._placed(frame, ground, kind, number, corners, pixel)
            for kind, number, corners, pixel in self._seen(frame)
        ]

    def _seen(self, frame: Frame) -> Iterator[tuple[str, int, Float64s, tuple[float, float]]]:
        if self._detector is not None:
            detected = self._detector.detect(frame.image)
            self.rejected = detected.rejected
            for marker in detected.found:
                yield self._dictionary, marker.id, marker.corners, marker.centre
        if self._finds_roundels:
            for seen in roundels(frame.image):
                yield ROUNDEL, 0, seen.corners, (seen.x, seen.y)

    def _placed(
        self,
        frame: Frame,
        ground: float,
        kind: str,
        number: int,
        corners: Float64s,
        pixel: tuple[float, float],
    ) -> Tag:
        lies = kind == ROUNDEL or turned((0.0, 0.0, 1.0), frame.attitude).z < -_DOWN
        if self._size is not None:
            side = self._size * (INSCRIBED if kind == ROUNDEL else 1.0)
            posture: Posture = "level" if lies else "any"
            pose = marker_pose(frame, corners, side, posture)
            if pose is not None:
                heading = wrap(pose.heading + pi / 2) if lies else pose.heading
                away = distance(pose.position, frame.position)
                return Tag(
                    kind, number, pixel, corners, pose.position, pose.covariance, heading, away
                )
        elif lies:
            places = ground_points(frame, [pixel, *corners], ground)
            if not np.isnan(places).any():
                middle, upper_left, _, _, lower_left = places
                place = Point(*middle.tolist())
                away = distance(place, frame.position)
                deviation = np.array([_SLANT * away, _SLANT * away, _GROUND_ERROR])
                x, y, _ = upper_left - lower_left
                return Tag(
                    kind, number, pixel, corners, place, np.diag(deviation**2), atan2(y, x), away
                )
        return Tag(kind, number, pixel, corners, None, np.zeros((3, 3)), None, None)
