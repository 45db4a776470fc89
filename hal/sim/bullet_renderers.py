"""pybullet's renderers, as a reference: the software one (``tiny``) and OpenGL's (``egl``)."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from contextlib import suppress
from importlib.util import find_spec
from math import ceil, hypot, log2
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from hal.renderers import Pose
from hal.scene.ground_texture import drape
from hal.scene.ground_tiles import FINEST, SIDE, Tiles
from hal.scene.surfaces import Solid, ball, relief_of, rotation, solid_of
from hal.scene.textures import Painted, picture_of
from hal.sim.bullet import load_pybullet, shut
from hal.vehicle import Intrinsics
from vencejo.errors import UserError
from vencejo.geometry import Quaternion
from worlds.model import World
from worlds.motion import pose_at
from worlds.things import Color, Part, Sphere, Terrain, Texture, Thing

Pixels = NDArray[np.uint8]

FAR = 1000.0
"""Depth up to which things are seen, metres."""
_GROUND_TEXELS = 2048
"""Along the picture that the whole coloured ground is painted on."""
_NEAR_AT_MOST = 5.0
"""Metres: beyond this nothing is gained."""
_BENEATH = -0.02
"""Height of the plain ground outside the coloured square, metres."""


class BulletView:
    """A world in a pybullet of its own, to be looked at (see :class:`hal.renderers.Renderer`)."""

    shift = 0.0
    """How far right and down of a pixel's centre this renderer looks, pixels."""
    near = 0.05
    """Depth from which on things are seen at least, metres."""

    def __init__(self, world: World, vehicles: Mapping[str, Thing], shadows: bool = False) -> None:
        """Raises UserError for a texture that is none."""
        p = load_pybullet()
        self._p = p
        self._world = world
        self._shadows = shadows
        self._client: int = self._connect()
        self._files = TemporaryDirectory(prefix="vencejo-")
        self._count = 0
        self._textures: dict[Texture | Painted, int] = {}
        self.names: dict[int, str] = {}
        """Things by the bodies that show them."""
        self._bodies: dict[str, list[tuple[int, Part]]] = {}
        self._balls: dict[str, tuple[NDArray[np.float64], float]] = {}
        """Middles and radii of balls about things, in their own frames."""
        self._poses: dict[str, Pose] = {}
        self._moving = [thing for thing in world.things if thing.motion]
        try:
            tiles = Tiles(world.ground)
            self._add_ground(tiles)
            if world.ground.terrain:
                self._add_hills(tiles, world.ground.terrain)
            # A space keeps the names of vehicles apart from those of things.
            looks = {f" {name}": thing for name, thing in vehicles.items()}
            for name, thing in ({each.name: each for each in world.things} | looks).items():
                self._bodies[name] = [(self._show(part), part) for part in thing.parts]
                self._balls[name] = _ball_about(thing)
                self.names |= {body: name for body, _ in self._bodies[name]}
                self._place(name, (thing.at, thing.attitude))
        except BaseException:
            self.close()
            raise
        self._vehicles = tuple(vehicles)

    def _connect(self) -> int:
        return int(self._p.connect(self._p.DIRECT))

    def render(
        self, pose: Pose, intrinsics: Intrinsics, time: float, vehicles: Mapping[str, Pose]
    ) -> Pixels:
        """See :class:`hal.renderers.Renderer`."""
        return self.look(pose, intrinsics, time, vehicles)[0]

    def look(
        self, pose: Pose, intrinsics: Intrinsics, moment: float, vehicles: Mapping[str, Pose]
    ) -> tuple[Pixels, NDArray[np.int32]]:
        """A picture, and which body each pixel shows (−1: the sky)."""
        p, light = self._p, self._world.light
        for thing in self._moving:
            self._place(thing.name, pose_at(thing, moment))
        for name in self._vehicles:
            self._place(f" {name}", vehicles.get(name, _AWAY))
        view, projection = matrices(pose, intrinsics, self.shift, self._nearest(pose, intrinsics))
        _, _, colors, _, bodies = p.getCameraImage(
            intrinsics.width,
            intrinsics.height,
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
        shape = intrinsics.height, intrinsics.width
        image = np.asarray(colors, np.uint8).reshape(*shape, 4)
        image = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGBA2BGR), np.uint8)
        seen = np.asarray(bodies, np.int32).reshape(shape)
        image[seen < 0] = light.sky[::-1]
        return image, seen

    def _nearest(self, pose: Pose, lens: Intrinsics) -> float:
        """The depth from which on things are seen."""
        return self.near

    def _renderer(self) -> int:
        return int(self._p.ER_TINY_RENDERER)

    def close(self) -> None:
        if self._client >= 0:
            self._p.disconnect(self._client)
            self._files.cleanup()
            self._client = -1

    # Putting things up.

    def _place(self, name: str, pose: Pose) -> None:
        p = self._p
        self._poses[name] = pose
        for body, part in self._bodies[name]:
            at, attitude = p.multiplyTransforms(*pose, part.at, part.attitude)
            p.resetBasePositionAndOrientation(body, at, attitude, physicsClientId=self._client)

    def _body(self, visual: int) -> int:
        return int(self._p.createMultiBody(0, -1, visual, [0, 0, 0], physicsClientId=self._client))

    def _show(self, part: Part) -> int:
        # All as meshes: pybullet's own balls are coarse, and OpenGL's boxes lose their corners.
        shape = part.shape
        if isinstance(shape, Sphere):
            shape = ball(shape.radius, 24)
        upright = Part(
            shape, type(part.at)(0, 0, 0), (0.0, 0.0, 0.0, 1.0), part.color, part.texture
        )
        body = self._mesh(solid_of(upright), part.color)
        if part.texture is not None:
            self._wrap(body, part.texture)
        return body

    def _wrap(self, body: int, texture: Texture | Painted) -> None:
        self._p.changeVisualShape(
            body,
            -1,
            rgbaColor=[1, 1, 1, 1],
            textureUniqueId=self._texture(texture),
            physicsClientId=self._client,
        )

    def _mesh(self, solid: Solid, color: Color) -> int:
        p = self._p
        vertices: list[list[float]] = []
        uvs: list[list[float]] = []
        indices: list[int] = []
        for face in solid.faces:
            base = len(vertices)
            corners = solid.vertices[list(face.corners)]
            vertices.extend(corners.tolist())
            across = np.zeros((3, 2)) if face.frame is None else np.linalg.pinv(face.frame[1:])
            corner = corners[0] if face.frame is None else face.frame[0]
            uvs.extend(((corners - corner) @ across).tolist())
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
        """Triangles as a file: given directly, the OpenGL renderer does not take them."""
        # OBJ counts from 1, and v upwards.
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

    def _texture(self, texture: Texture | Painted) -> int:
        if texture not in self._textures:
            self._textures[texture] = self._load(picture_of(texture).level(0.0))
        return self._textures[texture]

    def _load(self, pixels: Pixels) -> int:
        path = self._file("png")
        cv2.imwrite(str(path), pixels[..., :3])
        return int(self._p.loadTexture(str(path), physicsClientId=self._client))

    def _add_hills(self, tiles: Tiles, terrain: Terrain) -> None:
        painted, color = drape(tiles, terrain.size), self._world.ground.color
        relief = relief_of(terrain, color, painted)
        # What is flat would flicker with the ground in the same place.
        risen = [face for face in relief.faces if relief.vertices[list(face.corners), 2].any()]
        if risen:
            self._wrap(self._mesh(Solid(relief.vertices, tuple(risen), False), color), painted)

    def _add_ground(self, tiles: Tiles) -> None:
        p, ground = self._p, self._world.ground
        level = max(0, ceil(log2(ground.size / _GROUND_TEXELS / FINEST)))
        reach = ceil(ground.size / 2 / (FINEST * 2**level * SIDE))
        rows = [
            np.hstack([tiles.tile(level, column, row) for column in range(-reach, reach)])
            for row in range(-reach, reach)
        ]
        half = reach * SIDE * FINEST * 2**level
        for side, height, pixels in (
            (half, 0.0, np.vstack(rows)[::-1]),
            (FAR, _BENEATH, np.full((64, 64, 4), tiles.beyond, np.uint8)),
        ):
            corners = [[x, y, height] for x, y in (_AROUND * side).tolist()]
            file = self._mesh_file(corners, _CORNERS, [0, 1, 2, 0, 2, 3])
            visual = p.createVisualShape(p.GEOM_MESH, fileName=file, physicsClientId=self._client)
            p.changeVisualShape(
                self._body(visual),
                -1,
                rgbaColor=[1, 1, 1, 1],
                textureUniqueId=self._load(np.ascontiguousarray(pixels)),
                physicsClientId=self._client,
            )


