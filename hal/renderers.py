"""Renderers: what turns a world and a camera's pose into a picture, found by name."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

from hal.vehicle import Intrinsics
from vencejo.errors import UserError, nearest
from vencejo.geometry import Point, Quaternion
from worlds.model import World
from worlds.things import Thing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Pose = tuple[Point, Quaternion]
"""Of a camera, optical axes (x right, y down, z out) to world; of a thing, its own to world."""

RENDERERS = {
    "raster": "hal.raster:Raster",
    "tiny": "hal.sim.bullet_renderers:TinyView",
    "egl": "hal.sim.bullet_renderers:EglView",
}
"""By name, the modules that have them: none is imported before a picture is wanted."""
_WINDOW = "hal.sim.bullet_renderers:show"


class Renderer(Protocol):
    """Takes pictures of one world."""

    def render(
        self, pose: Pose, intrinsics: Intrinsics, time: float, vehicles: Mapping[str, Pose]
    ) -> NDArray[np.uint8]:
        """A BGR picture (height, width, 3) of a pinhole camera; distortion is left out.

        Moving things stand where they are at ``time``. Of the vehicles that the renderer knows,
        those with a pose are seen.
        """

    def close(self) -> None:
        """Give its memory back."""


def check_renderer(name: object) -> str:
    """The name of a renderer. Raises UserError (``unknown-renderer``)."""
    if not isinstance(name, str) or name not in RENDERERS:
        raise UserError(
            "unknown-renderer",
            f"there is no renderer '{name}'",
            hint=nearest(str(name), RENDERERS),
        )
    return name


def open_renderer(
    name: str, world: World, vehicles: Mapping[str, Thing], *, shadows: bool = False
) -> Renderer:
    """A renderer of a world and of the looks of the vehicles in it.

    ``shadows``: what stands on the ground darkens it. Raises UserError for a name that is none,
    a texture that cannot be read, or a renderer that does not run here.
    """
    opened: Renderer = _named(RENDERERS[check_renderer(name)])(world, vehicles, shadows)
    return opened


def show_window(world: World) -> None:
    """Show a world in a window, until that is closed. Raises UserError without a display."""
    _named(_WINDOW)(world)


def _named(place: str) -> Any:
    module, _, attribute = place.partition(":")
    return getattr(import_module(module), attribute)
