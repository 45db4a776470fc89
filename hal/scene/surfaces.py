"""Solids: what the renderer orders and draws, made from the parts of things.

A solid is convex (or a mesh that is not, which is drawn with depth per pixel). Its faces are flat
convex polygons, counter-clockwise seen from outside.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from hal.scene.textures import Painted
from vencejo.geometry import Quaternion
from worlds.things import Color, Cuboid, Cylinder, Mesh, Part, Plate, Sphere, Terrain, Texture

Array = NDArray[np.float64]

CYLINDER_SIDES = 24
OUTLINE = 48
"""Corners of the outline that a sphere is drawn as."""
_SUNKEN_RINGS = 16
"""Of a ball that the ground cuts."""
_FLAT = 1e-7


@dataclass(frozen=True, eq=False)
class Face:
    """A flat convex polygon."""

    corners: tuple[int, ...]
    """Indices of the solid's vertices."""
    color: Color
    texture: Texture | Painted | None = None
    frame: Array | None = None
    """Of a textured face: the texture's upper left corner, the vector along its upper edge and the
    one down its left edge, all in the face's plane."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A piece of a thing, in a frame that the one who made it knows; metres."""

    vertices: Array
    """(n, 3)."""
    faces: tuple[Face, ...]
    convex: bool = True
    sphere: float = 0.0
    """Radius of a ball about the only vertex; 0 for all else."""


def rotation(q: Quaternion) -> Array:
    """The matrix that turns local vectors (columns) into the outer frame's."""
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def solid_of(part: Part) -> Solid:
    """The solid of a part, in the frame of its thing."""
    solid = _local(part)
    return placed(solid, rotation(part.attitude), np.array(part.at))


def placed(solid: Solid, turn: Array, at: Array) -> Solid:
    """The same solid seen from an outer frame."""
    faces = tuple(
        face
        if face.frame is None
        else Face(
            face.corners,
            face.color,
            face.texture,
            np.vstack([turn @ face.frame[0] + at, face.frame[1:] @ turn.T]),
        )
        for face in solid.faces
    )
    return Solid(solid.vertices @ turn.T + at, faces, solid.convex, solid.sphere)


def _local(part: Part) -> Solid:
    shape, color = part.shape, part.color
    if isinstance(shape, Cuboid):
        return _cuboid(shape, color, part.texture)
    if isinstance(shape, Plate):
        return _plate(shape, color, part.texture)
    if isinstance(shape, Cylinder):
        return _cylinder(shape, color)
    if isinstance(shape, Sphere):
        return Solid(np.zeros((1, 3)), (Face((0,) * OUTLINE, color),), sphere=shape.radius)
    return _mesh(shape, color)


def _quad(vertices: Array, corners: tuple[int, ...], color: Color, texture: Texture | None) -> Face:
    """A rectangle by its lower left, lower right, upper right and upper left corner."""
    if texture is None:
        return Face(corners, color)
    lower, _, right, left = (vertices[corner] for corner in corners)
    return Face(corners, color, texture, np.stack([left, right - left, lower - left]))


def _cuboid(shape: Cuboid, color: Color, texture: Texture | None) -> Solid:
    x, y, z = (side / 2 for side in shape.size)
    vertices = np.array([[a, b, c] for c in (-z, z) for b in (-y, y) for a in (-x, x)])
    # Lower left first, seen from outside; on the sides +z is up, on top and below +y is.
    around = ((0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6), (4, 5, 7, 6), (1, 0, 2, 3))
    return Solid(vertices, tuple(_quad(vertices, face, color, texture) for face in around))


def _plate(shape: Plate, color: Color, texture: Texture | None) -> Solid:
    x, y = shape.width / 2, shape.height / 2
    vertices = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    return Solid(vertices, (_quad(vertices, (0, 1, 2, 3), color, texture),))


def _cylinder(shape: Cylinder, color: Color) -> Solid:
    n, r, z = CYLINDER_SIDES, shape.radius, shape.height / 2
    ring = [(r * cos(2 * pi * k / n), r * sin(2 * pi * k / n)) for k in range(n)]
    vertices = np.array([(x, y, h) for h in (-z, z) for x, y in ring])
    sides = [Face((a, b, b + n, a + n), color) for a, b in pairwise([*range(n), 0])]
    caps = [Face(tuple(range(n, 2 * n)), color), Face(tuple(reversed(range(n))), color)]
    return Solid(vertices, (*sides, *caps))


def _mesh(shape: Mesh, color: Color) -> Solid:
    vertices = np.asarray(shape.vertices, np.float64)
    faces = np.asarray(shape.faces)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    faces, a, normals = faces[lengths > 0], a[lengths > 0], normals[lengths > 0]
    normals /= lengths[lengths > 0, None]
    reach = float(np.abs(vertices).max(initial=1.0))
    heights = normals @ vertices.T - np.einsum("ij,ij->i", normals, a)[:, None]
    convex = bool((heights <= _FLAT * reach).all())
    corners = [tuple(int(corner) for corner in face) for face in faces]
    return Solid(vertices, tuple(Face(corner, color) for corner in corners), convex)


