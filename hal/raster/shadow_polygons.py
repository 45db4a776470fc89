"""Shadows on the flat ground, cast along the sun's rays."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np

from hal.raster.buffers import Scene
from hal.scene.surfaces import Array

_FLAT = 0.02
"""What reaches less high above the ground casts no shadow, metres."""
_LOWEST = 0.05
"""Of the sun's direction: when it stands lower there are no shadows."""


class Shadows:
    """The shadows of a scene's solids, as convex polygons on the ground."""

    def __init__(self, scene: Scene, sun: Array) -> None:
        self._scene = scene
        self._slant = sun[:2] / sun[2] if sun[2] > _LOWEST else None
        still = [k for k, owner in enumerate(scene.owner) if owner < 0]
        self._moving = [k for k, owner in enumerate(scene.owner) if owner >= 0]
        self._still = self._cast(still)

    def polygons(self) -> list[Array]:
        """Corners (n, 3) of each at this moment, counter-clockwise from above."""
        return self._still + self._cast(k for k in self._moving if self._scene.shown[k])

    def _cast(self, solids: Iterable[int]) -> list[Array]:
        found = []
        scene = self._scene
        for solid in solids if self._slant is not None else ():
            points = scene.hull(solid)
            if points[:, 2].max() < _FLAT:
                continue
            heights = np.maximum(points[:, 2:], 0.0)
            fallen = (points[:, :2] - heights * self._slant).astype(np.float32)
            hull = cv2.convexHull(fallen, clockwise=False).reshape(-1, 2)
            if len(hull) >= 3:
                found.append(np.column_stack([hull, np.zeros(len(hull))]).astype(np.float64))
        return found
