"""What a world consists of. World frame: metres, x east, y north, z up; radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, sin
from pathlib import Path

from vencejo.geometry import Point
from worlds.things import Color, Stripe, Terrain, Thing

START_CLEARANCE = 0.4
"""Free room that a vehicle needs beside its start, metres."""


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
class Box:
    """A solid cuboid that nothing moves."""

    name: str
    at: Point
    """The middle of its lower face."""
    size: Point
    """Along its own x, y and z, metres."""
    heading: float
    """Counter-clockwise from east, radians."""
    color: Color

    @property
    def top(self) -> float:
        """World height of its upper face, metres."""
        return self.at.z + self.size.z

    def contains(self, place: Point, margin: float = 0.0) -> bool:
        """Whether a place is inside, or less than ``margin`` metres beside or below it.

        A place on or above the upper face is not inside.
        """
        c, s = cos(self.heading), sin(self.heading)
        east, north = place.x - self.at.x, place.y - self.at.y
        along, across = east * c + north * s, north * c - east * s
        return (
            abs(along) < self.size.x / 2 + margin
            and abs(across) < self.size.y / 2 + margin
            and self.at.z - margin < place.z < self.top
        )


@dataclass(frozen=True, slots=True)
class Beacon:
    """A coloured mark in the air: seen in pictures, flown through."""

    name: str
    at: Point
    color: Color


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
    boxes: tuple[Box, ...]
    beacons: tuple[Beacon, ...]
    places: Mapping[str, Point] = field(hash=False)
    """Named places, the beacons among them."""
    source: Path
    """The file it was read from."""
    sha256: str
    """Of that file's bytes, hexadecimal."""
    things: tuple[Thing, ...] = ()
    """Everything to be seen and hit, the boxes and beacons among them."""
    light: Light = field(default_factory=Light)

    def box_near(self, start: Point) -> Box | None:
        """A box that leaves no room for a vehicle to start at a place."""
        return next((box for box in self.boxes if box.contains(start, START_CLEARANCE)), None)