def ball(radius: float, rings: int) -> Mesh:
    """A sphere as triangles between circles of latitude, each with twice as many corners."""
    around = 2 * rings
    south, east = np.meshgrid(
        np.linspace(0, pi, rings + 1),
        np.linspace(0, 2 * pi, around, endpoint=False),
        indexing="ij",
    )
    at = np.stack([np.sin(south) * np.cos(east), np.sin(south) * np.sin(east), np.cos(south)], -1)
    ring, slice_ = np.divmod(np.arange(rings * around), around)
    a, b = ring * around + slice_, ring * around + (slice_ + 1) % around
    # At the poles one of the two has no area.
    lower = np.stack([a, a + around, b + around], 1)[:-around]
    upper = np.stack([a, b + around, b], 1)[around:]
    return Mesh(radius * at.reshape(-1, 3), np.concatenate([lower, upper]).astype(np.int32))


def relief_of(terrain: Terrain, color: Color, texture: Painted | None = None) -> Solid:
    """The surface of a height field, two triangles to a cell as :func:`height_at` has them.

    ``texture`` lies over all of it, north up.
    """
    heights = np.array(terrain.heights, float)
    rows, columns = heights.shape
    half = terrain.size / 2
    north, east = np.meshgrid(
        np.linspace(-half, half, rows), np.linspace(-half, half, columns), indexing="ij"
    )
    vertices = np.stack([east, north, heights], -1).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing="ij")
    corner = (row * columns + column).ravel().tolist()
    faces = [
        Face(face, color, texture, None if texture is None else _frame_over(vertices, face, half))
        for a in corner
        for face in ((a, a + 1, a + columns), (a + 1, a + columns + 1, a + columns))
    ]
    return Solid(vertices, tuple(faces), convex=False)


def _frame_over(vertices: Array, triangle: tuple[int, ...], half: float) -> Array:
    """The frame, in the plane of a triangle, of a texture on the square above and below it."""
    a, b, c = vertices[list(triangle)]
    x, y, z = np.cross(b - a, c - a)
    east, north = -x / z, -y / z
    corner = np.array([-half, half, a[2] + east * (-half - a[0]) + north * (half - a[1])])
    side = 2 * half
    return np.stack([corner, [side, 0.0, side * east], [0.0, -side, -side * north]])


def above(solid: Solid, level: float) -> Solid | None:
    """What of a solid stands out of the ground; None for nothing.

    The face that the cut leaves is not made: nobody above the ground can see it.
    """
    heights = solid.vertices[:, 2] - level
    if solid.sphere:
        if abs(heights[0]) >= solid.sphere - _FLAT:
            return solid if heights[0] > 0 else None
        # The disc that a whole ball is drawn as would show what is below the ground.
        whole = _mesh(ball(solid.sphere, _SUNKEN_RINGS), solid.faces[0].color)
        return above(Solid(whole.vertices + solid.vertices, whole.faces), level)
    if heights.min() >= -_FLAT:
        return solid
    if heights.max() <= _FLAT:
        return None
    vertices = [vertex for vertex in solid.vertices if vertex[2] >= level]
    faces = []
    for face in solid.faces:
        polygon = cut(solid.vertices[list(face.corners)], np.array([0.0, 0.0, 1.0]), level)
        if len(polygon) >= 3:
            corners = tuple(range(len(vertices), len(vertices) + len(polygon)))
            vertices.extend(polygon)
            faces.append(Face(corners, face.color, face.texture, face.frame))
    return Solid(np.array(vertices), tuple(faces), solid.convex)


def cut(polygon: Array | Sequence[Array], normal: Array, offset: float) -> list[Array]:
    """The part of a convex polygon where ``normal`` · p ≥ ``offset`` (Sutherland and Hodgman)."""
    points = list(polygon)
    heights = [float(normal @ point) - offset for point in points]
    kept = []
    for k, (point, height) in enumerate(zip(points, heights, strict=True)):
        before, lower = points[k - 1], heights[k - 1]
        if (height >= 0) != (lower >= 0):
            kept.append(before + (point - before) * (lower / (lower - height)))
        if height >= 0:
            kept.append(point)
    return kept


def normals_of(vertices: Array, faces: Iterable[Face]) -> Array:
    """Outward unit normals by Newell's formula, (n, 3)."""
    found = []
    for face in faces:
        points = vertices[list(face.corners)]
        normal = np.cross(points, np.roll(points, -1, 0)).sum(0)
        length = np.linalg.norm(normal)
        found.append(normal / length if length else np.array([0.0, 0.0, 1.0]))
    return np.array(found).reshape(-1, 3)
