"""The description of a world in MuJoCo: the shapes of things and bodies. World frame, metres."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import ceil, dist
from typing import Any, Generic, TypeVar

import numpy as np

from hal.sim.convex_parts import convex_parts
from hal.sim.hills import Ridge, ridges
from hal.sim.physics import GRAVITY, STEP, Triple
from hal.sim.pieces import Piece
from vencejo.geometry import Quaternion
from worlds.things import Cuboid, Cylinder, Mesh, Sphere, Terrain

SUBSTEPS = 8
"""Parts of a step in which something may be hit fast: what is hit gives way by the distance that is
flown in one part."""
NOTICE = 0.15
"""Distance between two bodies, metres, from which the engine knows that they may touch."""
_FRICTION, _GRIP = 0.64, 2.0
"""Coefficients of friction: what is tilted by less than 32.6° stands. Moving things have a landing
net. Of two surfaces the greater one counts."""
_SOLREF = (2.002 * STEP / SUBSTEPS, 3.0)
"""Time constant, seconds, and damping ratio of contacts. MuJoCo makes the time two steps at least;
what is less damped bounces."""
_SOLIMP = (0.99, 0.999, 0.001, 0.5, 2.0)
"""Impedance of contacts: hard (see MuJoCo's documentation, *Solver parameters*)."""
_IMPRATIO = 100.0
"""Impedance of friction over that of the contact's normal: what stands on a slope creeps less."""
_HEAVY = 1e6
"""Mass in kg, and each moment of inertia in kg·m², of a moving thing: nothing pushes it away."""
_RADIUS = 0.004
"""Radius of the spheres with which a body touches hills, metres."""
_SPACING = 0.25
"""Greatest distance between them, metres."""
_EDGE_WIDTH, _EDGE_DEPTH, _EDGE_SUNK = 0.002, 0.04, 0.001
"""Of the cuboids along ridges, and how far below the edge they end, metres: what lies on a face of
the hills beside one does not touch it."""

# Bits of MuJoCo's contype and conaffinity: two shapes collide when the one has a bit of the other.
_THING, _BODY, _HILLS, _MOVER = 1, 2, 4, 8
_ALL = _THING | _BODY | _MOVER
VISIBLE, HIDDEN = 0, 1
"""Groups of shapes that rays meet, and that they pass through."""

Owner = TypeVar("Owner")


class MujocoScene(Generic[Owner]):
    """What the world consists of, and which owner each shape belongs to."""

    def __init__(self, mj: Any) -> None:
        self._mj = mj
        self._spec = spec = mj.MjSpec()
        self._shapes: list[tuple[Any, Owner]] = []
        self._count = 0
        """Of the assets, for their names."""
        option = spec.option
        option.timestep = STEP
        option.gravity = (0.0, 0.0, -GRAVITY)
        option.cone = mj.mjtCone.mjCONE_ELLIPTIC
        option.impratio = _IMPRATIO
        # It would put the whole world back to its start.
        option.disableflags |= mj.mjtDisableBit.mjDSBL_AUTORESET

    def compile(self, model: Any, data: Any) -> tuple[Any, Any]:
        """MuJoCo's model of it, and data that go on from those before, if any."""
        if model is None:
            model = self._spec.compile()
            return model, self._mj.MjData(model)
        compiled: tuple[Any, Any] = self._spec.recompile(model, data)
        return compiled

    def owners(self) -> list[Owner]:
        """The owner of each shape, by MuJoCo's number of the shape in the compiled model."""
        return [owner for _, owner in sorted(self._shapes, key=lambda shape: shape[0].id)]

    def add_ground(self, owner: Owner) -> None:
        """Add the level ground."""
        plane = self._mj.mjtGeom.mjGEOM_PLANE
        self._add(self._spec.worldbody, owner, type=plane, size=(0, 0, 1), contype=_THING)

    def add_terrain(self, terrain: Terrain, owner: Owner) -> None:
        """Add hills; bodies touch them with spheres of their own."""
        rows, last = terrain.heights, len(terrain.heights) - 1
        top = max(map(max, rows))
        # MuJoCo's diagonals run from the south-west to the north-east, ours from the south-east to
        # the north-west: so the field is turned by 90°, and its heights with it.
        field = self._spec.add_hfield(name=self._asset())
        field.nrow = field.ncol = last + 1
        field.size = (terrain.size / 2, terrain.size / 2, top, 1.0)
        field.userdata = [
            rows[column][last - row] / top for row in range(last + 1) for column in range(last + 1)
        ]
        self._add(
            self._spec.worldbody,
            owner,
            type=self._mj.mjtGeom.mjGEOM_HFIELD,
            hfieldname=field.name,
            quat=(0.5**0.5, 0.0, 0.0, 0.5**0.5),
            contype=_HILLS,
        )
        for ridge in ridges(terrain):
            self._add_ridge(ridge, owner)

    def _add_ridge(self, ridge: Ridge, owner: Owner) -> None:
        """Add an edge of hills as a narrow cuboid; between a body's spheres it would come out."""
        begin, end, up = ridge
        length, depth = dist(begin, end), _EDGE_DEPTH / 2
        middle = [(a + b) / 2 - (depth + _EDGE_SUNK) * c for a, b, c in zip(*ridge, strict=True)]
        x, y, z = ((b - a) / length for a, b in zip(begin, end, strict=True))
        across = up.y * z - up.z * y, up.z * x - up.x * z, up.x * y - up.y * x
        geom = self._add(
            self._spec.worldbody,
            owner,
            type=self._mj.mjtGeom.mjGEOM_BOX,
            size=(length / 2, _EDGE_WIDTH / 2, depth),
            pos=middle,
            group=HIDDEN,
            contype=_THING,
        )
        geom.alt.type = self._mj.mjtOrientation.mjORIENTATION_XYAXES
        geom.alt.xyaxes = (x, y, z, *across)

    def add_fixed(self, piece: Piece, owner: Owner) -> None:
        """Add a piece of a thing that stands still; MuJoCo is fastest with all in one body."""
        self._add_piece(self._spec.worldbody, piece, owner, _THING)

    def add_mover(self, pieces: Sequence[Piece], owner: Owner) -> Any:
        """Add a body that moves, too heavy to be pushed: its description, which has its number."""
        body = self._add_free(_HEAVY, (_HEAVY,) * 3)
        for piece in pieces:
            self._add_piece(body, piece, owner, _MOVER)
        return body

    def add_body(self, mass: float, inertia: Triple, size: Triple, owner: Owner) -> Any:
        """Add a cuboid that moves freely: its description, which has its number."""
        body = self._add_free(mass, inertia)
        kinds = self._mj.mjtGeom
        shape: dict[str, Any] = {"group": HIDDEN, "gap": NOTICE, "contype": _BODY}
        half = [side / 2 for side in size]
        self._add(body, owner, type=kinds.mjGEOM_BOX, size=half, **shape, conaffinity=_ALL)
        shape |= {"contype": 0, "conaffinity": _HILLS}
        radius = min(_RADIUS, *half)
        for place in _feet(size, radius):
            self._add(
                body, owner, type=kinds.mjGEOM_SPHERE, size=(radius, 0, 0), pos=place, **shape
            )
        return body

    def _add_free(self, mass: float, inertia: Triple) -> Any:
        body = self._spec.worldbody.add_body()
        body.explicitinertial = True
        body.mass, body.inertia, body.ipos = mass, inertia, (0.0, 0.0, 0.0)
        body.gravcomp = 1.0  # that of a free body is switched (see `let_meet`)
        body.add_freejoint()
        return body

    def _add_piece(self, body: Any, piece: Piece, owner: Owner, kind: int) -> None:
        kinds, shape = self._mj.mjtGeom, piece.shape
        place: dict[str, Any] = {"pos": piece.at, "quat": scalar_first(piece.attitude)}
        place["contype"] = kind
        if kind == _MOVER:
            place["friction"] = (_GRIP, 0.0, 0.0)
        if isinstance(shape, Cuboid):
            half = [side / 2 for side in shape.size]
            self._add(body, owner, type=kinds.mjGEOM_BOX, size=half, **place)
        elif isinstance(shape, Cylinder):
            size = (shape.radius, shape.height / 2, 0)
            self._add(body, owner, type=kinds.mjGEOM_CYLINDER, size=size, **place)
        elif isinstance(shape, Sphere):
            self._add(body, owner, type=kinds.mjGEOM_SPHERE, size=(shape.radius, 0, 0), **place)
        else:
            assert isinstance(shape, Mesh)
            self._add_mesh(body, shape, owner, place)

    def _add_mesh(self, body: Any, mesh: Mesh, owner: Owner, place: dict[str, Any]) -> None:
        """Add a mesh: rays meet its triangles, bodies the convex parts of it."""
        seen = self._asset_of(mesh.vertices, mesh.faces)
        kind = {"type": self._mj.mjtGeom.mjGEOM_MESH}
        self._add(body, owner, meshname=seen, **kind, **(place | {"contype": 0}))
        for corners in convex_parts(mesh):
            part = self._asset_of(corners)
            self._add(body, owner, meshname=part, **kind, **place, group=HIDDEN)

    def _asset_of(self, vertices: Any, faces: Any = ()) -> str:
        """The name of a new mesh; without faces it is the convex hull of its vertices."""
        asset = self._spec.add_mesh(name=self._asset())
        asset.uservert = np.ravel(vertices)
        if len(faces):
            asset.userface = np.ravel(faces)
        asset.inertia = self._mj.mjtMeshInertia.mjMESH_INERTIA_SHELL
        name: str = asset.name
        return name

    def _add(self, body: Any, owner: Owner, **shape: Any) -> Any:
        usual = {"conaffinity": 0, "group": VISIBLE, "friction": (_FRICTION, 0.0, 0.0)}
        geom = body.add_geom(
            solref=_SOLREF,
            solimp=_SOLIMP,
            condim=3,
            mass=0.0,
            **(usual | shape),
        )
        self._shapes.append((geom, owner))
        return geom

    def _asset(self) -> str:
        self._count += 1
        return f"asset {self._count}"


def let_meet(model: Any, body: int, *, things: bool = False, others: bool = False) -> None:
    """Let a free body meet what stands still and the pull of gravity, and let it meet what moves.

    What meets neither stays where it is, if it stands still, and costs nothing.
    """
    box, count = model.body_geomadr[body], model.body_geomnum[body]
    kind = _BODY if others else 0
    model.geom_contype[box] = model.body_contype[body] = kind
    meets = things * _THING | others * (_BODY | _MOVER)
    model.geom_conaffinity[box] = meets
    model.geom_conaffinity[box + 1 : box + count] = things * _HILLS
    model.body_conaffinity[body] = meets | things * _HILLS
    model.body_gravcomp[body] = 0.0 if things else 1.0


def scalar_first(q: Quaternion) -> tuple[float, float, float, float]:
    """A quaternion in MuJoCo's order: w, x, y, z."""
    return q[3], q[0], q[1], q[2]


def _feet(size: Triple, radius: float) -> Iterator[Triple]:
    """Middles of spheres inside the upper and the lower face of a cuboid, its corners included."""
    along, across, up = (side / 2 - radius for side in size)

    def spread(reach: float) -> list[float]:
        count = max(2, ceil(2 * reach / _SPACING))
        return [reach * (2 * k / count - 1) for k in range(count + 1)]

    yield from product(spread(along), spread(across), (-up, up))
