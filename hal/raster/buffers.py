"""Everything to be drawn of a world, as arrays: static solids once, moving ones placed anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hal.raster.depth_order import separating_plane
from hal.scene.surfaces import (
    OUTLINE,
    Array,
    Face,
    Solid,
    above,
    normals_of,
    placed,
    rotation,
    solid_of,
)
from vencejo.geometry import Point, Quaternion
from worlds.things import Thing

Pose = tuple[Point, Quaternion]


@dataclass(frozen=True, eq=False)
class Mover:
    """A thing whose solids are placed anew for every picture."""

    name: str
    thing: Thing
    solids: slice
    vertices: slice
    faces: slice
    frames: slice


class Scene:
    """The solids of a world. Vertices, faces and frames of all of them lie in common arrays."""

    def __init__(
        self, still: Sequence[Thing], moving: Mapping[str, Thing], relief: Solid | None = None
    ) -> None:
        """``relief``: ground that is not flat. Where it is, what is below it is not seen."""
        self.solids: list[Solid] = []
        self.owner: list[int] = []
        """Per solid: number of the mover it belongs to, −1 for what stands still."""
        for thing in still:
            turn, at = rotation(thing.attitude), np.array(thing.at)
            for part in thing.parts:
                solid = placed(solid_of(part), turn, at)
                seen = above(solid, 0.0) if relief is None else solid
                if seen is not None:
                    self._add(seen, -1)
        if relief is not None:
            self._add(relief, -1)
        for number, thing in enumerate(moving.values()):
            for part in thing.parts:
                self._add(solid_of(part), number)
        self._lay_out()
        self.movers = self._movers(moving)
        self._planes: dict[tuple[int, int], tuple[Array, float] | None] = {}
        self._poses: list[tuple[Array, Array]] = [(np.eye(3), np.zeros(3))] * len(self.movers)
        self.shown = np.ones(len(self.solids), bool)

    def _add(self, solid: Solid, owner: int) -> None:
        self.solids.append(solid)
        self.owner.append(owner)

    def _lay_out(self) -> None:
        solids = self.solids
        sizes = [OUTLINE if solid.sphere else len(solid.vertices) for solid in solids]
        self.vertex_start = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        self.local = np.concatenate(
            [
                np.repeat(solid.vertices, OUTLINE, 0) if solid.sphere else solid.vertices
                for solid in solids
            ]
            or [np.zeros((0, 3))]
        )
        self.world = self.local.copy()
        self.faces: list[Face] = [face for solid in solids for face in solid.faces]
        per_solid = [len(solid.faces) for solid in solids]
        self.face_start = np.concatenate([[0], np.cumsum(per_solid)]).astype(np.int64)
        self.solid_of_face = np.repeat(np.arange(len(solids)), per_solid)
        corner_counts = [len(face.corners) for face in self.faces]
        self.corner_start = np.concatenate([[0], np.cumsum(corner_counts)]).astype(np.int64)
        bases = self.vertex_start[self.solid_of_face]
        self.corners = np.array(
            [
                corner + base
                for face, base, solid in zip(
                    self.faces, bases.tolist(), self.solid_of_face.tolist(), strict=True
                )
                for corner in (range(OUTLINE) if solids[solid].sphere else face.corners)
            ],
            np.int64,
        )
        self.local_normals = np.concatenate(
            [normals_of(solid.vertices, solid.faces) for solid in solids] or [np.zeros((0, 3))]
        )
        self.normals = self.local_normals.copy()
        self.offsets = self._offsets(slice(None))
        self.colors = np.array([face.color for face in self.faces], float).reshape(-1, 3)
        self.sphere = np.array([solid.sphere for solid in solids])
        self.convex = np.array([solid.convex for solid in solids], bool)
        self.spheres = np.flatnonzero(self.sphere)
        framed = [k for k, face in enumerate(self.faces) if face.frame is not None]
        self.frame_of_face = {face: number for number, face in enumerate(framed)}
        frames = [face.frame for face in self.faces if face.frame is not None]
        self.local_frames = np.array(frames).reshape(-1, 3, 3)
        self.frames = self.local_frames.copy()
        self.middles = np.zeros((len(solids), 3))
        self.reach = np.zeros(len(solids))
        self.boxes = np.zeros((len(solids), 6))
        for number, solid in enumerate(solids):
            low, high = solid.vertices.min(0), solid.vertices.max(0)
            self.middles[number] = (low + high) / 2
            corners = solid.vertices - self.middles[number]
            self.reach[number] = np.sqrt((corners**2).sum(1).max()) + solid.sphere
            self.boxes[number, :3] = low - solid.sphere
            self.boxes[number, 3:] = high + solid.sphere
        self.local_middles = self.middles.copy()

    def _movers(self, moving: Mapping[str, Thing]) -> list[Mover]:
        movers = []
        for number, (name, thing) in enumerate(moving.items()):
            mine = [k for k, owner in enumerate(self.owner) if owner == number]
            if not mine:
                mine = [len(self.solids)]
                first, last = mine[0], mine[0]
            else:
                first, last = mine[0], mine[-1] + 1
            faces = slice(int(self.face_start[first]), int(self.face_start[last]))
            frames = [
                n for face, n in self.frame_of_face.items() if faces.start <= face < faces.stop
            ]
            movers.append(
                Mover(
                    name,
                    thing,
                    slice(first, last),
                    slice(int(self.vertex_start[first]), int(self.vertex_start[last])),
                    faces,
                    slice(frames[0], frames[-1] + 1) if frames else slice(0, 0),
                )
            )
        return movers

    def _offsets(self, faces: slice) -> Array:
        """Of the planes of faces: normal · corner."""
        anchors = self.world[self.corners[self.corner_start[:-1][faces]]]
        return np.asarray(np.einsum("ij,ij->i", self.normals[faces], anchors), np.float64)

    def place(self, poses: Mapping[str, Pose]) -> None:
        """Put the movers where they are; those without a pose are not seen."""
        for number, mover in enumerate(self.movers):
            pose = poses.get(mover.name)
            self.shown[mover.solids] = pose is not None
            if pose is None:
                continue
            turn, at = rotation(pose[1]), np.array(pose[0])
            self._poses[number] = (turn, at)
            self.world[mover.vertices] = self.local[mover.vertices] @ turn.T + at
            self.normals[mover.faces] = self.local_normals[mover.faces] @ turn.T
            self.offsets[mover.faces] = self._offsets(mover.faces)
            self.middles[mover.solids] = self.local_middles[mover.solids] @ turn.T + at
            frames = self.local_frames[mover.frames] @ turn.T
            frames[:, 0] += at
            self.frames[mover.frames] = frames
            first, last = mover.vertices.start, mover.vertices.stop
            if last > first:
                starts = self.vertex_start[mover.solids] - first
                vertices = self.world[first:last]
                swell = self.sphere[mover.solids, None]
                self.boxes[mover.solids, :3] = np.minimum.reduceat(vertices, starts) - swell
                self.boxes[mover.solids, 3:] = np.maximum.reduceat(vertices, starts) + swell

    def outline_spheres(self, eye: Array, seen: NDArray[np.bool_]) -> None:
        """Give the spheres the outlines that they have from ``eye``, as flat discs facing it."""
        which = self.spheres[seen[self.spheres]]
        if not len(which):
            return
        radius, centre = self.sphere[which], self.middles[which]
        away = eye - centre
        distance = np.sqrt((away * away).sum(1))
        inside = distance <= radius * 1.001
        distance = np.where(inside, radius * 1.001, distance)
        axis = away / distance[:, None]
        # The circle where lines from the eye touch the sphere.
        middle = centre + axis * (radius**2 / distance)[:, None]
        circle = radius * np.sqrt(1 - (radius / distance) ** 2)
        helper = np.where(np.abs(axis[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
        across = np.cross(helper, axis)
        across /= np.sqrt((across * across).sum(1))[:, None]
        up = np.cross(axis, across)
        discs = middle[:, None] + circle[:, None, None] * (
            _COS[None, :, None] * across[:, None] + _SIN[None, :, None] * up[:, None]
        )
        for number, disc, normal in zip(which.tolist(), discs, axis, strict=True):
            start, face = self.vertex_start[number], self.face_start[number]
            self.world[start : start + OUTLINE] = disc
            self.normals[face] = normal
            self.offsets[face] = normal @ disc[0]

    def side(self, a: int, b: int, eye: Array) -> int:
        """Whether solid a is in front of b (1), behind it (−1), or neither can be told (0)."""
        if not (self.convex[a] and self.convex[b]):
            return 0
        plane = self._plane(a, b)
        if plane is None:
            return 0
        if self.owner[a] == self.owner[b] >= 0:
            turn, at = self._poses[self.owner[a]]
            eye = (eye - at) @ turn
        return 1 if plane[0] @ eye <= plane[1] else -1

    def _plane(self, a: int, b: int) -> tuple[Array, float] | None:
        """The plane between two solids, kept for those that do not move against each other."""
        if self.owner[a] != self.owner[b]:
            return self._separate(a, b, self.world, self.normals)
        if (a, b) not in self._planes:
            local = self.owner[a] >= 0
            self._planes[a, b] = self._separate(
                a,
                b,
                self.local if local else self.world,
                self.local_normals if local else self.normals,
            )
        return self._planes[a, b]

    def _separate(
        self, a: int, b: int, vertices: Array, normals: Array
    ) -> tuple[Array, float] | None:
        moving = vertices is self.local
        one, other = self._hull(a, vertices, moving), self._hull(b, vertices, moving)
        axes = [normals[self.face_start[k] : self.face_start[k + 1]] for k in (a, b)]
        if self.sphere[a] or self.sphere[b]:
            axes.append((one[:, None] - other[None]).reshape(-1, 3))
            axes.append(one.mean(0)[None] - other.mean(0)[None])
            axes.extend(_from_edges(p, q) for p, q in ((one, other), (other, one)) if len(p) == 1)
        else:
            edges = [self._edges(k, vertices) for k in (a, b)]
            axes.append(np.cross(edges[0][:, None], edges[1][None]).reshape(-1, 3))
        return separating_plane(
            one, other, np.concatenate(axes), float(self.sphere[a]), float(self.sphere[b])
        )

    def _hull(self, solid: int, vertices: Array, local: bool) -> Array:
        if self.sphere[solid]:
            middles = self.local_middles if local else self.middles
            return np.asarray(middles[solid : solid + 1], np.float64)
        first, last = self.vertex_start[solid : solid + 2].tolist()
        return np.asarray(vertices[first:last], np.float64)

    def hull(self, solid: int) -> Array:
        """Points that span a solid, world frame; of a sphere, those of a ball about it."""
        if self.sphere[solid]:
            return np.asarray(self.middles[solid] + self.sphere[solid] * _BALL, np.float64)
        return self._hull(solid, self.world, False)

    def _edges(self, solid: int, vertices: Array) -> Array:
        """Directions of a solid's edges, each once."""
        found: dict[tuple[int, int], None] = {}
        base = int(self.vertex_start[solid])
        for face in self.solids[solid].faces:
            for p, q in zip(face.corners, face.corners[1:] + face.corners[:1], strict=True):
                found[min(p, q) + base, max(p, q) + base] = None
        pairs = np.array(list(found), np.int64)
        edges = vertices[pairs[:, 1]] - vertices[pairs[:, 0]]
        edges = edges / np.maximum(np.sqrt((edges * edges).sum(1)), 1e-12)[:, None]
        signs = np.sign(edges @ np.array([1.0, 1e-4, 1e-8]))[:, None]
        edges = np.unique(np.round(edges * signs, 9), axis=0)
        return np.asarray(edges, np.float64)


def _from_edges(point: Array, corners: Array) -> Array:
    """From the nearest places on all lines between corners to a point."""
    if len(corners) < 2:
        return corners - point
    first, second = np.triu_indices(len(corners), 1)
    along = corners[second] - corners[first]
    share = ((point - corners[first]) * along).sum(1) / np.maximum((along * along).sum(1), 1e-12)
    nearest = corners[first] + np.clip(share, 0, 1)[:, None] * along
    return np.asarray(point - nearest, np.float64)


_BALL = np.array(
    [
        (np.cos(east) * np.cos(north), np.sin(east) * np.cos(north), np.sin(north))
        for east in np.linspace(0, 2 * np.pi, 16, endpoint=False)
        for north in np.linspace(-np.pi / 2, np.pi / 2, 9)
    ]
)
_ANGLES = np.linspace(0, 2 * np.pi, OUTLINE, endpoint=False)
_COS, _SIN = np.cos(_ANGLES), np.sin(_ANGLES)
