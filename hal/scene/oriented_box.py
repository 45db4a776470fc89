"""Boxes about the parts of things, turned as these are. World frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hal.scene.arrays import Float64s
from hal.scene.transforms import rotation_matrix
from vencejo.geometry import Point, Pose
from worlds.solids import bounds_of, part_pose
from worlds.things import UPRIGHT, Part


@dataclass(frozen=True, eq=False)
class OrientedBox:
    """A box with axes of its own."""

    center: Float64s
    axes: Float64s
    """(3, 3), its own axes to world."""
    half: Float64s
    """Half of its sides."""

    @classmethod
    def about(cls, part: Part, pose: Pose) -> OrientedBox:
        """The box about a part of a thing that is in a pose."""
        at, attitude = part_pose(part, *pose)
        low, high = (np.array(end) for end in bounds_of(part.shape, Point(0, 0, 0), UPRIGHT))
        axes = rotation_matrix(attitude)
        return cls(axes @ ((low + high) / 2) + at, axes, (high - low) / 2)

    def distance(self, place: Float64s) -> float:
        """The distance of a place from the box; 0 inside."""
        beyond = np.abs((place - self.center) @ self.axes) - self.half
        return float(np.linalg.norm(np.maximum(beyond, 0.0)))
