"""The physics engine MuJoCo by way of mujoco-core, in this process and without a window."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from math import dist, inf, sqrt
from typing import Any

import numpy as np

from hal.sim.hills import slowed_above
from hal.sim.mujoco_bodies import MujocoBody, MujocoFixed, MujocoMover
from hal.sim.mujoco_contacts import MujocoContacts, Touchable
from hal.sim.mujoco_scene import HIDDEN, NOTICE, SUBSTEPS, MujocoScene
from hal.sim.physics import STEP, Triple
from hal.sim.pieces import pieces_of
from vencejo.errors import VehicleError
from vencejo.geometry import Point, Quaternion
from worlds.things import Terrain, Thing

_FAST = 0.5
"""Speed, m/s, from which a body that may touch something is moved in parts of a step."""
_TOO_FAST = NOTICE / 2 / STEP
"""Speed, m/s, from which it is so everywhere: MuJoCo might know of a contact too late."""
_STEPS_BETWEEN_LOOKS = 24
"""A body that stands still at two looks, and was not pushed between them, falls asleep."""
_SEEN = np.array([group != HIDDEN for group in range(6)], dtype=np.uint8)
"""The groups of shapes that rays meet."""


def load_mujoco() -> Any:
    """The mujoco module. Raises VehicleError."""
    module = sys.modules.get("mujoco")
    if module is None:
        try:
            module = import_module("mujoco")
        except ImportError as error:
            raise VehicleError(
                "no-physics",
                f"the simulator needs MuJoCo, which is not installed ({error})",
                hint='run: pip install "vencejo[mujoco]"',
            ) from None
        # It would write its warnings to standard error and into a file in the current folder.
        module.set_mju_user_warning(_ignored)
    return module


def _ignored(_: str) -> None:
    """What MuJoCo warns of is seen in the state of a body (see MujocoBody.read)."""


class Mujoco:
    """A world of its own in MuJoCo (see :class:`hal.sim.physics.Physics`).

    What is added is compiled when it is needed; the state of what was there stays as it is.
    """

    def __init__(self) -> None:
        self._mj = load_mujoco()
        self._scene: MujocoScene[Touchable] = MujocoScene(self._mj)
        self._model: Any = None
        self._data: Any = None
        self._compiled = False
        self._owners: Sequence[Touchable] = ()
        """Of each shape, by its number."""
        self._contacts = MujocoContacts()
        self._bodies: list[MujocoBody] = []
        self._movers: list[MujocoMover] = []
        self._descriptions: dict[MujocoBody | MujocoMover, Any] = {}
        self._terrain: Terrain | None = None
        self._top = 0.0
        """Height of the highest ground, metres."""
        self._steps = 0
        self._hit = np.empty(1, np.int32)
        """Where MuJoCo writes the number of the shape that a ray meets."""
        self._scene.add_ground(MujocoFixed(""))

    @property
    def name(self) -> str:
        return f"mujoco {self._mj.__version__}"

    def add_things(self, things: Sequence[Thing], terrain: Terrain | None = None) -> None:
        self._compiled = False
        if terrain is not None and any(map(any, terrain.heights)):
            self._scene.add_terrain(terrain, MujocoFixed("", slippery=False))
            self._terrain, self._top = terrain, max(map(max, terrain.heights))
        for thing in things:
            pieces = pieces_of(thing)
            if thing.motion is None:
                fixed = MujocoFixed(thing.name)
                for piece in pieces:
                    self._scene.add_fixed(piece, fixed)
            elif pieces:
                mover = MujocoMover(thing)
                self._descriptions[mover] = self._scene.add_mover(pieces, mover)
                self._movers.append(mover)

    def add_body(
        self,
        mass: float,
        inertia: Triple,
        size: Triple,
        position: Triple,
        attitude: Quaternion,
        name: str = "",
    ) -> MujocoBody:
        self._compiled = False
        state = position, attitude, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        body = MujocoBody(name, state, size, self._contacts)
        self._descriptions[body] = self._scene.add_body(mass, inertia, size, body)
        self._bodies.append(body)
        return body

    def step(self) -> None:
        self._compile()
        steps, self._steps = self._steps, self._steps + 1
        moving = [body for body in self._bodies if body.restless]
        if not moving and (not self._movers or all(body.withdrawn for body in self._bodies)):
            return
        for mover in self._movers:
            mover.drive(steps)
        for body in moving:
            body.act()
            if self._terrain is not None:
                self._keep_above(body, self._terrain)
        self._advance(moving)
        self._data.qfrc_applied.fill(0.0)
        self._contacts.renew()
        if len(moving) < len(self._bodies):
            self._wake_touched()
        for body in moving:
            body.read()
        if self._steps % _STEPS_BETWEEN_LOOKS == 0:
            self._settle()

    def _compile(self) -> None:
        if self._compiled:
            return
        self._model, self._data = model, data = self._scene.compile(self._model, self._data)
        for part, description in self._descriptions.items():
            part.bind(model, data, description.id)
        self._owners = self._scene.owners()
        self._contacts.bind(data, self._owners)
        self._compiled = True
        self._show()  # rays meet nothing before

    def _advance(self, moving: Sequence[MujocoBody]) -> None:
        """Make a step, in parts where something may be hit fast."""
        mj, model, data = self._mj, self._model, self._data
        if self._contacts.outdated:  # otherwise a first step would not know that it is near a thing
            mj.mj_fwdPosition(model, data)
        fast = _FAST if data.ncon else _TOO_FAST
        count = SUBSTEPS if any(body.is_fast(fast) for body in moving) else 1
        model.opt.timestep = STEP / count
        if any(body.slides() for body in moving):
            for _ in range(count):
                self._slide(moving, STEP / count)
        else:
            mj.mj_step(model, data, count)

    def _slide(self, moving: Sequence[MujocoBody], seconds: float) -> None:
        """Make a step in which something slides.

        In MuJoCo's convex model of friction what slides is also thrown upwards, by as much as
        friction is asked to slow it down: at first, to a stand within the step. So it is asked for
        no more than the force of gravity and of the impact can bring about. `mj_step` is made of
        the same calls.
        """
        mj, model, data = self._mj, self._model, self._data
        mj.mj_fwdPosition(model, data)
        for body in moving:
            body.read()
        self._contacts.renew()
        self._contacts.ease_friction(seconds)
        for stage in (mj.mj_makeConstraint, mj.mj_island, mj.mj_projectConstraint):
            stage(model, data)
        mj.mj_fwdVelocity(model, data)
        mj.mj_step2(model, data)

    def _keep_above(self, body: MujocoBody, terrain: Terrain) -> None:
        """Let a body not come as deep into the terrain as it could in a hard fall.

        There MuJoCo would not know which way is out.
        """
        position, _, velocity, _ = body.state()
        if position[2] + velocity[2] * STEP < self._top + body.thickness:
            slowed = slowed_above(terrain, position, velocity, body.thickness / 4)
            if slowed is not None:
                body.slow(slowed)

    def _wake_touched(self) -> None:
        """Wake what sleeps and was touched in the last step, in which it stays where it is."""
        for one, other, _ in self._contacts.pairs():
            for body, by in ((one, other), (other, one)):
                if isinstance(body, MujocoBody) and not body.restless and by.restless:
                    body.wake()

    def _settle(self) -> None:
        """Let fall asleep what stands still on, and beside, what stands still."""
        calm = {body for body in self._bodies if body.restless and body.look()}
        if not calm:
            return
        pairs = [(one, two) for one, two, _ in self._contacts.pairs()]
        pairs += [(two, one) for one, two in pairs]
        found = True
        while found:
            stirred = {
                one for one, two in pairs if one in calm and two.restless and two not in calm
            }
            calm -= stirred
            found = bool(stirred)
        for body in calm:
            body.fall_asleep()

    def ray(self, start: Triple, end: Triple) -> Point | None:
        self._place_shapes()
        distance, _ = self._cast(start, end)
        if distance == inf:
            return None
        share = distance / dist(start, end)
        return Point(*(a + (b - a) * share for a, b in zip(start, end, strict=True)))

    def rays(self, starts: Sequence[Triple], ends: Sequence[Triple]) -> MujocoRayHits:
        self._place_shapes()
        return MujocoRayHits(list(map(self._cast, starts, ends)), self._owners)

    def _place_shapes(self) -> None:
        """Have all shapes where they are now, for rays."""
        self._compile()
        if self._movers:
            self._show()

    def _cast(self, start: Triple, end: Triple) -> tuple[float, int]:
        """The distance to the first hit, and the number of the shape; infinite and -1 for none."""
        x, y, z = start
        dx, dy, dz = end[0] - x, end[1] - y, end[2] - z
        length = sqrt(dx * dx + dy * dy + dz * dz)
        way = dx / length, dy / length, dz / length
        static, none, shape = True, -1, self._hit
        distance: float = self._mj.mj_ray(
            self._model, self._data, start, way, _SEEN, static, none, shape
        )
        met = int(shape[0])
        return (distance, met) if met >= 0 and distance <= length else (inf, -1)

    def _show(self) -> None:
        """Move all shapes to where they are now."""
        for mover in self._movers:
            mover.show(self._steps)
        self._mj.mj_kinematics(self._model, self._data)

    def close(self) -> None:
        """Nothing to do: the memory goes with this object."""


class MujocoRayHits:
    """Ray hits (see :class:`hal.sim.physics.RayHits`)."""

    def __init__(self, hits: Sequence[tuple[float, int]], owners: Sequence[Touchable]) -> None:
        """``hits``: the distance of each, and the number of the shape, below 0 for none."""
        self.distances = [distance for distance, _ in hits]
        self._hits, self._owners = hits, owners

    def name(self, ray: int) -> str | None:
        _, shape = self._hits[ray]
        return self._owners[shape].name if shape >= 0 else None
