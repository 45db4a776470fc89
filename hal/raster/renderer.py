"""The renderer ``raster``: images of a world from numpy and OpenCV's drawing, without OpenGL.

Surfaces are painted as polygons from far to near, each on exactly the pixels whose centres it
covers; the ground is warped from painted tiles. One thread, no state but caches: equal arguments
give equal images.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from hal.raster.buffers import GeometryBuffers
from hal.raster.camera import NEAR, PinholeCamera
from hal.raster.depth_buffer import DepthFaces, Foliage, draw_with_depth_buffer
from hal.raster.depth_order import depth_order
from hal.raster.ground import Band, GroundPainter, GroundProjection
from hal.raster.shadows import Shadows
from hal.scene.arrays import Bools, Box, Float64s, Int32s, Int64s, Pixels
from hal.scene.ground_texture import ground_texture
from hal.scene.ground_tiles import GroundTiles
from hal.scene.scanlines import Outlines, Scanlines, outlines_of, scan_convert
from hal.scene.scene import Scene
from hal.scene.surfaces import terrain_surface
from hal.scene.textures import mipmap_of, uniform_image
from hal.vehicle import Intrinsics
from vencejo.geometry import Pose
from worlds.things import Thing
from worlds.world import World

_TONES = 32
"""Of the leaves of a crown."""
_BRIGHTEST = 1.25
"""Of leaves that face the sun, over that of a level face."""
_DEEPEST = 0.45
"""Share of the ambient light that leaves on the side away from the sun lack."""


@dataclass(frozen=True, eq=False)
class _Polygons:
    """The faces that are seen, as polygons of the image, in the order of their surfaces."""

    faces: Int64s
    """For each polygon, the number of its face in the buffers."""
    points: Float64s
    """Corners of all, (n, 2), pixels."""
    starts: Int64s
    """First corner of each, and the number of corners at the end."""


_NOTHING = _Polygons(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros(1, np.int64))


@dataclass(frozen=True, eq=False)
class _Shading:
    """The light on each polygon."""

    brightness: Float64s
    """Factors of colours and textures, 0 to 1, (n,)."""
    colors: Float64s
    """Colours times those factors, (n, 4), BGRA."""


class Raster:
    """Renders a world (see :class:`hal.renderers.Renderer`)."""

    def __init__(self, world: World, vehicles: Mapping[str, Thing], shadows: bool = False) -> None:
        """Raises UserError for an image file or a marker that cannot be read."""
        cv2.setNumThreads(1)
        self._scene = Scene(world, vehicles)
        terrain, color = world.ground.terrain, world.ground.color
        tiles = GroundTiles(world.ground)
        hills = None
        if terrain:
            hills = terrain_surface(terrain, color, ground_texture(tiles, terrain.size))
        self._geometry = GeometryBuffers(self._scene, hills)
        self._ground = GroundPainter(tiles)
        self._ambient = world.light.ambient
        sun = np.array(world.light.sun, float)
        self._sun = sun / np.linalg.norm(sun)
        self._level_light = self._ambient + (1 - self._ambient) * max(float(self._sun[2]), 0.0)
        """Light on a level face. Everything is shown by it: a level face has its own colour."""
        red, green, blue = world.light.sky
        self._sky = (blue, green, red, 255)
        # On hills no shadows are drawn.
        self._shadows = Shadows(self._geometry, self._sun) if shadows and not terrain else None
        leafy = np.flatnonzero(self._geometry.leafy[self._geometry.surface_of_face])
        self._tones = {face: self._tones_of(face) for face in leafy.tolist()}
        """The tones of the crowns of leaves, by face."""
        for face in self._geometry.faces:
            if face.texture is not None:
                mipmap_of(face.texture)

    def render(
        self, pose: Pose, intrinsics: Intrinsics, time: float, vehicles: Mapping[str, Pose]
    ) -> Pixels:
        """See :class:`hal.renderers.Renderer`."""
        camera = PinholeCamera.at(pose, intrinsics)
        self._geometry.place(self._scene.poses(time, vehicles))
        image = uniform_image(camera.width, camera.height, self._sky)
        ground = GroundProjection(camera)
        bands = ground.bands(camera.width, camera.height)
        polygons = self._project(camera)
        # Bands and faces are converted together: a call costs as much as its pixels.
        points = np.concatenate([*(band.corners for band in bands), polygons.points])
        sizes = np.array([len(band.corners) for band in bands], np.int64)
        starts = np.concatenate([[0], np.cumsum(sizes), polygons.starts[1:] + sizes.sum()])
        scanlines = scan_convert(points, starts.astype(np.int64), camera.width, camera.height)
        outlines = outlines_of(scanlines)
        self._draw_ground(image, ground, bands, outlines)
        if self._shadows is not None and bands:
            self._darken(image, camera, self._shadows)
        if len(polygons.faces):
            count = len(bands)
            self._draw_faces(
                image, camera, polygons, scanlines.without(count), outlines.without(count)
            )
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGRA2BGR), np.uint8)

    def close(self) -> None:
        """See :class:`hal.renderers.Renderer`: there is nothing but memory to give back."""

    # The ground.

    def _draw_ground(
        self, image: Pixels, ground: GroundProjection, bands: Sequence[Band], outlines: Outlines
    ) -> None:
        """Draw the bands: the first polygons of the outlines."""
        for run, polygon in enumerate(outlines.polygon):
            if polygon >= len(bands):
                return
            points = outlines.points[outlines.start[run] : outlines.start[run + 1]]
            box = _bounding_box(points)
            left, top, right, bottom = box
            x = points[:, 0]
            if ((x == left) | (x == right - 1)).all():
                # It fills its box: no mask is needed.
                part = image[top:bottom, left:right]
                self._ground.draw(ground, bands[polygon], box, part)
            else:
                _paste(image, self._ground.draw(ground, bands[polygon], box), points, box)

    def _darken(self, image: Pixels, camera: PinholeCamera, shadows: Shadows) -> None:
        """Darken the ground where shadows fall."""
        polygons = []
        for corners in shadows.polygons():
            clipped = camera.clipped(camera.to_camera(corners))
            if len(clipped) >= 3:
                polygons.append(camera.to_pixels(np.array(clipped)))
        if not polygons:
            return
        starts = np.cumsum([0, *map(len, polygons)])
        points = np.concatenate(polygons)
        found = outlines_of(scan_convert(points, starts, camera.width, camera.height))
        mask = np.zeros((camera.height, camera.width), np.uint8)
        for run in range(len(found.polygon)):
            cv2.fillConvexPoly(mask, found.points[found.start[run] : found.start[run + 1]], 255)
        cv2.copyTo(cv2.convertScaleAbs(image, alpha=self._ambient / self._level_light), mask, image)

    # Faces.

    def _project(self, camera: PinholeCamera) -> _Polygons:
        """The faces that turn towards the camera and lie in its field of view."""
        geometry = self._geometry
        seen = geometry.visible & camera.may_see(geometry.centers, geometry.bounding_radius)
        geometry.face_spheres(camera.eye, seen)
        facing = geometry.normals @ camera.eye > geometry.offsets + 1e-9
        faces = np.flatnonzero(facing & seen[geometry.surface_of_face])
        if not len(faces):
            return _NOTHING
        counts = np.diff(geometry.corner_start)[faces]
        ends = np.cumsum(counts)
        corners = np.arange(ends[-1]) + np.repeat(
            geometry.corner_start[faces] - (ends - counts), counts
        )
        points = camera.to_camera(geometry.vertices[geometry.corners[corners]])
        nearest = np.minimum.reduceat(points[:, 2], ends - counts)
        if nearest.min() < NEAR:
            # Clip those that reach behind the near plane; what is left of each takes its place.
            polygons = [
                polygon if near >= NEAR else np.array(camera.clipped(polygon)).reshape(-1, 3)
                for polygon, near in zip(np.split(points, ends[:-1]), nearest.tolist(), strict=True)
            ]
            left = [k for k, polygon in enumerate(polygons) if len(polygon) >= 3]
            faces, polygons = faces[left], [polygons[k] for k in left]
            if not polygons:
                return _NOTHING
            points = np.concatenate(polygons)
            ends = np.cumsum([len(polygon) for polygon in polygons])
        return _Polygons(faces, camera.to_pixels(points), np.concatenate([[0], ends]))

    def _draw_faces(
        self,
        image: Pixels,
        camera: PinholeCamera,
        polygons: _Polygons,
        scanlines: Scanlines,
        outlines: Outlines,
    ) -> None:
        """Draw the polygons, from far to near."""
        geometry = self._geometry
        owners = geometry.surface_of_face[polygons.faces]
        first = np.flatnonzero(np.diff(owners, prepend=-1))
        surfaces = owners[first]
        groups = self._order(camera, polygons, surfaces, first)
        shading = self._shading(polygons.faces)
        rank_of_surface = [0] * len(surfaces)
        for rank, group in enumerate(groups):
            for surface in group:
                rank_of_surface[surface] = rank
        simple = (geometry.convex[surfaces] & ~geometry.leafy[surfaces]).tolist()
        deep = {rank for rank, group in enumerate(groups) if len(group) > 1 or not simple[group[0]]}
        """Ranks that need a depth buffer; leaves are drawn with it, too."""
        counts = np.diff(first, append=len(owners))
        ranks = np.repeat(np.array(rank_of_surface), counts)[outlines.polygon]
        fill, starts, points = cv2.fillConvexPoly, outlines.start, outlines.points
        # As lists: single elements of arrays take much longer to read.
        colors, rank_of, face_of = shading.colors.tolist(), ranks.tolist(), polygons.faces.tolist()
        drawn: set[int] = set()
        for run in np.argsort(ranks, kind="stable").tolist():
            rank, polygon = rank_of[run], outlines.polygon[run]
            if rank in deep:
                if rank not in drawn:
                    drawn.add(rank)
                    mine = np.isin(owners, surfaces[groups[rank]])
                    part = self._depth_faces(camera, polygons, scanlines, shading, mine)
                    draw_with_depth_buffer(image, part)
                continue
            outline = points[starts[run] : starts[run + 1]]
            face = face_of[polygon]
            if face in geometry.frame_of_face:
                box = _bounding_box(outline)
                pixels = self._texture(camera, face, float(shading.brightness[polygon]), box)
                _paste(image, pixels, outline, box)
            else:
                fill(image, outline, colors[polygon])

    def _order(
        self, camera: PinholeCamera, polygons: _Polygons, surfaces: Int64s, first: Int64s
    ) -> list[list[int]]:
        """Groups of indices of ``surfaces`` from far to near (see :func:`depth_order`).

        ``first`` is the first polygon of each surface.
        """
        geometry = self._geometry
        begin = polygons.starts[first]
        low = np.minimum.reduceat(polygons.points, begin)
        high = np.maximum.reduceat(polygons.points, begin)
        depths = np.empty((len(surfaces), 2))
        middle = camera.to_camera(geometry.centers[surfaces])[:, 2]
        vertices = (geometry.vertices - camera.eye) @ camera.rotation[:, 2]
        starts = geometry.vertex_start[:-1]
        depths[:, 0] = np.minimum.reduceat(vertices, starts)[surfaces]
        depths[:, 1] = np.maximum.reduceat(vertices, starts)[surfaces]
        radii = geometry.sphere_radius[surfaces]
        spheres = radii > 0
        depths[spheres, 0] = (middle - radii)[spheres]
        depths[spheres, 1] = (middle + radii)[spheres]

        def side(a: int, b: int) -> int:
            return geometry.side(int(surfaces[a]), int(surfaces[b]), camera.eye)

        screen = np.column_stack([low, high])
        return depth_order(screen, depths, geometry.boxes[surfaces], camera.eye, side)

    def _shading(self, faces: Int64s) -> _Shading:
        """Diffuse and ambient light on faces, of which a level face shows its own colour."""
        geometry = self._geometry
        cosines = geometry.normals[faces] @ self._sun
        # A sphere is one disc: it is as bright as the middle between its lit and its dark side.
        spheres = geometry.sphere_radius[geometry.surface_of_face[faces]] > 0
        cosines[spheres] = (1 + cosines[spheres]) / 2
        light = self._ambient + (1 - self._ambient) * np.maximum(cosines, 0.0)
        brightness = np.asarray(np.minimum(light / self._level_light, 1.0), np.float64)
        colors = np.rint(geometry.colors[faces][:, ::-1] * brightness[:, None])
        return _Shading(brightness, np.column_stack([colors, np.full(len(colors), 255.0)]))

    def _tones_of(self, face: int) -> Pixels:
        """The tones of a crown of leaves (see :class:`hal.raster.depth_buffer.Foliage`)."""
        cosines = np.linspace(-1.0, 1.0, _TONES)
        lit, shaded = cosines.clip(0.0, None), cosines.clip(None, 0.0)
        light = self._ambient * (1 + _DEEPEST * shaded) + (1 - self._ambient) * lit
        brightness = np.minimum(light / self._level_light, _BRIGHTEST)
        bgr = self._geometry.colors[face][::-1] * brightness[:, None]
        tones = np.column_stack([np.rint(bgr.clip(0, 255)), np.full(_TONES, 255.0)])
        return np.asarray(tones, np.uint8)

    def _texture(self, camera: PinholeCamera, face: int, brightness: float, box: Box) -> Pixels:
        """The texture of a face as it is seen, on the pixels of a box of the image; BGRA."""
        geometry = self._geometry
        texture = geometry.faces[face].texture
        assert texture is not None
        frame = geometry.frames[geometry.frame_of_face[face]].copy()
        frame[0] -= camera.eye
        # Columns: where (u, v, 1) of the texture, 0 to 1, lies in the image.
        to_image = camera.matrix @ (frame @ camera.rotation)[[1, 2, 0]].T
        left, top, right, bottom = box
        in_box = np.array([[1.0, 0, left], [0, 1.0, top], [0, 0, 1.0]])
        to_texture = cv2.invert(to_image)[1] @ in_box
        step = _texture_step(to_texture, right - left, bottom - top)
        pixels = mipmap_of(texture).level(step)
        height, width = pixels.shape[:2]
        to_texels = np.array([[width, 0.0, -0.5], [0.0, height, -0.5], [0.0, 0.0, 1.0]])
        warped = cv2.warpPerspective(
            pixels,
            to_texels @ to_texture,
            (right - left, bottom - top),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        if brightness < 1:
            warped = cv2.convertScaleAbs(warped, alpha=brightness)
        return np.asarray(warped, np.uint8)

    def _depth_faces(
        self,
        camera: PinholeCamera,
        polygons: _Polygons,
        scanlines: Scanlines,
        shading: _Shading,
        mine: Bools,
    ) -> DepthFaces:
        """The polygons that are ``mine``, to be drawn with a depth buffer."""
        geometry = self._geometry
        faces = polygons.faces
        runs = mine[scanlines.polygon]
        part = Scanlines(
            scanlines.polygon[runs], scanlines.y[runs], scanlines.left[runs], scanlines.right[runs]
        )
        normals = geometry.normals[faces]
        distances = geometry.offsets[faces] - normals @ camera.eye
        # On a plane n · p = d, seen along a ray, the inverse depth is n · ray / d.
        to_rays = np.asarray(cv2.invert(camera.matrix)[1], np.float64)
        planes = (normals @ camera.rotation) @ to_rays / distances[:, None]
        textured: dict[int, tuple[Box, Pixels]] = {}
        spheres: dict[int, tuple[Float64s, float]] = {}
        leaves: dict[int, Pixels] = {}
        for k in np.flatnonzero(mine).tolist():
            face = int(faces[k])
            runs = part.polygon == k
            if face in geometry.frame_of_face and runs.any():
                left, right = part.left[runs].min(), part.right[runs].max()
                top, bottom = part.y[runs][0], part.y[runs][-1]
                box = int(left), int(top), int(right) + 1, int(bottom) + 1
                brightness = float(shading.brightness[k])
                textured[k] = box, self._texture(camera, face, brightness, box)
            surface = int(geometry.surface_of_face[face])
            if geometry.sphere_radius[surface]:
                center = camera.to_camera(geometry.centers[surface])
                spheres[k] = center, float(geometry.sphere_radius[surface])
                if geometry.leafy[surface]:
                    leaves[k] = self._tones[face]
        colors = shading.colors.astype(np.uint8)
        foliage = Foliage(self._sun, camera.rotation, leaves)
        return DepthFaces(part, planes, colors, textured, spheres, foliage, to_rays)


def _bounding_box(points: Int32s) -> Box:
    left, top, width, height = cv2.boundingRect(points)
    return left, top, left + width, top + height


def _paste(image: Pixels, pixels: Pixels, outline: Int32s, box: Box) -> None:
    """Put the pixels of a box into the image, inside an outline."""
    left, top, right, bottom = box
    mask = np.zeros((bottom - top, right - left), np.uint8)
    cv2.fillConvexPoly(mask, outline - (left, top), 255)
    cv2.copyTo(pixels, mask, image[top:bottom, left:right])


def _texture_step(to_texture: Float64s, width: int, height: int) -> float:
    """The share of a texture's width that a pixel in the middle of a box covers.

    ``to_texture`` is the homography from the box's pixels to the texture, 0 to 1 along each axis:
    the share is the square root of its Jacobian's determinant.
    """
    x, y = (width - 1) / 2, (height - 1) / 2
    u, v, w = (to_texture @ (x, y, 1.0)).tolist()
    (a, b, _), (c, d, _), (e, f, _) = to_texture.tolist()
    across = ((a * w - u * e), (c * w - v * e))
    down = ((b * w - u * f), (d * w - v * f))
    area = abs(across[0] * down[1] - across[1] * down[0]) / max(w**4, 1e-12)
    return float(area**0.5)
