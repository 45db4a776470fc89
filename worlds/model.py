"""What a world consists of. World frame: metres, x east, y north, z up; radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from vencejo.geometry import Point
from worlds.things import Color, Stripe, Terrain, Thing


@dataclass(frozen=True, slots=True)
class Origin:
    """Where the world frame's origin lies on the Earth (WGS 84)."""

    lat: float
    """Degrees."""
    lon: float
    """Degrees."""
    alt: float
    """Metres above mean sea level."""


@dataclass(frozen=True, slots=True)
class Ground:
    """The flat ground at z = 0: endless to stand on, coloured over a square about the origin."""

    color: Color
    size: float
    """Length of the coloured square's side, metres."""
    texture: Path | None = None
    """A picture laid over it, tiled."""
    tile: float = 10.0
    """Side of one tile of that picture, metres."""
    stripes: tuple[Stripe, ...] = ()
    """Painted in order, later ones over earlier ones."""
    terrain: Terrain | None = None


@dataclass(frozen=True, slots=True)
class Road:
    """The line of a road; what is to be seen of it are stripes of the ground."""

    name: str
    points: tuple[tuple[float, float], ...]
    """Its middle, x and y in metres; smooth curves are sampled."""
    width: float


@dataclass(frozen=True, slots=True)
class Start:
    """Where a vehicle stands when the run begins."""

    at: Point
    heading: float
    """Counter-clockwise from east, radians."""


@dataclass(frozen=True, slots=True)
class Light:
    """The sun and the sky."""

    sun: tuple[float, float, float] = (0.3, -0.5, 0.8)
    """Towards the sun."""
    ambient: float = 0.6
    """What a face turned away from the sun still shows of its colour, 0 to 1."""
    sky: Color = (150, 190, 230)


@dataclass(frozen=True, slots=True)
class World:
    """A place to fly in."""

    name: str
    description: str
    origin: Origin | None
    """None where the file does not say."""
    ground: Ground
    starts: tuple[Start, ...]
    """At least one."""
    battery: float
    """Charge of every vehicle when the run begins, 0 to 1."""
    places: Mapping[str, Point] = field(hash=False)
    """Named places, the beacons among them."""
    source: Path
    """The file it was read from; of a generated world, its word: ``roads:17``."""
    sha256: str
    """Of that file and of those it names, hexadecimal; of a generated world, of its text."""
    things: tuple[Thing, ...] = ()
    """Everything to be seen and hit, in the order of the kinds."""
    roads: tuple[Road, ...] = ()
    text: str = ""
    """The world file, as read."""
    files: tuple[Path, ...] = ()
    """The file itself and the pictures, meshes and models it names; a generated world has none."""
    light: Light = field(default_factory=Light)
