"""The simulator's physics engines by name; one is imported when it is opened."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any, NamedTuple

from vencejo.errors import UserError, nearest


class Engine(NamedTuple):
    """A physics engine."""

    package: str
    """The package that it needs, as it is imported."""
    distribution: str
    """What is installed for it."""
    opens: str
    """``module:Name`` of what opens an empty world (see :class:`hal.sim.physics.Physics`)."""


ENGINES = {
    "bullet": Engine("pybullet", "pybullet", "hal.sim.bullet:Bullet"),
    "mujoco": Engine("mujoco", "mujoco-core", "hal.sim.mujoco:Mujoco"),
}
"""The engines by name; the first that is installed is the default."""


def engine_names() -> list[str]:
    """The engines that the simulator knows, installed or not."""
    return sorted(ENGINES)


def check_engine(name: object) -> str:
    """The name of an engine; of the default one for None. Raises UserError (``unknown-engine``)."""
    if name is None:
        return default_engine()
    if not isinstance(name, str) or name not in ENGINES:
        hint = nearest(str(name), ENGINES)
        raise UserError("unknown-engine", f"there is no physics engine '{name}'", hint=hint)
    return name


def default_engine() -> str:
    """The first engine that is installed; the last one, which has wheels everywhere, for none."""
    return next(filter(is_installed, ENGINES), list(ENGINES)[-1])


def is_installed(name: str) -> bool:
    """Whether the package of an engine is there; it is not imported."""
    return find_spec(ENGINES[name].package) is not None


def open_engine(name: object = None) -> Any:
    """An empty world of an engine (see :class:`hal.sim.physics.Physics`); of the default for None.

    Raises UserError (``unknown-engine``), and VehicleError (``no-physics``) without its package.
    """
    module, _, attribute = ENGINES[check_engine(name)].opens.partition(":")
    return getattr(import_module(module), attribute)()
