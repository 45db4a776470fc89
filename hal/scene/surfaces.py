"""Surfaces: the faces of things and of terrain, which renderers draw.

The faces of a surface are flat convex polygons, counter-clockwise seen from outside. A sphere is
kept as it is, since what is seen of it depends on the eye.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, sin

import numpy as np

from hal.scene.arrays import Float64s
from hal.scene.textures import Bitmap
from hal.scene.transforms import rotation_matrix
from worlds.things import Color, Cuboid, Cylinder, Mesh, Part, Plate, Sphere, Terrain, Texture

SPHERE_CORNERS = 48
"""Corners of the polygon that a sphere's outline is drawn as."""
_CYLINDER_SIDES = 24
_CUT_SPHERE_RINGS = 16
"""Rings of the mesh that stands for a sphere cut by the ground."""
_TOLERANCE = 1e-7
"""Distances below this count as none: metres, or a share of a mesh's size."""


@dataclass(frozen=True, eq=False)
class Face:
    """A flat convex polygon."""

    corners: tuple[int, ...]
    """Indices of the surface's vertices."""
    color: Color
    texture: Texture | Bitmap | None = None
    texture_frame: Float64s | None = None
    """The place of the texture in the plane of the face, (3, 3): its upper left corner, the vector
    along its upper edge and the one down its left edge."""


@dataclass(frozen=True, eq=False)
class Surface:
    """The surface of one part of a thing, or of terrain, metres."""

    vertices: Float64s
    """(n, 3)."""
    faces: tuple[Face, ...]
    convex: bool = True
    """True when it bounds a convex solid."""
    sphere_radius: float = 0.0
    """Above 0 for a sphere about the only vertex."""
    leafy: bool = False
    """True for a sphere that is drawn with light and dark leaves."""


def surface_of(part: Part) -> Surface:
    """The surface of a part, in the frame of its thing."""
    return placed(_own_surface(part), rotation_matrix(part.attitude), np.array(part.at))


def placed(surface: Surface, rotation: Float64s, origin: Float64s) -> Surface:
    """The surface in an outer frame, where its own frame has that rotation (3 × 3) and origin."""
    faces = tuple(
        face
        if face.texture_frame is None
        else Face(
            face.corners,
            face.color,
            face.texture,
            np.vstack(
                [rotation @ face.texture_frame[0] + origin, face.texture_frame[1:] @ rotation.T]
            ),
        )
        for face in surface.faces
    )
    vertices = surface.vertices @ rotation.T + origin
    return Surface(vertices, faces, surface.convex, surface.sphere_radius, surface.leafy)


# The shapes of parts, each in its own frame.


def _own_surface(part: Part) -> Surface:
    shape, color = part.shape, part.color
    if isinstance(shape, Cuboid):
        return _cuboid(shape, color, part.texture)
    if isinstance(shape, Plate):
        return _plate(shape, color, part.texture)
    if isinstance(shape, Cylinder):
        return _cylinder(shape, color)
    if isinstance(shape, Sphere):
        face = Face((0,) * SPHERE_CORNERS, color)
        return Surface(np.zeros((1, 3)), (face,), sphere_radius=shape.radius, leafy=shape.leafy)
    return _mesh(shape, color)


def _rectangle(
    vertices: Float64s, corners: tuple[int, ...], color: Color, texture: Texture | None
) -> Face:
    """A rectangle by its lower left, lower right, upper right and upper left corner."""
    if texture is None:
        return Face(corners, color)
    lower, _, right, left = (vertices[corner] for corner in corners)
    return Face(corners, color, texture, np.stack([left, right - left, lower - left]))


def _cuboid(shape: Cuboid, color: Color, texture: Texture | None) -> Surface:
    x, y, z = (side / 2 for side in shape.size)
    vertices = np.array([[a, b, c] for c in (-z, z) for b in (-y, y) for a in (-x, x)])
    # Lower left first, seen from outside; on the sides +z is up, on top and below +y is.
    sides = ((0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6), (4, 5, 7, 6), (1, 0, 2, 3))
    return Surface(vertices, tuple(_rectangle(vertices, side, color, texture) for side in sides))


def _plate(shape: Plate, color: Color, texture: Texture | None) -> Surface:
    x, y = shape.width / 2, shape.height / 2
    vertices = np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    return Surface(vertices, (_rectangle(vertices, (0, 1, 2, 3), color, texture),))


def _cylinder(shape: Cylinder, color: Color) -> Surface:
    n, r, z = _CYLINDER_SIDES, shape.radius, shape.height / 2
    ring = [(r * cos(2 * pi * k / n), r * sin(2 * pi * k / n)) for k in range(n)]
    vertices = np.array([(x, y, h) for h in (-z, z) for x, y in ring])
    sides = [Face((a, b, b + n, a + n), color) for a, b in pairwise([*range(n), 0])]
    caps = [Face(tuple(range(n, 2 * n)), color), Face(tuple(reversed(range(n))), color)]
    return Surface(vertices, (*sides, *caps))


