"""The shapes of a world's things, made in Bullet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from vencejo.geometry import Point, Quaternion, turned
from worlds.solids import bounds_of, part_pose, solid_parts
from worlds.things import UPRIGHT, Cuboid, Cylinder, Mesh, Shape, Sphere, Terrain, Thing

_PER_BODY = 16
"""createCollisionShapeArray silently drops every shape after the sixteenth."""


class Piece(NamedTuple):
    """A shape in the frame of the body it belongs to."""

    name: str
    """Of its thing."""
    shape: Shape
    at: Point
    attitude: Quaternion


def pieces_of(thing: Thing) -> list[Piece]:
    """The solid pieces of a thing, world frame; of one that moves, in its own frame."""
    if thing.motion is None:
        return [
            Piece(thing.name, part.shape, *part_pose(part, thing.at, thing.attitude))
            for part in solid_parts(thing)
        ]
    parts = solid_parts(thing)
    return [_boxed(Piece(thing.name, part.shape, part.at, part.attitude)) for part in parts]


def chunks(pieces: Sequence[Piece]) -> Iterator[Sequence[Piece]]:
    """Pieces that make a body together: few enough for Bullet, and near each other."""
    if len(pieces) <= _PER_BODY:
        if pieces:
            yield pieces
        return
    spans = [max(p.at[k] for p in pieces) - min(p.at[k] for p in pieces) for k in (0, 1)]
    axis = spans.index(max(spans))
    ordered = sorted(pieces, key=lambda piece: piece.at[axis])
    # A whole number of full bodies on the left.
    half = max(1, len(pieces) // (2 * _PER_BODY)) * _PER_BODY
    yield from chunks(ordered[:half])
    yield from chunks(ordered[half:])


def compound(p: Any, client: int, pieces: Sequence[Piece]) -> int:
    """One shape of at most sixteen pieces, none a mesh."""
    kinds, halves, radii, lengths = [], [], [], []
    for piece in pieces:
        shape = piece.shape
        # Every list has an entry for every shape; what a shape has no use for is 1.
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


def mesh(p: Any, client: int, piece: Piece) -> int:
    """The triangles of a mesh as they are, for a body that stands still."""
    shape = piece.shape
    assert isinstance(shape, Mesh)
    number: int = p.createCollisionShape(
        p.GEOM_MESH,
        vertices=shape.vertices.tolist(),
        indices=shape.faces.ravel().tolist(),
        flags=p.GEOM_FORCE_CONCAVE_TRIMESH,
        collisionFramePosition=piece.at,
        collisionFrameOrientation=piece.attitude,
        physicsClientId=client,
    )
    return number


def _boxed(piece: Piece) -> Piece:
    """A mesh as the cuboid about it, for a body that moves."""
    if not isinstance(piece.shape, Mesh):
        return piece
    low, high = bounds_of(piece.shape, Point(0.0, 0.0, 0.0), UPRIGHT)
    middle = Point(*((a + b) / 2 for a, b in zip(low, high, strict=True)))
    at = piece.at.plus(turned(middle, piece.attitude))
    return Piece(piece.name, Cuboid(high.minus(low)), at, piece.attitude)


def hills(p: Any, client: int, terrain: Terrain) -> tuple[int, Point]:
    """A height field and where its middle belongs: Bullet centres it between its extremes."""
    rows, count = terrain.heights, len(terrain.heights)
    side = terrain.size / (count - 1)
    number: int = p.createCollisionShape(
        p.GEOM_HEIGHTFIELD,
        meshScale=[side, side, 1.0],
        heightfieldData=[height for row in rows for height in row],
        numHeightfieldRows=count,
        numHeightfieldColumns=count,
        physicsClientId=client,
    )
    low, high = min(map(min, rows)), max(map(max, rows))
    return number, Point(0.0, 0.0, (low + high) / 2)
