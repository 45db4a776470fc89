"""The geometry of a scene as arrays: what stands still is laid out once, what moves placed anew."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hal.raster.depth_order import separating_plane
from hal.scene.arrays import Bools, Float64s
from hal.scene.scene import Scene
from hal.scene.surfaces import (
    SPHERE_CORNERS,
    Face,
    Surface,
    face_normals,
    part_above,
    placed,
    surface_of,
)
from hal.scene.transforms import rotation_matrix
from vencejo.geometry import Pose


@dataclass(frozen=True, eq=False)
class _Slices:
    """The rows of one moving thing in the arrays."""

    key: str
    """The thing's key in the scene."""
    surfaces: slice
    vertices: slice
    faces: slice
    frames: slice


class GeometryBuffers:
    """Vertices, faces and texture frames of all surfaces of a scene, in common arrays.

    World frame, metres. A surface of n vertices and m faces owns n rows of the vertex arrays and m
    of the face arrays; a sphere owns SPHERE_CORNERS vertices and one face, which
    :meth:`face_spheres` turns towards the eye.
    """

    def __init__(self, scene: Scene, terrain: Surface | None = None) -> None:
        """``terrain``: ground that is not flat. Without it, what lies below z = 0 is left out."""
        self.surfaces: list[Surface] = []
        self.owner: list[int] = []
        """For each surface, the number of the moving thing it belongs to; −1 for what is still."""
        for thing in scene.still:
            rotation, origin = rotation_matrix(thing.attitude), np.array(thing.at)
            for part in thing.parts:
                surface = placed(surface_of(part), rotation, origin)
                seen = part_above(surface, 0.0) if terrain is None else surface
                if seen is not None:
                    self._add(seen, -1)
        if terrain is not None:
            self._add(terrain, -1)
        for number, thing in enumerate(scene.moving.values()):
            for part in thing.parts:
                self._add(surface_of(part), number)
        self._lay_out_vertices()
        self._lay_out_faces()
        self._lay_out_bounds()
        self._moving = [self._slices(number, key) for number, key in enumerate(scene.moving)]
        self._separating_planes: dict[tuple[int, int], tuple[Float64s, float] | None] = {}
        self._poses: list[tuple[Float64s, Float64s]] = [(np.eye(3), np.zeros(3))] * len(
            self._moving
        )
        self.visible = np.ones(len(self.surfaces), bool)
        """For each surface, whether it is in the scene at the moment."""

    def _add(self, surface: Surface, owner: int) -> None:
        self.surfaces.append(surface)
        self.owner.append(owner)

    def _lay_out_vertices(self) -> None:
        surfaces = self.surfaces
        sizes = [SPHERE_CORNERS if s.sphere_radius else len(s.vertices) for s in surfaces]
        self.vertex_start = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        """First vertex of each surface, and the number of vertices at the end."""
        self.own_vertices = np.concatenate(
            [
                np.repeat(s.vertices, SPHERE_CORNERS, 0) if s.sphere_radius else s.vertices
                for s in surfaces
            ]
            or [np.zeros((0, 3))]
        )
        """(n, 3), in the frame of the thing where that moves."""
        self.vertices = self.own_vertices.copy()

    def _lay_out_faces(self) -> None:
        surfaces = self.surfaces
        self.faces: list[Face] = [face for surface in surfaces for face in surface.faces]
        counts = [len(surface.faces) for surface in surfaces]
        self.face_start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        """First face of each surface, and the number of faces at the end."""
        self.surface_of_face = np.repeat(np.arange(len(surfaces)), counts)
        corner_counts = [len(face.corners) for face in self.faces]
        self.corner_start = np.concatenate([[0], np.cumsum(corner_counts)]).astype(np.int64)
        """First corner of each face, and the number of corners at the end."""
        owners = self.surface_of_face.tolist()
        bases = self.vertex_start[self.surface_of_face].tolist()
        self.corners = np.array(
            [
                corner + base
                for face, base, owner in zip(self.faces, bases, owners, strict=True)
                for corner in (
                    range(SPHERE_CORNERS) if surfaces[owner].sphere_radius else face.corners
                )
            ],
            np.int64,
        )
        """Indices of vertices."""
        self.own_normals = np.concatenate(
            [face_normals(s.vertices, s.faces) for s in surfaces] or [np.zeros((0, 3))]
        )
        self.normals = self.own_normals.copy()
        """Outward unit normals of faces, (m, 3)."""
        self.offsets = self._plane_offsets(slice(None))
        """Offsets of the planes of faces, metres: a plane is where normal · p is its offset."""
        self.colors = np.array([face.color for face in self.faces], float).reshape(-1, 3)
        """Red, green and blue of faces, (m, 3)."""
        framed = [k for k, face in enumerate(self.faces) if face.texture_frame is not None]
        self.frame_of_face = {face: number for number, face in enumerate(framed)}
        """Rows of the texture frames, by face."""
        frames = [f.texture_frame for f in self.faces if f.texture_frame is not None]
        self._own_frames = np.array(frames).reshape(-1, 3, 3)
        self.frames = self._own_frames.copy()
        """Texture frames (see :class:`hal.scene.surfaces.Face`), (k, 3, 3)."""

    def _lay_out_bounds(self) -> None:
        count = len(self.surfaces)
        self.sphere_radius = np.array([surface.sphere_radius for surface in self.surfaces])
        """0 for a surface that is no sphere."""
        self.leafy = np.array([surface.leafy for surface in self.surfaces], bool)
        self._spheres = np.flatnonzero(self.sphere_radius)
        self.convex = np.array([surface.convex for surface in self.surfaces], bool)
        self.centers = np.zeros((count, 3))
        """Centres of the bounding spheres of surfaces, (n, 3)."""
        self.bounding_radius = np.zeros(count)
        self.boxes = np.zeros((count, 6))
        """Lowest and highest x, y, z of each surface, (n, 6)."""
        for number, surface in enumerate(self.surfaces):
            low, high = surface.vertices.min(0), surface.vertices.max(0)
            self.centers[number] = (low + high) / 2
            around = surface.vertices - self.centers[number]
            farthest = np.sqrt((around**2).sum(1).max())
            self.bounding_radius[number] = farthest + surface.sphere_radius
            self.boxes[number, :3] = low - surface.sphere_radius
            self.boxes[number, 3:] = high + surface.sphere_radius
        self._own_centers = self.centers.copy()

    def _slices(self, number: int, key: str) -> _Slices:
        """The slices of a moving thing; empty for one without parts."""
        mine = [k for k, owner in enumerate(self.owner) if owner == number]
        first, last = (mine[0], mine[-1] + 1) if mine else (len(self.surfaces),) * 2
        faces = slice(int(self.face_start[first]), int(self.face_start[last]))
        frames = [n for face, n in self.frame_of_face.items() if faces.start <= face < faces.stop]
        return _Slices(
            key,
            slice(first, last),
            slice(int(self.vertex_start[first]), int(self.vertex_start[last])),
            faces,
            slice(frames[0], frames[-1] + 1) if frames else slice(0, 0),
        )

    def _plane_offsets(self, faces: slice) -> Float64s:
        anchors = self.vertices[self.corners[self.corner_start[:-1][faces]]]
        return np.asarray(np.einsum("ij,ij->i", self.normals[faces], anchors), np.float64)

    def place(self, poses: Mapping[str, Pose]) -> None:
        """Put what moves where it is, by the scene's keys; what has no pose is not seen."""
        for number, moving in enumerate(self._moving):
            pose = poses.get(moving.key)
            self.visible[moving.surfaces] = pose is not None
            if pose is None:
                continue
            rotation, origin = rotation_matrix(pose[1]), np.array(pose[0])
            self._poses[number] = (rotation, origin)
            self.vertices[moving.vertices] = (
                self.own_vertices[moving.vertices] @ rotation.T + origin
            )
            self.normals[moving.faces] = self.own_normals[moving.faces] @ rotation.T
            self.offsets[moving.faces] = self._plane_offsets(moving.faces)
            self.centers[moving.surfaces] = self._own_centers[moving.surfaces] @ rotation.T + origin
            frames = self._own_frames[moving.frames] @ rotation.T
            frames[:, 0] += origin
            self.frames[moving.frames] = frames
            first, last = moving.vertices.start, moving.vertices.stop
            if last > first:
                starts = self.vertex_start[moving.surfaces] - first
                vertices = self.vertices[first:last]
                radius = self.sphere_radius[moving.surfaces, None]
                self.boxes[moving.surfaces, :3] = np.minimum.reduceat(vertices, starts) - radius
                self.boxes[moving.surfaces, 3:] = np.maximum.reduceat(vertices, starts) + radius

    def face_spheres(self, eye: Float64s, seen: Bools) -> None:
        """Make spheres the discs that are seen of them from ``eye``; only those that are ``seen``.

        The rim of a disc is the circle where lines from the eye touch the sphere.
        """
        which = self._spheres[seen[self._spheres]]
        if not len(which):
            return
        radius, center = self.sphere_radius[which], self.centers[which]
        away = eye - center
        distance = np.sqrt((away * away).sum(1))
        # An eye within the sphere sees it as from just outside.
        inside = distance <= radius * 1.001
        distance = np.where(inside, radius * 1.001, distance)
        axis = away / distance[:, None]
        disc_center = center + axis * (radius**2 / distance)[:, None]
        disc_radius = radius * np.sqrt(1 - (radius / distance) ** 2)
        helper = np.where(np.abs(axis[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
        across = np.cross(helper, axis)
        across /= np.sqrt((across * across).sum(1))[:, None]
        up = np.cross(axis, across)
        discs = disc_center[:, None] + disc_radius[:, None, None] * (
            _COS[None, :, None] * across[:, None] + _SIN[None, :, None] * up[:, None]
        )
        for number, disc, normal in zip(which.tolist(), discs, axis, strict=True):
            start, face = self.vertex_start[number], self.face_start[number]
            self.vertices[start : start + SPHERE_CORNERS] = disc
            self.normals[face] = normal
            self.offsets[face] = normal @ disc[0]

    def side(self, a: int, b: int, eye: Float64s) -> int:
        """1 when surface a is in front of b for an eye, −1 when it is behind, 0 when neither."""
        if not (self.convex[a] and self.convex[b]):
            return 0
        plane = self._plane_between(a, b)
        if plane is None:
            return 0
        if self.owner[a] == self.owner[b] >= 0:
            rotation, origin = self._poses[self.owner[a]]
            eye = (eye - origin) @ rotation
        return 1 if plane[0] @ eye <= plane[1] else -1

    def _plane_between(self, a: int, b: int) -> tuple[Float64s, float] | None:
        """A plane that separates two surfaces, kept for those that do not move against each other.

        World frame; for two of one moving thing, that thing's frame.
        """
        if self.owner[a] != self.owner[b]:
            return self._separate(a, b, own=False)
        if (a, b) not in self._separating_planes:
            self._separating_planes[a, b] = self._separate(a, b, own=self.owner[a] >= 0)
        return self._separating_planes[a, b]

    def _separate(self, a: int, b: int, own: bool) -> tuple[Float64s, float] | None:
        normals = self.own_normals if own else self.normals
        one, other = self._hull(a, own), self._hull(b, own)
        axes = [normals[self.face_start[k] : self.face_start[k + 1]] for k in (a, b)]
        if self.sphere_radius[a] or self.sphere_radius[b]:
            axes.append((one[:, None] - other[None]).reshape(-1, 3))
            axes.append(one.mean(0)[None] - other.mean(0)[None])
            axes.extend(_from_lines(p, q) for p, q in ((one, other), (other, one)) if len(p) == 1)
        else:
            edges = [self._edges(k, own) for k in (a, b)]
            axes.append(np.cross(edges[0][:, None], edges[1][None]).reshape(-1, 3))
        radii = float(self.sphere_radius[a]), float(self.sphere_radius[b])
        return separating_plane(one, other, np.concatenate(axes), *radii)

    def _hull(self, surface: int, own: bool) -> Float64s:
        """Points that span a surface, (n, 3); of a sphere its centre alone.

        ``own``: in the frame of its moving thing.
        """
        if self.sphere_radius[surface]:
            centers = self._own_centers if own else self.centers
            return np.asarray(centers[surface : surface + 1], np.float64)
        first, last = self.vertex_start[surface : surface + 2].tolist()
        return np.asarray((self.own_vertices if own else self.vertices)[first:last], np.float64)

    def hull(self, surface: int) -> Float64s:
        """Points that span a surface, (n, 3), world frame; those of a sphere lie on it."""
        if self.sphere_radius[surface]:
            radius = self.sphere_radius[surface]
            return np.asarray(self.centers[surface] + radius * _UNIT_SPHERE, np.float64)
        return self._hull(surface, own=False)

    def _edges(self, surface: int, own: bool) -> Float64s:
        """Unit directions of a surface's edges, (n, 3), parallel ones once."""
        vertices = self.own_vertices if own else self.vertices
        found: dict[tuple[int, int], None] = {}
        base = int(self.vertex_start[surface])
        for face in self.surfaces[surface].faces:
            for p, q in zip(face.corners, face.corners[1:] + face.corners[:1], strict=True):
                found[min(p, q) + base, max(p, q) + base] = None
        pairs = np.array(list(found), np.int64)
        edges = vertices[pairs[:, 1]] - vertices[pairs[:, 0]]
        edges = edges / np.maximum(np.sqrt((edges * edges).sum(1)), 1e-12)[:, None]
        # Opposite directions are one.
        signs = np.sign(edges @ np.array([1.0, 1e-4, 1e-8]))[:, None]
        return np.asarray(np.unique(np.round(edges * signs, 9), axis=0), np.float64)


def _from_lines(point: Float64s, corners: Float64s) -> Float64s:
    """Vectors to a point (1, 3) from the nearest places of the lines between all corners (n, 3)."""
    if len(corners) < 2:
        return corners - point
    first, second = np.triu_indices(len(corners), 1)
    along = corners[second] - corners[first]
    share = ((point - corners[first]) * along).sum(1) / np.maximum((along * along).sum(1), 1e-12)
    nearest = corners[first] + np.clip(share, 0, 1)[:, None] * along
    return np.asarray(point - nearest, np.float64)


_UNIT_SPHERE = np.array(
    [
        (np.cos(east) * np.cos(north), np.sin(east) * np.cos(north), np.sin(north))
        for east in np.linspace(0, 2 * np.pi, 16, endpoint=False)
        for north in np.linspace(-np.pi / 2, np.pi / 2, 9)
    ]
)
_ANGLES = np.linspace(0, 2 * np.pi, SPHERE_CORNERS, endpoint=False)
_COS, _SIN = np.cos(_ANGLES), np.sin(_ANGLES)
