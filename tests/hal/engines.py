"""The physics engines behind the seam, for the tests that hold for each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Any

import pytest

from hal.engines import engine_names, is_installed, open_engine
from hal.sim.physics import STEP, Body, Physics, Triple
from vencejo.geometry import Point, Pose, Quaternion, yaw_quaternion
from worlds import figures
from worlds.things import UPRIGHT, Motion, Terrain, Thing

ENGINES: Mapping[str, Callable[[], Physics]] = {
    name: partial(open_engine, name) for name in engine_names() if is_installed(name)
}
"""What opens each engine that is installed."""
needs_pybullet = pytest.mark.skipif(
    not is_installed("bullet"), reason="compares with pybullet's own pictures"
)
SIZE = (0.5, 0.5, 0.12)
"""Of a vehicle, metres."""
WEIGHT = 0.436 * 9.80665
"""Of a vehicle, newtons."""


@contextmanager
def simulation(engine: str, *things: Thing, terrain: Terrain | None = None) -> Iterator[Physics]:
    """An engine with things and terrain in it."""
    physics = ENGINES[engine]()
    try:
        physics.add_things(things, terrain)
        yield physics
    finally:
        physics.close()


def vehicle(
    physics: Physics, at: Triple, attitude: Quaternion = UPRIGHT, name: str = "drone"
) -> Body:
    """A body like a vehicle, with its centre at a place."""
    return physics.add_body(0.436, (2.2e-3, 3e-3, 4.8e-3), SIZE, at, attitude, name)


def box(
    name: str, at: Point, size: Point, heading: float = 0.0, motion: Motion | None = None
) -> Thing:
    parts = figures.box(size, (0, 0, 0))
    return Thing(name, "box", at, yaw_quaternion(heading), parts, True, motion)


def mover_pose(physics: Physics) -> Pose:
    """Where the one moving thing of a simulation is."""
    inside: Any = physics
    if physics.name.startswith("mujoco"):
        inside._show()
        pose: Pose = inside._movers[0].pose()
        return pose
    place, attitude = inside._p.getBasePositionAndOrientation(
        inside._movers[0].body, inside._client
    )
    return Point(*place), attitude


def run(physics: Physics, seconds: float) -> None:
    for _ in range(round(seconds / STEP)):
        physics.step()
