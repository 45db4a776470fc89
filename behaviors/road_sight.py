"""The sight of a road: a camera's frames, the map made of them, and the lines traced on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from behaviors.perception.centre_line import (
    XY,
    Begin,
    CentreLine,
    Node,
    Widths,
    find,
    trace,
)
from behaviors.perception.color import ColorRange
from behaviors.perception.ground_map import GroundMap
from behaviors.perception.road_mask import road_mask
from hal.vehicle import Camera, Frame

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
        self._reach = _REACH * above
        self.width = 0.0
        """Of the road, metres; 0 before it was found."""
        self.frame: Frame | None = None
        """The last one that was looked at."""
        self.looks = 0
        """Frames that were looked at."""

    def update(self) -> bool:
        """Look at the newest frame; False where there is none that is new."""
        frame = self._camera.latest()
        if frame is None or (self.frame and frame.sequence == self.frame.sequence):
            return False
        self.frame = frame
        self.looks += self._map.add(road_mask(frame.image, self._look.color), frame)
        return True

    def find(self, here: XY) -> Begin | None:
        """The road nearest to a place, and its ways from there."""
        begin = find(self._map, here, self._look.widths, self._look.gap)
        if begin is not None:
            self.width = begin.width
        return begin

    def trace(self, known: Sequence[Node]) -> CentreLine:
        """The line from the last of the nodes that are known on."""
        look = self._look
        line = trace(self._map, known, self.width, look.widths, look.gap, self._reach)
        if line.ending != "none":
            # The width where it is now, not where the line ends.
            self.width += 0.1 * (line.width - self.width)
        return line
