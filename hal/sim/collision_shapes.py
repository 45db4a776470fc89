"""Collision shapes in Bullet of the things of a world. World frame, metres."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

from hal.sim.pieces import Piece
from vencejo.geometry import Point, turned
from worlds.solids import bounds_of
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Sphere

_PER_BODY = 16
"""createCollisionShapeArray silently drops every shape after the sixteenth."""
_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""Corners of each face of a cuboid, numbered in the order that ``product`` gives them."""
_TRIANGLES = tuple(corner for a, b, c, d in _FACES for corner in (a, b, c, a, c, d))


def chunks(pieces: Sequence[Piece]) -> Iterator[Sequence[Piece]]:
    """Divide pieces into groups that lie together and are small enough for one body each."""
    if len(pieces) <= _PER_BODY:
        if pieces:
            yield pieces
        return
    spans = [max(p.at[k] for p in pieces) - min(p.at[k] for p in pieces) for k in (0, 1)]
    axis = spans.index(max(spans))
    ordered = sorted(pieces, key=lambda piece: piece.at[axis])
    # The first part fills a whole number of bodies.
    half = max(1, len(pieces) // (2 * _PER_BODY)) * _PER_BODY
    yield from chunks(ordered[:half])
    yield from chunks(ordered[half:])


def compound(p: Any, client: int, pieces: Sequence[Piece]) -> int:
    """Make one collision shape of at most sixteen pieces, none a mesh; its number in Bullet."""
    kinds, halves, radii, lengths = [], [], [], []
    for piece in pieces:
        shape = piece.shape
        # Bullet wants an entry for every shape in each list; 1 where a shape has no use for it.
        half, radius, length = [1.0] * 3, 1.0, 1.0
        if isinstance(shape, Cuboid):
            kind, half = p.GEOM_BOX, [side / 2 for side in shape.size]
        elif isinstance(shape, Cylinder):
            kind, radius, length = p.GEOM_CYLINDER, shape.radius, shape.height
        else:
            assert isinstance(shape, Sphere)
            kind, radius = p.GEOM_SPHERE, shape.radius
        kinds.append(kind)
        halves.append(half)
        radii.append(radius)
        lengths.append(length)
    number: int = p.createCollisionShapeArray(
        shapeTypes=kinds,
        halfExtents=halves,
        radii=radii,
        lengths=lengths,
        collisionFramePositions=[piece.at for piece in pieces],
        collisionFrameOrientations=[piece.attitude for piece in pieces],
        physicsClientId=client,
    )
    return number


def ray_mesh(p: Any, client: int, pieces: Sequence[Piece]) -> int:
    """Make the faces of many cuboids one mesh, for rays alone; its number in Bullet.

    Rays are tested against triangles twice as fast as against boxes, and hit the same places.
    """
    vertices: list[Point] = []
    indices: list[int] = []
    for piece in pieces:
        assert isinstance(piece.shape, Cuboid)
        indices += [len(vertices) + corner for corner in _TRIANGLES]
        sides = piece.shape.size
        for corner in product((-0.5, 0.5), repeat=3):
            own = Point(*(share * side for share, side in zip(corner, sides, strict=True)))
            vertices.append(piece.at.plus(turned(own, piece.attitude)))
    return _triangles(p, client, vertices, indices)


def _triangles(p: Any, client: int, vertices: Any, indices: list[int], **frame: Any) -> int:
    number: int = p.createCollisionShape(
        p.GEOM_MESH,
        vertices=vertices,
        indices=indices,
        flags=p.GEOM_FORCE_CONCAVE_TRIMESH,
        physicsClientId=client,
        **frame,
    )
    return number


def mesh(p: Any, client: int, piece: Piece) -> int:
    """Make a mesh, which need not be convex, for a body that stands still; its number in Bullet."""
    shape = piece.shape
    assert isinstance(shape, Mesh)
    frame = {"collisionFramePosition": piece.at, "collisionFrameOrientation": piece.attitude}
    vertices, faces = shape.vertices.tolist(), shape.faces.ravel().tolist()
    return _triangles(p, client, vertices, faces, **frame)


def boxed(piece: Piece) -> Piece:
    """The piece itself, or the cuboid about a mesh: in Bullet such a mesh cannot move."""
    if not isinstance(piece.shape, Mesh):
        return piece
    low, high = bounds_of(piece.shape, Point(0.0, 0.0, 0.0), UPRIGHT)
    middle = Point(*((a + b) / 2 for a, b in zip(low, high, strict=True)))
    at = piece.at.plus(turned(middle, piece.attitude))
    return Piece(piece.name, Cuboid(high.minus(low)), at, piece.attitude)
