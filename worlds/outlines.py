"""Outlines of things from above, for maps. World frame, metres."""

from __future__ import annotations

from functools import cache
from itertools import product
from math import cos, pi, sin
from typing import TYPE_CHECKING

from vencejo.geometry import Quaternion, turned
from worlds.motion import pose_at
from worlds.solids import part_pose, solid_parts
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Shape, Sphere, Thing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Outline = tuple[tuple[float, float], ...]
"""The corners of a convex polygon, counter-clockwise, x and y."""
_DIRECTIONS = 64
"""The number of directions in which the outermost point is looked for."""
_RIM = tuple((cos(2 * pi * k / 24), sin(2 * pi * k / 24)) for k in range(24))
"""Points that stand for a circle."""


def outlines_of(thing: Thing, time: float = 0.0) -> tuple[Outline, ...]:
    """The outlines of a thing's parts, ``time`` seconds after the run began.

    They are those of its solid parts; of all, where none is solid. A mesh has that of its convex
    hull, with at most 64 corners.
    """
    at, attitude = pose_at(thing, time)
    found = []
    for part in solid_parts(thing) or thing.parts:
        place, turn = part_pose(part, at, attitude)
        points = _seen_from_above(part.shape, turn)
        outermost = points[(points @ _directions()).argmax(axis=0)] + place[:2]
        found.append(tuple(dict.fromkeys((float(x), float(y)) for x, y in outermost)))
    return tuple(found)


def _seen_from_above(shape: Shape, attitude: Quaternion) -> NDArray[np.float64]:
    """The points of a shape that its outline may lead through, about its origin, (n, 2)."""
    import numpy as np

    if isinstance(shape, Mesh):
        points = shape.vertices
    elif isinstance(shape, Sphere):
        points, attitude = np.array([(x, y, 0.0) for x, y in _RIM]) * shape.radius, UPRIGHT
    elif isinstance(shape, Cylinder):
        size = (shape.radius, shape.radius, shape.height / 2)
        points = np.array([(x, y, z) for (x, y), z in product(_RIM, (-1, 1))]) * size
    else:
        size = shape.size if isinstance(shape, Cuboid) else (shape.width, shape.height, 0.0)
        points = np.array([*product((-0.5, 0.5), repeat=3)]) * size
    axes = np.array([turned(axis, attitude) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))])
    seen: NDArray[np.float64] = points @ axes[:, :2]
    return seen


@cache
def _directions() -> NDArray[np.float64]:
    """Unit vectors all around, counter-clockwise, (2, n)."""
    import numpy as np

    # A little off, so that none is square to a side of things that are turned by round angles.
    angles = np.linspace(0, 2 * pi, _DIRECTIONS, endpoint=False) + 0.0123
    return np.array([np.cos(angles), np.sin(angles)])
