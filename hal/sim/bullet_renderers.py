"""pybullet's renderers, as a reference: the software one (``tiny``) and OpenGL's (``egl``)."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from contextlib import suppress
from importlib.util import find_spec
from math import hypot
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from hal.scene.arrays import Float32s, Int32s, Pixels
from hal.scene.ground_texture import ground_mosaic, ground_texture
from hal.scene.ground_tiles import GroundTiles
from hal.scene.oriented_box import OrientedBox
from hal.scene.scene import Scene
from hal.scene.surfaces import Surface, sphere_mesh, surface_of, terrain_surface
from hal.scene.textures import Bitmap, mipmap_of
from hal.scene.transforms import rotation_matrix
from hal.sim.bullet import load_pybullet, silenced
from hal.vehicle import Intrinsics
from vencejo.errors import UserError
from vencejo.geometry import Point, Pose
from worlds.things import UPRIGHT, Color, Part, Sphere, Terrain, Texture, Thing
from worlds.world import World

FAR = 1000.0
"""Depth up to which things are seen, metres."""
_SPHERE_RINGS = 24
_NEAREST = 0.0005
"""Depth from which on things are seen, metres."""
_OVERLAP = 0.95
"""Depth over that from which on a pass is used, where it begins: no pixel falls between two."""
_NEAR = 0.05
"""Least depth of the near plane of a pass over all that is farther, metres: the farther out, the
finer are the depths that can be told apart. OpenGL's buffer has 16 bits of them.
"""
_GROUND_HEIGHT = -0.002
"""Height of the ground, metres: of what lies on it at 0 and a ground at 0 either could be seen."""
_OUT_OF_SIGHT: Pose = (Point(0.0, 0.0, -1000.0), UPRIGHT)
"""The place of vehicles that are not to be seen."""


class BulletRenderer:
    """A world in a pybullet of its own, to be looked at (see :class:`hal.renderers.Renderer`)."""

    pixel_offset = 0.0
    """Offset of this renderer's samples from the centres of pixels, right and down, pixels."""

    def __init__(self, world: World, vehicles: Mapping[str, Thing], shadows: bool = False) -> None:
        """Raises UserError for a texture that cannot be read."""
        p = load_pybullet()
        self._p = p
        self._world = world
        self._scene = Scene(world, vehicles)
        self._shadows = shadows
        self._client: int = self._connect()
        self._files = TemporaryDirectory(prefix="vencejo-")
        self._count = 0
        self._textures: dict[Texture | Bitmap, int] = {}
        self.names: dict[int, str] = {}
        """Keys of things in the scene, by the bodies that show them."""
        self._bodies: dict[str, list[tuple[int, Part]]] = {}
        self._boxes: dict[str, list[OrientedBox]] = {}
        """The boxes about the parts of things, placed as they are."""
        terrain = world.ground.terrain
        self._highest = max(map(max, terrain.heights)) if terrain else None
        """Height of the highest hill, metres; None for level ground."""
        try:
            tiles = GroundTiles(world.ground)
            self._add_ground(tiles)
            if terrain:
                self._add_terrain(tiles, terrain)
            for key, thing in self._scene.things.items():
                self._bodies[key] = [(self._show(part), part) for part in thing.parts]
                self.names |= {body: key for body, _ in self._bodies[key]}
                self._place(key, (thing.at, thing.attitude))
        except BaseException:
            self.close()
            raise

    def _connect(self) -> int:
        return int(self._p.connect(self._p.DIRECT))

    def render(
        self, pose: Pose, intrinsics: Intrinsics, time: float, vehicles: Mapping[str, Pose]
    ) -> Pixels:
        """See :class:`hal.renderers.Renderer`."""
        return self.look(pose, intrinsics, time, vehicles)[0]

    def look(
        self, pose: Pose, intrinsics: Intrinsics, moment: float, vehicles: Mapping[str, Pose]
    ) -> tuple[Pixels, Int32s]:
        """An image, and the body that each pixel shows (−1: the sky)."""
        light = self._world.light
        poses = self._scene.poses(moment, vehicles)
        for key in self._scene.moving:
            self._place(key, poses.get(key, _OUT_OF_SIGHT))
        least = self._least_depth(pose, intrinsics)
        # With the least one, windows would sink into their walls and markers into the ground.
        near = max(_NEAR, least)
        image, seen, _ = self._pass(pose, intrinsics, _OVERLAP * near)
        if least < near:
            # What is nearer is drawn on top.
            closeup, bodies, depths = self._pass(pose, intrinsics, _NEAREST)
            on_top = depths < _buffered(near, _NEAREST)
            image[on_top], seen[on_top] = closeup[on_top], bodies[on_top]
        image[seen < 0] = light.sky[::-1]
        return image, seen

    def _pass(self, pose: Pose, lens: Intrinsics, near: float) -> tuple[Pixels, Int32s, Float32s]:
        """Image, bodies and depth buffer of all that is beyond a near plane."""
        p, light = self._p, self._world.light
        view, projection = opengl_matrices(pose, lens, self.pixel_offset, near)
        _, _, colors, depths, bodies = p.getCameraImage(
            lens.width,
            lens.height,
            view,
            projection,
            lightDirection=list(light.sun),
            lightDistance=100,
            lightAmbientCoeff=light.ambient,
            lightDiffuseCoeff=1 - light.ambient,
            lightSpecularCoeff=0,
            shadow=int(self._shadows),
            renderer=self._renderer(),
            physicsClientId=self._client,
        )
        shape = lens.height, lens.width
        image = np.asarray(colors, np.uint8).reshape(*shape, 4)
        return (
            np.asarray(cv2.cvtColor(image, cv2.COLOR_RGBA2BGR), np.uint8),
            np.array(bodies, np.int32).reshape(shape),
            np.asarray(depths, np.float32).reshape(shape),
        )

    def _least_depth(self, pose: Pose, lens: Intrinsics) -> float:
        """A depth that nothing in an image falls short of, metres."""
        eye = np.array(pose[0])
        height = pose[0].z
        gaps = [abs(height) if self._highest is None else height - self._highest]
        gaps += [box.distance(eye) for boxes in self._boxes.values() for box in boxes]
        # In a corner of the image depth is the least share of the distance.
        across = max(lens.cx + 1, lens.width - lens.cx) / lens.fx
        down = max(lens.cy + 1, lens.height - lens.cy) / lens.fy
        return min(gaps) / hypot(1, across, down)

    def _renderer(self) -> int:
        return int(self._p.ER_TINY_RENDERER)

    def close(self) -> None:
        if self._client >= 0:
            self._p.disconnect(self._client)
            self._files.cleanup()
            self._client = -1

    # Bodies.

    def _place(self, key: str, pose: Pose) -> None:
        p = self._p
        self._boxes[key] = [OrientedBox.about(part, pose) for part in self._scene.things[key].parts]
        for body, part in self._bodies[key]:
            at, attitude = p.multiplyTransforms(*pose, part.at, part.attitude)
            p.resetBasePositionAndOrientation(body, at, attitude, physicsClientId=self._client)

    def _body(self, visual: int) -> int:
        return int(self._p.createMultiBody(0, -1, visual, [0, 0, 0], physicsClientId=self._client))

    def _show(self, part: Part) -> int:
        """A body that shows a part, in the part's own frame."""
        # All as meshes: pybullet's own spheres are coarse, and OpenGL's boxes lose their corners.
        shape = part.shape
        if isinstance(shape, Sphere):
            shape = sphere_mesh(shape.radius, _SPHERE_RINGS)
        upright = Part(shape, Point(0.0, 0.0, 0.0), UPRIGHT, part.color, part.texture)
        body = self._mesh(surface_of(upright), part.color)
        if part.texture is not None:
            self._cover(body, part.texture)
        return body

    def _cover(self, body: int, texture: Texture | Bitmap) -> None:
        """Give a body a texture in the place of its colour."""
        self._p.changeVisualShape(
            body,
            -1,
            rgbaColor=[1, 1, 1, 1],
            textureUniqueId=self._texture(texture),
            physicsClientId=self._client,
        )

    def _mesh(self, surface: Surface, color: Color) -> int:
        """A body that shows a surface."""
        p = self._p
        vertices: list[list[float]] = []
        uvs: list[list[float]] = []
        indices: list[int] = []
        for face in surface.faces:
            base = len(vertices)
            corners = surface.vertices[list(face.corners)]
            vertices.extend(corners.tolist())
            frame = face.texture_frame
            to_texture = np.zeros((3, 2)) if frame is None else np.linalg.pinv(frame[1:])
            corner = corners[0] if frame is None else frame[0]
            uvs.extend(((corners - corner) @ to_texture).tolist())
            for k in range(1, len(corners) - 1):
                indices.extend((base, base + k, base + k + 1))
        return self._body(
            p.createVisualShape(
                p.GEOM_MESH,
                fileName=self._mesh_file(vertices, uvs, indices),
                rgbaColor=_rgba(color),
                specularColor=[0, 0, 0],
                physicsClientId=self._client,
            )
        )

    def _mesh_file(
        self, vertices: list[list[float]], uvs: list[list[float]], indices: list[int]
    ) -> str:
        """Write triangles to an OBJ file: given directly, the OpenGL renderer does not take them.

        ``indices`` are of vertices, three to a triangle; v of the ``uvs`` goes down.
        """
        # OBJ counts vertices from 1, and its v goes up.
        lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
        lines += [f"vt {u:.9g} {1 - v:.9g}" for u, v in uvs]
        corners = [f"{index + 1}/{index + 1}" for index in indices]
        lines += [f"f {' '.join(corners[k : k + 3])}" for k in range(0, len(corners), 3)]
        path = self._file("obj")
        path.write_text("\n".join(lines) + "\n", "ascii")
        return str(path)

    def _file(self, kind: str) -> Path:
        self._count += 1
        return Path(self._files.name) / f"{self._count}.{kind}"

    def _texture(self, texture: Texture | Bitmap) -> int:
        if texture not in self._textures:
            self._textures[texture] = self._load(mipmap_of(texture).level(0.0))
        return self._textures[texture]

    def _load(self, pixels: Pixels) -> int:
        path = self._file("png")
        cv2.imwrite(str(path), pixels[..., :3])
        return int(self._p.loadTexture(str(path), physicsClientId=self._client))

    def _add_terrain(self, tiles: GroundTiles, terrain: Terrain) -> None:
        texture, color = ground_texture(tiles, terrain.size), self._world.ground.color
        whole = terrain_surface(terrain, color, texture)
        # What is level at z = 0 would flicker with the ground in the same place.
        risen = [face for face in whole.faces if whole.vertices[list(face.corners), 2].any()]
        if risen:
            body = self._mesh(Surface(whole.vertices, tuple(risen), convex=False), color)
            self._cover(body, texture)

    def _add_ground(self, tiles: GroundTiles) -> None:
        mosaic = ground_mosaic(tiles, self._world.ground.size)
        half = mosaic.half
        inner = [[x, y, _GROUND_HEIGHT] for x, y in (_SQUARE * half).tolist()]
        self._lay(inner, [0, 1, 2, 0, 2, 3], mosaic.pixels)
        if half < FAR:
            # A ring about the coloured square, not a square below it, which could be seen in it.
            outer = [[x, y, _GROUND_HEIGHT] for x, y in (_SQUARE * FAR).tolist()]
            plain = np.full((64, 64, 4), tiles.color_beyond, np.uint8)
            self._lay(inner + outer, _RING, plain)

    def _lay(self, vertices: list[list[float]], indices: list[int], pixels: Pixels) -> None:
        """Show triangles of the ground; a texture's corners are those of each four vertices."""
        p = self._p
        uvs = _SQUARE_UVS * (len(vertices) // 4)
        file = self._mesh_file(vertices, uvs, indices)
        visual = p.createVisualShape(p.GEOM_MESH, fileName=file, physicsClientId=self._client)
        p.changeVisualShape(
            self._body(visual),
            -1,
            rgbaColor=[1, 1, 1, 1],
            specularColor=[0, 0, 0],
            textureUniqueId=self._load(np.ascontiguousarray(pixels)),
            physicsClientId=self._client,
        )


class TinyRenderer(BulletRenderer):
    """pybullet's TinyRenderer: in software, slow, without smoothing."""

    pixel_offset = 0.5


class EglRenderer(BulletRenderer):
    """OpenGL without a window, by pybullet's EGL plugin."""

    def __init__(self, world: World, vehicles: Mapping[str, Thing], shadows: bool = False) -> None:
        """Raises UserError (``no-egl``) where the plugin is missing or finds no OpenGL."""
        # The plugin prints a lot about the machine's OpenGL.
        with silenced(1, 2):
            super().__init__(world, vehicles, shadows)

    def _connect(self) -> int:
        p, client = self._p, super()._connect()
        found, plugin = find_spec("eglRenderer"), -1
        if found and found.origin:
            with suppress(p.error):
                plugin = p.loadPlugin(found.origin, "_eglRendererPlugin", physicsClientId=client)
        if plugin < 0:
            p.disconnect(client)
            raise UserError(
                "no-egl",
                "pybullet's EGL renderer does not run on this machine",
                hint="take --renderer raster, which needs no OpenGL, or tiny",
            )
        self._plugin = plugin
        return client

    def _renderer(self) -> int:
        return int(self._p.ER_BULLET_HARDWARE_OPENGL)

    def look(
        self, pose: Pose, intrinsics: Intrinsics, moment: float, vehicles: Mapping[str, Pose]
    ) -> tuple[Pixels, Int32s]:
        with silenced(1):
            return super().look(pose, intrinsics, moment, vehicles)

    def close(self) -> None:
        if self._client >= 0:
            with silenced(1, 2):
                self._p.unloadPlugin(self._plugin, physicsClientId=self._client)
                super().close()


class _Window(BulletRenderer):
    """pybullet's own window."""

    def _connect(self) -> int:
        p = self._p
        client = p.connect(p.GUI) if "DISPLAY" in os.environ else -1
        if client < 0:
            raise UserError(
                "no-display",
                "there is no display to open a window on",
                hint="write a picture instead: drone-cli worlds NAME --render world.png",
            )
        p.configureDebugVisualizer(p.COV_ENABLE_GUI, 0, physicsClientId=client)
        return int(client)

    def show(self) -> None:
        """Let the moving things move in real time, until the window is closed."""
        p, began = self._p, time.monotonic()
        with suppress(p.error):
            while p.isConnected(self._client):
                for key, pose in self._scene.poses(time.monotonic() - began, {}).items():
                    self._place(key, pose)
                time.sleep(1 / 60)
        self._client = -1
        self._files.cleanup()


def show(world: World) -> None:
    """Show a world in a window, until that is closed. Raises UserError without a display."""
    _Window(world, {}).show()


_SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
_SQUARE_UVS = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]
"""Texture coordinates of those corners; v goes down."""
_RING = [n for k in range(4) for a, b in [(k, (k + 1) % 4)] for n in (a, 4 + a, 4 + b, a, 4 + b, b)]
"""Triangles between a square and another about it, whose corners follow those of the first."""


