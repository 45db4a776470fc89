"""The shadows of everything in the buffers, at one moment."""

from __future__ import annotations

from collections.abc import Iterable

from hal.raster.buffers import GeometryBuffers
from hal.scene.arrays import Float64s
from hal.scene.shadows import ground_shadow


class Shadows:
    """Polygons on the flat ground: those of what stands still are computed once."""

    def __init__(self, geometry: GeometryBuffers, sun: Float64s) -> None:
        """``sun``: the unit vector towards the sun, world frame."""
        self._geometry = geometry
        self._sun = sun
        owners = list(enumerate(geometry.owner))
        self._moving = [surface for surface, owner in owners if owner >= 0]
        self._still = self._cast(surface for surface, owner in owners if owner < 0)

    def polygons(self) -> list[Float64s]:
        """Corners (n, 3) of each shadow, world frame, counter-clockwise from above."""
        visible = self._geometry.visible
        return self._still + self._cast(surface for surface in self._moving if visible[surface])

    def _cast(self, surfaces: Iterable[int]) -> list[Float64s]:
        hulls = (self._geometry.hull(surface) for surface in surfaces)
        shadows = (ground_shadow(hull, self._sun) for hull in hulls)
        return [shadow for shadow in shadows if shadow is not None]
