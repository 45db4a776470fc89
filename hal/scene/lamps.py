"""The lamps of vehicles in pictures: one small thing for each colour a lamp can have.

A renderer shows those of its vehicles that have a pose: a lamp that is lit gives its body's pose to
the thing of its colour, and so every renderer can show lamps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt

from hal.lights import COLORS, Rgb
from vencejo.geometry import Point, Pose
from worlds.things import UPRIGHT, Cuboid, Part, Thing

_SIZE = 0.05
"""Largest edge of a lamp, metres."""
_OFF: Rgb = (0, 0, 0)


def lamp_things(vehicle: str, *, arm: float, height: float) -> dict[str, Thing]:
    """The lamps of a vehicle in every colour, below its rotors, by names for :func:`lit_lamps`.

    ``arm`` is the distance from the centre to a rotor, ``height`` that of the body; metres.
    """
    out = arm / sqrt(2)
    # Front left, front right, rear right, rear left, as hal.lights counts them.
    places = ((out, out), (out, -out), (-out, -out), (-out, out))
    edge = min(_SIZE, height / 2)
    origin, cube = Point(0.0, 0.0, 0.0), Cuboid(Point(edge, edge, edge))
    return {
        _name(vehicle, lamp, color): Thing(
            _name(vehicle, lamp, color),
            "lamp",
            origin,
            UPRIGHT,
            (Part(cube, Point(x, y, -height * 0.2), UPRIGHT, color),),
        )
        for lamp, (x, y) in enumerate(places)
        for color in COLORS.values()
    }


def lit_lamps(vehicle: str, colors: Sequence[Rgb], body: Pose) -> Mapping[str, Pose]:
    """The poses of the lamps that shine, by the name of their thing."""
    return {_name(vehicle, k, color): body for k, color in enumerate(colors) if color != _OFF}


def _name(vehicle: str, lamp: int, color: Rgb) -> str:
    return f"{vehicle}/lamp {lamp}/{color}"