class TinyView(BulletView):
    """TinyRenderer: in software, slow, without smoothing."""

    shift = 0.5


class EglView(BulletView):
    """OpenGL without a window, by pybullet's plugin."""

    def __init__(self, world: World, vehicles: Mapping[str, Thing], shadows: bool = False) -> None:
        """Raises UserError (``no-egl``) where the plugin is missing or finds no OpenGL."""
        # It tells a lot about the machine's OpenGL.
        with shut(1, 2):
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

    def _nearest(self, pose: Pose, lens: Intrinsics) -> float:
        # As far out as nothing is cut off: the finer are the depths that OpenGL can tell apart.
        # With the least one, windows sink into their walls and markers into the ground.
        eye = np.array(pose[0])
        gaps = [abs(pose[0].z) + _BENEATH]
        if self._world.ground.terrain:
            gaps = [pose[0].z - max(map(max, self._world.ground.terrain.heights))]
        for name, (middle, radius) in self._balls.items():
            at, attitude = self._poses[name]
            gaps.append(float(np.linalg.norm(rotation(attitude) @ middle + at - eye)) - radius)
        # In a corner of the picture depth is the least share of the distance.
        across = max(lens.cx + 1, lens.width - lens.cx) / lens.fx
        down = max(lens.cy + 1, lens.height - lens.cy) / lens.fy
        return min(max(self.near, min(gaps) / hypot(1, across, down)), _NEAR_AT_MOST)

    def _renderer(self) -> int:
        return int(self._p.ER_BULLET_HARDWARE_OPENGL)

    def look(
        self, pose: Pose, intrinsics: Intrinsics, moment: float, vehicles: Mapping[str, Pose]
    ) -> tuple[Pixels, NDArray[np.int32]]:
        with shut(1):
            return super().look(pose, intrinsics, moment, vehicles)

    def close(self) -> None:
        if self._client >= 0:
            with shut(1, 2):
                self._p.unloadPlugin(self._plugin, physicsClientId=self._client)
                super().close()


