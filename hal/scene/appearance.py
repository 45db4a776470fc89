"""The appearance of the simulated quadrotor in images."""

from __future__ import annotations

from hashlib import sha256
from math import sqrt

from vencejo.geometry import Point
from worlds.things import UPRIGHT, Color, Cuboid, Cylinder, Part, Thing

COLORS: tuple[Color, ...] = (
    (220, 30, 30),
    (30, 60, 220),
    (240, 220, 40),
    (30, 170, 50),
    (210, 40, 200),
    (245, 130, 20),
)
_NOSE_COLOR: Color = (40, 40, 45)


def color_of(name: str) -> Color:
    """The colour of a vehicle: always the same for a name."""
    return COLORS[sha256(name.encode()).digest()[0] % len(COLORS)]


ARM = 0.1785
"""Distance from an AR.Drone's centre to a rotor, metres."""
SIZE = (0.52, 0.52, 0.12)
"""Bounding box of an AR.Drone with its hull, along its body axes, metres."""


def quadrotor(
    name: str,
    *,
    arm: float = ARM,
    size: tuple[float, float, float] = SIZE,
    color: Color | None = None,
) -> Thing:
    """A hull in the vehicle's colour, a dark nose and four rotor guards, about its centre.

    ``arm`` is the distance from the centre to a rotor, ``size`` that of the box about the whole
    vehicle along its body axes; metres. Without a ``color`` its name decides.
    """
    origin, color = Point(0.0, 0.0, 0.0), color or color_of(name)
    out = arm / sqrt(2)
    length, _, height = size
    parts = [
        Part(Cuboid(Point(length * 0.5, length * 0.2, height * 0.6)), origin, UPRIGHT, color),
        Part(
            Cuboid(Point(length * 0.1, length * 0.12, height * 0.4)),
            Point(length * 0.3, 0.0, 0.0),
            UPRIGHT,
            _NOSE_COLOR,
        ),
    ]
    for x, y in ((out, out), (-out, out), (-out, -out), (out, -out)):
        guard = Cylinder(length / 2 - out - 0.005, height * 0.15)
        parts.append(Part(guard, Point(x, y, height * 0.4), UPRIGHT, color))
    return Thing(name, "vehicle", origin, UPRIGHT, tuple(parts))
