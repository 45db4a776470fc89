"""The things in a world: their shapes, colours, textures and motions.

World frame: metres, x east, y north, z up. Attitudes are quaternions (x, y, z, w), local to world.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vencejo.geometry import Point, Quaternion

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Color = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""
UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Image:
    """An image file, stretched over the face it is on."""

    path: Path


@dataclass(frozen=True, slots=True)
class Fiducial:
    """A square marker with a white border of one module, filling its plate (worlds.markers)."""

    dictionary: str
    """OpenCV's name without DICT_: ``4X4_50``, ``APRILTAG_36h11``, ``ARUCO_ORIGINAL``."""
    id: int
    inside: Fiducial | None = None
    """A smaller one in its middle, for whoever is too near to see all of this one."""
    share: float = 0.0
    """Side of the plate of the one inside over the side of this one's plate."""


@dataclass(frozen=True, slots=True)
class Charuco:
    """A chessboard with markers in its white squares, filling its plate without a border."""

    dictionary: str
    columns: int
    rows: int
    marker: float
    """Side of a marker over the side of a square, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Roundel:
    """The oriented roundel, filling its plate (worlds.roundel)."""


Texture = Image | Fiducial | Charuco | Roundel


@dataclass(frozen=True, slots=True)
class Cuboid:
    """Centred on its origin."""

    size: Point


@dataclass(frozen=True, slots=True)
class Cylinder:
    """Along z, centred on its origin."""

    radius: float
    height: float


@dataclass(frozen=True, slots=True)
class Sphere:
    """Centred on its origin."""

    radius: float
    leafy: bool = False
    """True to be seen with light and dark leaves, as a tree's crown; others are of one tone."""


@dataclass(frozen=True, slots=True)
class Plate:
    """A rectangle without thickness in the x-y plane, centred, seen from above (+z) only.

    Its texture's upper edge is at +y, its left edge at −x.
    """

    width: float
    """Along x."""
    height: float
    """Along y."""


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles, counter-clockwise seen from outside."""

    vertices: NDArray[np.float64]
    """(n, 3), metres."""
    faces: NDArray[np.int32]
    """(m, 3), indices of vertices."""


Shape = Cuboid | Cylinder | Sphere | Plate | Mesh


@dataclass(frozen=True, slots=True)
class Part:
    """One shape of a thing, in the thing's own frame."""

    shape: Shape
    at: Point
    """The shape's origin."""
    attitude: Quaternion
    color: Color
    texture: Texture | None = None
    """Image on every face of a cuboid or on a plate; other shapes have none."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A path that a thing follows at a constant speed, from the beginning of the run on.

    Compared and hashed by identity, so that to look up a long one takes no longer.
    """

    points: tuple[Point, ...]
    """Path of the thing's origin, world frame, metres."""
    speed: float
    """m/s."""
    loop: bool
    """True for a closed path; otherwise the thing turns back at both ends."""
    turns: bool
    """True when its heading follows the path."""


@dataclass(frozen=True, slots=True)
class Thing:
    """A rigid group of parts with a name."""

    name: str
    kind: str
    """``box``, ``house``, ``marker``, …"""
    at: Point
    attitude: Quaternion
    parts: tuple[Part, ...]
    solid: bool = True
    """True when vehicles collide with it; with plates they never do."""
    motion: Motion | None = None
    charges: float = 0.0
    """Power with which it charges a vehicle that stands on it with its motors off, watts."""


@dataclass(frozen=True, slots=True)
class Stripe:
    """A painted line on the ground: a road, its edge lines, a mark."""

    points: tuple[tuple[float, float], ...]
    """The centre line, x and y in metres; smooth curves are sampled already."""
    width: float
    color: Color


@dataclass(frozen=True, slots=True)
class Terrain:
    """Heights over a square about the origin, metres; flat at its border value outside."""

    heights: tuple[tuple[float, ...], ...]
    """Rows from south to north, each from west to east."""
    size: float
    """Side of the square."""