class _Window(BulletView):
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
        """Let the moving things move, until the window is closed."""
        p, began = self._p, time.monotonic()
        with suppress(p.error):
            while p.isConnected(self._client):
                for thing in self._moving:
                    self._place(thing.name, pose_at(thing, time.monotonic() - began))
                time.sleep(1 / 60)
        self._client = -1
        self._files.cleanup()


def show(world: World) -> None:
    """Show a world in a window, until that is closed. Raises UserError without a display."""
    _Window(world, {}).show()


_AROUND = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
_CORNERS = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]
"""Of a texture, as _AROUND goes; v counts down."""
_AWAY: tuple[Any, Quaternion] = ((0.0, 0.0, -1000.0), (0.0, 0.0, 0.0, 1.0))


def _ball_about(thing: Thing) -> tuple[NDArray[np.float64], float]:
    solids = [solid_of(part) for part in thing.parts]
    corners = np.concatenate([solid.vertices for solid in solids] or [np.zeros((1, 3))])
    middle = (corners.min(0) + corners.max(0)) / 2
    reaches = [
        float(np.linalg.norm(solid.vertices - middle, axis=1).max()) + solid.sphere
        for solid in solids
    ]
    return middle, max(reaches, default=0.0)


def _rgba(color: Color) -> list[float]:
    return [part / 255 for part in color] + [1.0]


def matrices(
    pose: Pose, lens: Intrinsics, shift: float, near: float
) -> tuple[list[float], list[float]]:
    """OpenGL's view and projection matrices, column by column."""
    turn = rotation(pose[1])
    # OpenGL's camera looks along −z with y up.
    axes = turn * [1.0, -1.0, -1.0]
    view = np.eye(4)
    view[:3, :3] = axes.T
    view[:3, 3] = -axes.T @ np.array(pose[0])
    w, h = lens.width, lens.height
    across = (2 * (lens.cx - shift) + 1) / w - 1
    down = (2 * (lens.cy + shift) + 1) / h - 1
    projection = np.array(
        [
            [2 * lens.fx / w, 0, -across, 0],
            [0, 2 * lens.fy / h, down, 0],
            [0, 0, -(FAR + near) / (FAR - near), -2 * FAR * near / (FAR - near)],
            [0, 0, -1, 0],
        ]
    )
    return view.T.ravel().tolist(), projection.T.ravel().tolist()