def _rgba(color: Color) -> list[float]:
    return [part / 255 for part in color] + [1.0]


def _buffered(depth: float, near: float) -> float:
    """What OpenGL's depth buffer holds for a depth: 0 at the near plane, 1 at FAR."""
    return FAR * (depth - near) / (depth * (FAR - near))


def opengl_matrices(
    pose: Pose, lens: Intrinsics, pixel_offset: float, near: float
) -> tuple[list[float], list[float]]:
    """OpenGL's view and projection matrices of a camera, column by column.

    ``pixel_offset``: how far right and down of a pixel's centre the renderer samples, pixels;
    ``near``: depth of the near plane, metres.
    """
    # OpenGL's camera looks along −z with y up.
    axes = rotation_matrix(pose[1]) * [1.0, -1.0, -1.0]
    view = np.eye(4)
    view[:3, :3] = axes.T
    view[:3, 3] = -axes.T @ np.array(pose[0])
    w, h = lens.width, lens.height
    across = (2 * (lens.cx - pixel_offset) + 1) / w - 1
    down = (2 * (lens.cy + pixel_offset) + 1) / h - 1
    projection = np.array(
        [
            [2 * lens.fx / w, 0, -across, 0],
            [0, 2 * lens.fy / h, down, 0],
            [0, 0, -(FAR + near) / (FAR - near), -2 * FAR * near / (FAR - near)],
            [0, 0, -1, 0],
        ]
    )
    return view.T.ravel().tolist(), projection.T.ravel().tolist()
