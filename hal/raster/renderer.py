"""The renderer: pictures of a world from numpy and OpenCV's drawing, without OpenGL.

What stands on the ground is painted as polygons from far to near, each on exactly the pixels whose
centres it covers; the ground is warped from painted tiles. One thread, no state but caches: equal
arguments give equal pictures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from hal.raster.buffers import Pose, Scene
from hal.raster.depth_buffer import draw_knot
from hal.raster.depth_order import paint_order
from hal.raster.ground import Band, GroundPainter, GroundView
from hal.raster.shadow_polygons import Shadows
from hal.scene.ground_texture import drape
from hal.scene.ground_tiles import Tiles, filled
from hal.scene.scanlines import Outlines, Spans, outlines, spans
from hal.scene.surfaces import Array, cut, relief_of, rotation
from hal.scene.textures import picture_of
from hal.vehicle import Intrinsics
from worlds.model import World
from worlds.motion import pose_at
from worlds.things import Thing

Pixels = NDArray[np.uint8]

NEAR = 0.02
"""What is nearer than this to the camera's plane is not seen, metres."""


@dataclass(frozen=True, eq=False)
class _Shot:
    """One picture to be taken."""

    eye: Array
    turn: Array
    """Rotates optical axes into the world."""
    matrix: Array
    width: int
    height: int

    def to_camera(self, points: Array) -> Array:
        return (points - self.eye) @ self.turn

    def to_pixels(self, points: Array) -> Array:
        """Of points in camera axes."""
        m = self.matrix
        depth = points[..., 2]
        return np.stack(
            [
                m[0, 0] * points[..., 0] / depth + m[0, 2],
                m[1, 1] * points[..., 1] / depth + m[1, 2],
            ],
            -1,
        )


@dataclass(frozen=True, eq=False)
class _Faces:
    """The faces that a picture shows, as polygons in it."""

    numbers: NDArray[np.int64]
    """Of each in the scene."""
    points: Array
    starts: NDArray[np.int64]