def _mesh(shape: Mesh, color: Color) -> Surface:
    vertices = np.asarray(shape.vertices, np.float64)
    faces = np.asarray(shape.faces)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    # Triangles without area have no normal and are left out.
    faces, a, normals = faces[lengths > 0], a[lengths > 0], normals[lengths > 0]
    normals /= lengths[lengths > 0, None]
    # It is convex when no vertex lies outside the plane of any face.
    size = float(np.abs(vertices).max(initial=1.0))
    heights = normals @ vertices.T - np.einsum("ij,ij->i", normals, a)[:, None]
    convex = bool((heights <= _TOLERANCE * size).all())
    corners = [tuple(int(corner) for corner in face) for face in faces]
    return Surface(vertices, tuple(Face(corner, color) for corner in corners), convex)


def sphere_mesh(radius: float, rings: int) -> Mesh:
    """A sphere as triangles: ``rings`` bands between circles of latitude of 2 × ``rings`` corners.

    ``radius`` is in metres.
    """
    around = 2 * rings
    south, east = np.meshgrid(
        np.linspace(0, pi, rings + 1),
        np.linspace(0, 2 * pi, around, endpoint=False),
        indexing="ij",
    )
    unit = np.stack([np.sin(south) * np.cos(east), np.sin(south) * np.sin(east), np.cos(south)], -1)
    ring, place = np.divmod(np.arange(rings * around), around)
    a, b = ring * around + place, ring * around + (place + 1) % around
    # A cell between two circles is two triangles; at the poles one of them has no area.
    lower = np.stack([a, a + around, b + around], 1)[:-around]
    upper = np.stack([a, b + around, b], 1)[around:]
    return Mesh(radius * unit.reshape(-1, 3), np.concatenate([lower, upper]).astype(np.int32))


# Terrain.


def terrain_surface(terrain: Terrain, color: Color, texture: Bitmap | None = None) -> Surface:
    """The surface of a height field, two triangles to a cell.

    A cell is split as :func:`worlds.terrain.height_at` has it. ``texture`` lies over all of it,
    north up.
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
    triangles = [
        triangle
        for a in corner
        for triangle in ((a, a + 1, a + columns), (a + 1, a + columns + 1, a + columns))
    ]
    faces = [
        Face(corners, color)
        if texture is None
        else Face(corners, color, texture, _frame_from_above(vertices[list(corners)], half))
        for corners in triangles
    ]
    return Surface(vertices, tuple(faces), convex=False)


def _frame_from_above(triangle: Float64s, half: float) -> Float64s:
    """The frame, in the plane of a triangle (3, 3), of a texture that is projected straight down.

    The texture covers a square about the origin with half of that side, metres.
    """
    a, b, c = triangle
    x, y, z = np.cross(b - a, c - a)
    slope_east, slope_north = -x / z, -y / z
    height = a[2] + slope_east * (-half - a[0]) + slope_north * (half - a[1])
    side = 2 * half
    return np.stack(
        [
            np.array([-half, half, height]),
            [side, 0.0, side * slope_east],
            [0.0, -side, -side * slope_north],
        ]
    )


# Geometry of faces.


def part_above(surface: Surface, level: float) -> Surface | None:
    """The part of a surface that lies above a height; None where there is none.

    The hole that the cut leaves is not closed: an eye above that height cannot look into it.
    """
    heights = surface.vertices[:, 2] - level
    if surface.sphere_radius:
        if abs(heights[0]) >= surface.sphere_radius - _TOLERANCE:
            return surface if heights[0] > 0 else None
        # The disc that a whole sphere is drawn as would show what is below the ground.
        whole = _mesh(sphere_mesh(surface.sphere_radius, _CUT_SPHERE_RINGS), surface.faces[0].color)
        return part_above(Surface(whole.vertices + surface.vertices, whole.faces), level)
    if heights.min() >= -_TOLERANCE:
        return surface
    if heights.max() <= _TOLERANCE:
        return None
    vertices = [vertex for vertex in surface.vertices if vertex[2] >= level]
    faces = []
    for face in surface.faces:
        polygon = clip_polygon(
            surface.vertices[list(face.corners)], np.array([0.0, 0.0, 1.0]), level
        )
        if len(polygon) >= 3:
            corners = tuple(range(len(vertices), len(vertices) + len(polygon)))
            vertices.extend(polygon)
            faces.append(Face(corners, face.color, face.texture, face.texture_frame))
    return Surface(np.array(vertices), tuple(faces), surface.convex)


def clip_polygon(
    polygon: Float64s | Sequence[Float64s], normal: Float64s, offset: float
) -> list[Float64s]:
    """The corners of the part of a convex polygon where ``normal`` · p ≥ ``offset``.

    I. E. Sutherland, G. W. Hodgman, *Reentrant polygon clipping*, 1974.
    """
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


def face_normals(vertices: Float64s, faces: Iterable[Face]) -> Float64s:
    """Outward unit normals of faces by Newell's formula, (n, 3); up where a face has no area."""
    found = []
    for face in faces:
        points = vertices[list(face.corners)]
        normal = np.cross(points, np.roll(points, -1, 0)).sum(0)
        length = np.linalg.norm(normal)
        found.append(normal / length if length else np.array([0.0, 0.0, 1.0]))
    return np.array(found).reshape(-1, 3)
