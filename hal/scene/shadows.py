"""Shadows on the flat ground, cast along the sun's rays."""

from __future__ import annotations

import cv2
import numpy as np

from hal.scene.arrays import Float64s

_LEAST_HEIGHT = 0.02
"""Things that reach less high above the ground cast no shadow, metres."""
_LOWEST_SUN = 0.05
"""Sine of the sun's height: below it there are no shadows."""


def ground_shadow(points: Float64s, sun: Float64s) -> Float64s | None:
    """The shadow that the convex hull of some points casts on the ground at z = 0.

    ``points`` (n, 3) are in the world frame, ``sun`` is the unit vector towards the sun. Gives
    corners (m, 3), counter-clockwise from above; None for no shadow.
    """
    if sun[2] <= _LOWEST_SUN or points[:, 2].max() < _LEAST_HEIGHT:
        return None
    heights = np.maximum(points[:, 2:], 0.0)
    fallen = (points[:, :2] - heights * (sun[:2] / sun[2])).astype(np.float32)
    hull = cv2.convexHull(fallen, clockwise=False).reshape(-1, 2)
    if len(hull) < 3:
        return None
    return np.column_stack([hull, np.zeros(len(hull))]).astype(np.float64)
