"""A world, as it was read. World frame: metres, x east, y north, z up; radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, log
from pathlib import Path

from vencejo.geometry import Point
from worlds.things import Color, Stripe, Terrain, Thing


@dataclass(frozen=True, slots=True)
class Origin:
    """The place of the world frame's origin on the Earth (WGS 84)."""

    lat: float
    """Degrees."""
    lon: float
    """Degrees."""
    alt: float
    """Metres above mean sea level."""


@dataclass(frozen=True, slots=True)
class Ground:
    """The ground: flat at z = 0, without end, coloured over a square about the origin."""

    color: Color
    size: float
    """Length of the coloured square's side, metres."""
    texture: Path | None = None
    """An image file that is repeated over the square."""
    tile: float = 10.0
    """Side of one repetition of that image, metres."""
    stripes: tuple[Stripe, ...] = ()
    """Painted in order, later ones over earlier ones."""
    terrain: Terrain | None = None
    """Hills over a part of it."""


@dataclass(frozen=True, slots=True)
class Road:
    """The line of a road; it is seen as stripes of the ground."""

    name: str
    points: tuple[tuple[float, float], ...]
    """The centre line, x and y in metres; smooth curves are sampled."""
    width: float


@dataclass(frozen=True, slots=True)
class Fence:
    """The space that vehicles are meant to stay in (see :mod:`worlds.fence`)."""

    corners: tuple[tuple[float, float], ...]
    """Of a polygon on the map, in order, three or more; the last is joined to the first."""
    floor: float = -inf
    """Least height to fly at, metres; take-off and landing may pass it."""
    ceiling: float = inf
    """Greatest height to fly at, metres."""


@dataclass(frozen=True, slots=True)
class Start:
    """The place of a vehicle when the run begins."""

    at: Point
    heading: float
    """Counter-clockwise from east, radians."""
    color: Color | None = None
    """The colour of the hull of a vehicle that starts here; None for no word on it."""


@dataclass(frozen=True, slots=True)
class Light:
    """The sun and the sky."""

    sun: tuple[float, float, float] = (0.3, -0.5, 0.8)
    """A vector towards the sun."""
    ambient: float = 0.6
    """Brightness of a face that is turned away from the sun, 0 to 1."""
    sky: Color = (150, 190, 230)


@dataclass(frozen=True, slots=True)
class Gusts:
    """Gusts of one shape: the wind rises along a cosine, and falls again (see :mod:`hal.sim`)."""

    to: float
    """Speed of the wind at their peak, m/s."""
    duration: float
    """Of one gust where it passes, seconds."""
    every: float
    """Mean time from the beginning of one gust to that of the next, which is random, seconds."""
    at: tuple[float, ...] = ()
    """Times at which they reach the world's origin, in order, instead of random ones."""


@dataclass(frozen=True, slots=True)
class Wind:
    """The wind of a world."""

    speed: float
    """Mean speed at ``height``, m/s."""
    bearing: float
    """The compass bearing it comes from, clockwise from north, degrees."""
    height: float = 10.0
    """Metres above z = 0."""
    roughness: float | None = None
    """Roughness length of the ground, metres: the wind is weaker below and stronger above; None
    for the same wind at every height."""
    gusts: Gusts | None = None
    turbulence: float = 0.0
    """The speed of the wind 20 feet above ground that makes the turbulence, m/s; 0 for none."""

    def share_at(self, z: float) -> float:
        """The wind at a height above z = 0 (m) over that at ``height``.

        Over rough ground it grows with the logarithm of the height, as in the surface layer (R.
        Stull, *An Introduction to Boundary Layer Meteorology*, Kluwer 1988).
        """
        rough = self.roughness
        if rough is None:
            return 1.0
        return log(z / rough) / log(self.height / rough) if z > rough else 0.0

    def __str__(self) -> str:
        gusts = f", gusts to {self.gusts.to:g} m/s" if self.gusts else ""
        turbulence = f", turbulence of {self.turbulence:.3g} m/s" if self.turbulence else ""
        return f"{self.speed:g} m/s from {self.bearing:g} deg{gusts}{turbulence}"


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
    """Hexadecimal; of that file and the files it names, or of a generated world's text."""
    things: tuple[Thing, ...] = ()
    """In the order of the kinds (see :mod:`worlds.kinds`)."""
    roads: tuple[Road, ...] = ()
    fence: Fence | None = None
    """The space to stay in; None where the file names none."""
    model: str | None = None
    """The name of the model of its vehicles, or the path of its file; None for no word on it."""
    text: str = ""
    """The world file, as read."""
    files: tuple[Path, ...] = ()
    """The file itself and the images, meshes and models it names; a generated world has none."""
    light: Light = field(default_factory=Light)
    wind: Wind | None = None
    """None for still air."""
