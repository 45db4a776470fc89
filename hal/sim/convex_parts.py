"""Meshes in convex parts, for engines that take the convex hull of a mesh for the mesh. Metres."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from worlds.things import Mesh

_HOLLOW = 0.03
"""Greatest depth of a hollow that is filled, metres."""
_MOST, _LARGE = 64, 4000
"""Parts of a mesh, unless more are apart, and triangles of a part that is cut, at most."""
_FINEST = 0.1
"""Least length of a part that is divided further, metres."""
_THICK = 0.01
"""Thickness that a flat part is given, metres."""

_Triangles = NDArray[np.float64]
"""(n, 3, 3): the corners of each triangle, counter-clockwise seen from outside."""


def convex_parts(mesh: Mesh) -> list[NDArray[np.float64]]:
    """The corners, each an (n, 3) array, of solids whose convex hulls make up a mesh.

    What hangs together is one solid; one with a hollow is cut by planes through its middle until
    its parts have none, or are many.
    """
    whole = [mesh.vertices[mesh.faces[part]] for part in _connected(mesh)]
    waiting = [(_hollow(triangles), triangles) for triangles in whole]
    parts: list[_Triangles] = []
    while waiting:
        # The deepest hollow first, since their number is limited.
        deepest = max(range(len(waiting)), key=lambda k: waiting[k][0])
        hollow, triangles = waiting.pop(deepest)
        many = len(parts) + len(waiting) + 1 >= max(_MOST, len(whole)) or len(triangles) > _LARGE
        if many or hollow <= _HOLLOW or np.ptp(triangles, (0, 1)).max() < _FINEST:
            parts.append(triangles)
        else:
            waiting += _halves(triangles)
    return [_solid(triangles) for triangles in parts]


def _connected(mesh: Mesh) -> Iterator[NDArray[np.intp]]:
    """The numbers of the faces of each part that shares no corner with others."""
    # Corners at the same place are one, whatever their number.
    _, same = np.unique(mesh.vertices.round(6), axis=0, return_inverse=True)
    faces = same.ravel()[mesh.faces]
    label = np.arange(faces.max(initial=0) + 1)
    while True:
        least = label[faces].min(axis=1)
        new = label.copy()
        np.minimum.at(new, faces.ravel(), np.repeat(least, 3))
        new = new[new]
        if (new == label).all():
            break
        label = new
    belongs = label[faces[:, 0]]
    for each in np.unique(belongs):
        yield np.flatnonzero(belongs == each)


def _normals(triangles: _Triangles) -> NDArray[np.float64]:
    """Unit normals; zero for a triangle without area."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normals: NDArray[np.float64] = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.maximum(lengths, 1e-12)
    return normals


def _hollow(triangles: _Triangles) -> float:
    """How far a corner lies before the plane of a triangle, which in a convex solid none does.

    Of many triangles some are looked at.
    """
    some = triangles[:: 1 + len(triangles) // 500]
    normals, corners = _normals(some), some.reshape(-1, 3)
    own = (normals * some[:, 0]).sum(axis=1)
    return float((corners @ normals.T - own).max(initial=0.0))


def _halves(triangles: _Triangles) -> list[tuple[float, _Triangles]]:
    """What lies on both sides of the plane, across an axis, that leaves the least hollows.

    Each with its hollow.
    """
    low, high = triangles.min((0, 1)), triangles.max((0, 1))
    found = []
    for axis in range(3):
        if high[axis] - low[axis] > _FINEST / 2:
            sides = (_side(triangles, axis, (low[axis] + high[axis]) / 2, s) for s in (-1.0, 1.0))
            found.append([(_hollow(side), side) for side in sides if len(side)])
    return min(found, key=lambda halves: sum(hollow for hollow, _ in halves))


def _side(triangles: _Triangles, axis: int, middle: float, sign: float) -> _Triangles:
    """What of triangles is on one side of a plane across an axis, in triangles."""
    depths = (triangles[:, :, axis] - middle) * sign
    inside = (depths >= 0).all(axis=1)
    crossing = ~inside & (depths > 0).any(axis=1)
    cut = [_cut(*each) for each in zip(triangles[crossing], depths[crossing], strict=True)]
    return np.concatenate([triangles[inside], *cut])


def _cut(triangle: NDArray[np.float64], depths: NDArray[np.float64]) -> _Triangles:
    """What of a triangle is where its depth is above 0; ``depths``: of its corners."""
    corners = []
    for k in range(3):
        one, other = depths[k], depths[k - 2]
        if one >= 0:
            corners.append(triangle[k])
        if one * other < 0:
            corners.append(triangle[k] + (triangle[k - 2] - triangle[k]) * one / (one - other))
    return np.array([[corners[0], *corners[k : k + 2]] for k in range(1, len(corners) - 1)])


def _solid(triangles: _Triangles) -> NDArray[np.float64]:
    """The corners of a part; a flat one gets some thickness, inwards."""
    corners = np.unique(triangles.reshape(-1, 3), axis=0)
    spread = corners - corners.mean(axis=0)
    _, _, axes = np.linalg.svd(spread, full_matrices=True)
    if np.ptp(spread @ axes[-1]) > _THICK / 10:
        return corners
    inwards = -_normals(triangles).sum(axis=0)
    length = np.linalg.norm(inwards)
    inwards = inwards / length if length > 1e-9 else axes[-1]
    return np.concatenate([corners, corners + inwards * _THICK])
