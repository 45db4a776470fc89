"""Renderers by name: each is an entry point ``vencejo.renderers`` that opens a world.

A renderer turns a world and a camera's pose into an image. Its entry point names a callable that
takes ``(world, vehicles, shadows)`` and returns a :class:`Renderer`. A renderer is imported when
its first image is rendered.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Protocol

from hal.vehicle import Intrinsics
from vencejo.errors import UserError, nearest
from vencejo.geometry import Pose
from vencejo.plugins import plugins
from worlds.things import Thing
from worlds.world import World

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

GROUP = "vencejo.renderers"
_BULLET = "hal.sim.bullet_renderers"
"""The module of pybullet's renderers and of its window."""


class Renderer(Protocol):
    """Renders images of one world."""

    def render(
        self, pose: Pose, intrinsics: Intrinsics, time: float, vehicles: Mapping[str, Pose]
    ) -> NDArray[np.uint8]:
        """A BGR image (height, width, 3) of a pinhole camera; distortion is ignored.

        ``pose`` is the camera's: its optical axes (x right, y down, z out) to world. Moving things
        are shown at ``time``, seconds since the run began. Of the vehicles that the renderer was
        opened with, those with a pose (body to world) are shown.
        """

    def close(self) -> None:
        """Release its memory."""


def renderer_names() -> list[str]:
    """The renderers that are installed."""
    return sorted(plugins(GROUP))


def check_renderer(name: object) -> str:
    """The name of a renderer that can be opened.

    Raises UserError (``unknown-renderer``, ``no-pybullet``).
    """
    if not isinstance(name, str) or name not in plugins(GROUP):
        raise _unknown(name)
    if plugins(GROUP)[name].module == _BULLET:
        _need_pybullet(f"the renderer '{name}'")
    return name


def open_renderer(
    name: str, world: World, vehicles: Mapping[str, Thing], *, shadows: bool = False
) -> Renderer:
    """Open a renderer on a world.

    ``vehicles``: the appearance of each, by its name. ``shadows``: things cast shadows on the
    ground. Raises UserError for an unknown name (``unknown-renderer``), a texture that cannot be
    read, or a renderer that does not run on this machine (``no-pybullet``, ``no-egl``).
    """
    renderer: Renderer = plugins(GROUP)[check_renderer(name)].load()(world, vehicles, shadows)
    return renderer


def show_window(world: World) -> None:
    """Show a world in a window until it is closed.

    Raises UserError without a display (``no-display``) or without pybullet (``no-pybullet``).
    """
    _need_pybullet("the window")
    show: Any = import_module(_BULLET).show
    show(world)


def _need_pybullet(what: str) -> None:
    if find_spec("pybullet") is None:
        raise UserError(
            "no-pybullet",
            f"{what} is pybullet's, which is not installed",
            hint="the renderer 'raster' needs nothing else; `worlds NAME --render FILE` draws a "
            'picture; for pybullet run: pip install "vencejo[bullet]"',
        )


def _unknown(name: object) -> UserError:
    return UserError(
        "unknown-renderer",
        f"there is no renderer '{name}'",
        hint=nearest(str(name), renderer_names()),
    )