class Raster:
    """Renders a world (see :class:`hal.renderers.Renderer`)."""

    def __init__(self, world: World, vehicles: Mapping[str, Thing], shadows: bool = False) -> None:
        """Raises UserError for a picture or marker that is none."""
        cv2.setNumThreads(1)
        moving = {thing.name: thing for thing in world.things if thing.motion}
        still = [thing for thing in world.things if not thing.motion]
        # A space keeps the names of vehicles apart from those of things.
        looks = {f" {name}": thing for name, thing in vehicles.items()}
        terrain, color = world.ground.terrain, world.ground.color
        self._tiles = Tiles(world.ground)
        painted = drape(self._tiles, terrain.size) if terrain else None
        relief = relief_of(terrain, color, painted) if terrain else None
        self._scene = Scene(still, {**moving, **looks}, relief)
        self._ground = GroundPainter(self._tiles)
        self._light = world.light
        sun = np.array(world.light.sun, float)
        self._sun = sun / np.linalg.norm(sun)
        ambient = world.light.ambient
        self._flat = ambient + (1 - ambient) * max(float(self._sun[2]), 0.0)
        """What the flat ground shows of its colour before everything is made as bright as it."""
        red, green, blue = world.light.sky
        self._sky = (blue, green, red, 255)
        self._shadows = Shadows(self._scene, self._sun) if shadows and not terrain else None
        self._moving = moving
        for face in self._scene.faces:
            if face.texture is not None:
                picture_of(face.texture)

    def render(
        self, pose: Pose, intrinsics: Intrinsics, time: float, vehicles: Mapping[str, Pose]
    ) -> Pixels:
        """See :class:`hal.renderers.Renderer`."""
        shot = _shot(pose, intrinsics)
        places = {name: pose_at(thing, time) for name, thing in self._moving.items()}
        flying = {f" {name}": pose for name, pose in vehicles.items()}
        self._scene.place({**places, **flying})
        image = filled(shot.width, shot.height, self._sky)
        view = GroundView(shot.eye, shot.turn, shot.matrix, float(shot.eye[2]))
        bands = view.bands(shot.width, shot.height)
        faces = self._faces(shot)
        points = np.concatenate([*(band.corners for band in bands), faces.points])
        sizes = np.array([len(band.corners) for band in bands], np.int64)
        starts = np.concatenate([[0], np.cumsum(sizes), faces.starts[1:] + sizes.sum()])
        covered = spans(points, starts.astype(np.int64), shot.width, shot.height)
        outline = outlines(covered)
        self._draw_ground(image, view, bands, outline)
        if self._shadows is not None and bands:
            self._darken(image, shot, self._shadows)
        self._draw_faces(image, shot, faces, covered, outline, len(bands))
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGRA2BGR), np.uint8)

    def close(self) -> None:
        """See :class:`hal.renderers.Renderer`: there is nothing but memory to give back."""

    # The ground.

    def _draw_ground(
        self, image: Pixels, view: GroundView, bands: Sequence[Band], outline: Outlines
    ) -> None:
        for run, polygon in enumerate(outline.polygon):
            if polygon >= len(bands):
                return
            points = outline.points[outline.start[run] : outline.start[run + 1]]
            box = _box(points)
            left, top, right, bottom = box
            x = points[:, 0]
            if ((x == left) | (x == right - 1)).all():
                part = image[top:bottom, left:right]
                self._ground.draw(view, bands[polygon], box, part)
            else:
                _paste(image, self._ground.draw(view, bands[polygon], box), points, box)

    def _darken(self, image: Pixels, shot: _Shot, shadows: Shadows) -> None:
        polygons = []
        for corners in shadows.polygons():
            points = cut(shot.to_camera(corners), _AHEAD, NEAR)
            if len(points) >= 3:
                polygons.append(shot.to_pixels(np.array(points)))
        if not polygons:
            return
        starts = np.cumsum([0, *map(len, polygons)])
        found = outlines(spans(np.concatenate(polygons), starts, shot.width, shot.height))
        mask = np.zeros((shot.height, shot.width), np.uint8)
        for run in range(len(found.polygon)):
            cv2.fillConvexPoly(mask, found.points[found.start[run] : found.start[run + 1]], 255)
        cv2.copyTo(cv2.convertScaleAbs(image, alpha=self._light.ambient / self._flat), mask, image)

    # What stands on it.

    def _faces(self, shot: _Shot) -> _Faces:
        scene = self._scene
        seen = scene.shown & _in_view(shot, scene.middles, scene.reach)
        scene.outline_spheres(shot.eye, seen)
        facing = scene.normals @ shot.eye > scene.offsets + 1e-9
        numbers = np.flatnonzero(facing & seen[scene.solid_of_face])
        if not len(numbers):
            return _Faces(numbers, np.zeros((0, 2)), np.zeros(1, np.int64))
        counts = np.diff(scene.corner_start)[numbers]
        ends = np.cumsum(counts)
        which = np.arange(ends[-1]) + np.repeat(
            scene.corner_start[numbers] - (ends - counts), counts
        )
        points = shot.to_camera(scene.world[scene.corners[which]])
        nearest = np.minimum.reduceat(points[:, 2], ends - counts)
        if nearest.min() < NEAR:
            # Cut those that reach behind the camera; what is left of each follows in its place.
            polygons = [
                polygon if near >= NEAR else np.array(cut(polygon, _AHEAD, NEAR)).reshape(-1, 3)
                for polygon, near in zip(np.split(points, ends[:-1]), nearest.tolist(), strict=True)
            ]
            left = [k for k, polygon in enumerate(polygons) if len(polygon) >= 3]
            numbers, polygons = numbers[left], [polygons[k] for k in left]
            if not polygons:
                return _Faces(numbers, np.zeros((0, 2)), np.zeros(1, np.int64))
            points = np.concatenate(polygons)
            ends = np.cumsum([len(polygon) for polygon in polygons])
        return _Faces(numbers, shot.to_pixels(points), np.concatenate([[0], ends]))

    def _draw_faces(
        self,
        image: Pixels,
        shot: _Shot,
        faces: _Faces,
        covered: Spans,
        outline: Outlines,
        bands: int,
    ) -> None:
        if not len(faces.numbers):
            return
        scene = self._scene
        owners = scene.solid_of_face[faces.numbers]
        # Faces come in the order of their solids.
        first = np.flatnonzero(np.diff(owners, prepend=-1))
        solids = owners[first]
        groups = self._order(shot, faces, solids, first)
        shades = self._shades(faces.numbers)
        colors = np.rint(scene.colors[faces.numbers][:, ::-1] * shades[:, None])
        colors = np.column_stack([colors, np.full(len(colors), 255.0)])
        turn_of_solid = [0] * len(solids)
        for number, group in enumerate(groups):
            for solid in group:
                turn_of_solid[solid] = number
        convex = scene.convex[solids].tolist()
        knots = {
            number for number, group in enumerate(groups) if len(group) > 1 or not convex[group[0]]
        }
        runs = np.array(outline.polygon, np.int64) - bands
        begin = int(np.searchsorted(runs, 0))
        counts = np.diff(first, append=len(owners))
        turns = np.repeat(np.array(turn_of_solid), counts)[runs[begin:]]
        fill, starts, points = cv2.fillConvexPoly, outline.start, outline.points
        palette = colors.tolist()
        textures = scene.frame_of_face
        turn_of = turns.tolist()
        face_of = runs.tolist()
        number_of = faces.numbers.tolist()
        drawn: set[int] = set()
        for index in np.argsort(turns, kind="stable").tolist():
            turn = turn_of[index]
            run = index + begin
            face = face_of[run]
            if turn in knots:
                if turn not in drawn:
                    drawn.add(turn)
                    mine = np.isin(owners, solids[groups[turn]])
                    self._draw_knot(image, shot, faces, mine, covered, bands, colors, shades)
                continue
            shape = points[starts[run] : starts[run + 1]]
            if number_of[face] in textures:
                box = _box(shape)
                pixels = self._texture(shot, number_of[face], float(shades[face]), box)
                _paste(image, pixels, shape, box)
            else:
                fill(image, shape, palette[face])

    def _order(
        self, shot: _Shot, faces: _Faces, solids: NDArray[np.int64], first: NDArray[np.int64]
    ) -> list[list[int]]:
        scene = self._scene
        begin = faces.starts[first]
        low = np.minimum.reduceat(faces.points, begin)
        high = np.maximum.reduceat(faces.points, begin)
        depths = np.empty((len(solids), 2))
        middle = shot.to_camera(scene.middles[solids])[:, 2]
        corners = (scene.world - shot.eye) @ shot.turn[:, 2]
        starts = scene.vertex_start[:-1]
        depths[:, 0] = np.minimum.reduceat(corners, starts)[solids]
        depths[:, 1] = np.maximum.reduceat(corners, starts)[solids]
        balls = scene.sphere[solids]
        round_ = balls > 0
        depths[round_, 0] = (middle - balls)[round_]
        depths[round_, 1] = (middle + balls)[round_]

        def side(a: int, b: int) -> int:
            return scene.side(int(solids[a]), int(solids[b]), shot.eye)

        return paint_order(
            np.column_stack([low, high]), depths, scene.boxes[solids], shot.eye, side
        )

    def _shades(self, faces: NDArray[np.int64]) -> Array:
        """Brightness of faces; what lies flat is as bright as its colour says."""
        ambient = self._light.ambient
        scene = self._scene
        towards = scene.normals[faces] @ self._sun
        # A ball is one disc: its colour is that of the middle between its bright and dark sides.
        ball = scene.sphere[scene.solid_of_face[faces]] > 0
        towards[ball] = (1 + towards[ball]) / 2
        lit = ambient + (1 - ambient) * np.maximum(towards, 0.0)
        return np.asarray(np.minimum(lit / self._flat, 1.0), np.float64)

    def _texture(
        self, shot: _Shot, face: int, shade: float, box: tuple[int, int, int, int]
    ) -> Pixels:
        """A face's texture as it is seen, on the pixels of a box."""
        texture = self._scene.faces[face].texture
        assert texture is not None
        frame = self._scene.frames[self._scene.frame_of_face[face]].copy()
        frame[0] -= shot.eye
        # Columns: where (u, v, 1) of the texture, 0 to 1, lies in the picture.
        seen = shot.matrix @ (frame @ shot.turn)[[1, 2, 0]].T
        left, top, right, bottom = box
        back = cv2.invert(seen)[1] @ np.array([[1.0, 0, left], [0, 1.0, top], [0, 0, 1.0]])
        pixels = picture_of(texture).level(_step(back, right - left, bottom - top))
        height, width = pixels.shape[:2]
        scale = np.array([[width, 0.0, -0.5], [0.0, height, -0.5], [0.0, 0.0, 1.0]])
        warped = cv2.warpPerspective(
            pixels,
            scale @ back,
            (right - left, bottom - top),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        if shade < 1:
            warped = cv2.convertScaleAbs(warped, alpha=shade)
        return np.asarray(warped, np.uint8)

    def _draw_knot(
        self,
        image: Pixels,
        shot: _Shot,
        faces: _Faces,
        mine: NDArray[np.bool_],
        covered: Spans,
        bands: int,
        colors: Array,
        shades: Array,
    ) -> None:
        scene = self._scene
        polygon = covered.polygon - bands
        rows = polygon >= 0
        rows[rows] = mine[polygon[rows]]
        part = Spans(polygon[rows], covered.y[rows], covered.left[rows], covered.right[rows])
        normals = scene.normals[faces.numbers]
        distances = scene.offsets[faces.numbers] - normals @ shot.eye
        # On a plane n · p = d the inverse depth is n · ray / d.
        to_rays = np.asarray(cv2.invert(shot.matrix)[1], np.float64)
        planes = (normals @ shot.turn) @ to_rays / distances[:, None]
        textured = {}
        for k in np.flatnonzero(mine).tolist():
            rows = part.polygon == k
            if int(faces.numbers[k]) in scene.frame_of_face and rows.any():
                left, right = part.left[rows].min(), part.right[rows].max()
                box = int(left), int(part.y[rows][0]), int(right) + 1, int(part.y[rows][-1]) + 1
                pixels = self._texture(shot, int(faces.numbers[k]), float(shades[k]), box)
                textured[k] = box, pixels
        balls = {}
        for k in np.flatnonzero(mine).tolist():
            solid = int(scene.solid_of_face[faces.numbers[k]])
            if scene.sphere[solid]:
                balls[k] = shot.to_camera(scene.middles[solid]), float(scene.sphere[solid])
        draw_knot(image, part, planes, colors.astype(np.uint8), textured, balls, to_rays)


_AHEAD = np.array([0.0, 0.0, 1.0])


def _shot(pose: Pose, lens: Intrinsics) -> _Shot:
    matrix = np.array([[lens.fx, 0.0, lens.cx], [0.0, lens.fy, lens.cy], [0.0, 0.0, 1.0]])
    return _Shot(np.array(pose[0], float), rotation(pose[1]), matrix, lens.width, lens.height)


def _in_view(shot: _Shot, middles: Array, reach: Array) -> NDArray[np.bool_]:
    """Which balls may show in the picture."""
    x, y, z = shot.to_camera(middles).T
    m = shot.matrix
    seen = z > NEAR - reach
    for along, focal, centre, size in (
        (x, m[0, 0], m[0, 2], shot.width),
        (y, m[1, 1], m[1, 2], shot.height),
    ):
        for sign, edge in ((1.0, centre + 1), (-1.0, size - centre)):
            seen &= sign * focal * along + edge * z > -reach * np.hypot(focal, edge)
    return np.asarray(seen, bool)


def _box(points: NDArray[np.int32]) -> tuple[int, int, int, int]:
    left, top, width, height = cv2.boundingRect(points)
    return left, top, left + width, top + height


def _paste(
    image: Pixels,
    pixels: Pixels,
    outline: NDArray[np.int32],
    box: tuple[int, int, int, int],
) -> None:
    """Put pixels of a box into the image, inside an outline."""
    left, top, right, bottom = box
    mask = np.zeros((bottom - top, right - left), np.uint8)
    cv2.fillConvexPoly(mask, outline - (left, top), 255)
    cv2.copyTo(pixels, mask, image[top:bottom, left:right])


def _step(back: Array, width: int, height: int) -> float:
    """What share of a texture's width a pixel in the middle of a box covers."""
    x, y = (width - 1) / 2, (height - 1) / 2
    u, v, w = (back @ (x, y, 1.0)).tolist()
    (a, b, _), (c, d, _), (e, f, _) = back.tolist()
    across = ((a * w - u * e), (c * w - v * e))
    down = ((b * w - u * f), (d * w - v * f))
    area = abs(across[0] * down[1] - across[1] * down[0]) / max(w**4, 1e-12)
    return float(area**0.5)
