"""The sight of a road: a camera's frames, the map made of them, and the lines traced on it."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin
from typing import NamedTuple

import numpy as np

from behaviors.perception.centre_line import (
    Begin,
    CentreLine,
    Node,
    Widths,
    find,
    trace,
)
from behaviors.perception.color import ColorRange
from behaviors.perception.ground_map import GroundMap
from behaviors.perception.projection import is_inside, pixels_of
from behaviors.perception.road_mask import road_mask
from hal.scene.arrays import Pixels
from hal.vehicle import Camera, Frame
from vencejo.polylines import XY

_CELLS_PER_HEIGHT = 120
"""A cell is about two pixels wide."""
_FINEST, _COARSEST = 0.01, 0.2
"""Bounds of a cell's side, metres."""
_REACH = 2.0
"""Of the height: how far a line is traced, metres; the farthest corner of a picture is nearer."""


class Look(NamedTuple):
    """What a road looks like."""

    color: ColorRange
    widths: Widths
    gap: float
    """The longest, metres."""


class RoadSight:
    """What is known of a road about the vehicle."""

    def __init__(self, camera: Camera, look: Look, height: float, ground: float) -> None:
        """``height``: at which is flown; ``ground``: that of the road; mission frame, metres."""
        self._camera = camera
        self._look = look
        above = max(0.1, height - ground)
        cell = min(_COARSEST, max(_FINEST, above / _CELLS_PER_HEIGHT))
        self._map = GroundMap(cell, ground)
        self._ground = ground
        self._reach = _REACH * above
        self.width = 0.0
        """Of the road, metres; 0 before it was found."""
        self.frame: Frame | None = None
        """The last one that was looked at."""
        self._mask: Pixels | None = None
        """Its road."""
        self.looks = 0
        """Frames that were looked at and are on the map."""

    def update(self) -> bool:
        """Look at the newest frame; False where there is none that is new."""
        frame = self._camera.latest()
        if frame is None or (self.frame and frame.sequence == self.frame.sequence):
            return False
        self.frame = frame
        self._mask = road_mask(frame.image, self._look.color)
        self.looks += self._map.add(self._mask, frame)
        return True

    def find(self, here: XY) -> Begin | None:
        """The road nearest to a place, and its ways from there."""
        begin = find(self._map, here, self._look.widths, self._look.gap)
        if begin is not None:
            self.width = begin.width
        return begin

    def sees_before(self, node: Node) -> bool:
        """Whether the last frame itself sees the road that leads to a node."""
        if self.frame is None or self._mask is None:
            return False
        back = np.linspace(0.15, 0.8, 6)[:, None] * self.width
        places = np.array(node[:2]) - back * [cos(node.heading), sin(node.heading)]
        level = np.full((len(places), 1), self._ground)
        pixels = pixels_of(self.frame, np.concatenate([places, level], 1))
        columns, rows = np.rint(pixels[is_inside(self.frame, pixels)]).astype(int).T
        height, width = self._mask.shape
        if height <= max(rows, default=height) or width <= max(columns, default=width):
            return False
        return bool((self._mask[rows, columns] > 127).sum() > len(places) / 2)

    def trace(self, known: Sequence[Node], into_gap: bool = False) -> CentreLine:
        """The line from the last of the nodes that are known on (see :func:`trace`)."""
        look = self._look
        line = trace(
            self._map, known, self.width, look.widths, look.gap,
            reach=self._reach, into_gap=into_gap,
        )  # fmt: skip
        if line.ending != "none":
            # The width where it is now, not where the line ends.
            self.width += 0.1 * (line.width - self.width)
        return line
