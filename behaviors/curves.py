"""Smooth closed paths with names: circle and lemniscate."""

from __future__ import annotations

from math import acos, ceil, cos, pi, sin, sqrt

from behaviors.pace import Pace
from behaviors.path import ANGLE_STEP, Path, repeated, traced
from vencejo.geometry import Point, bearing, horizontal_distance, rotate_xy

_NEAR = 1.0
"""Distance outside a circle up to which it is met by a spiral, metres."""
_SWEEP = pi / 2
"""Angle in which that spiral meets it at the most, radians."""
_ON_IT = 0.3
"""Distance from a circle below which the vehicle is on it, metres."""


def circle(centre: Point, radius: float, begin: float, turns: float, climb: float = 0.0) -> Path:
    """A circle, or a helix, about a point, at its height.

    ``begin`` is the direction of its first place from the centre, radians; ``turns`` is negative
    for clockwise; ``climb`` is the height gained in a turn, metres.
    """
    turn, rise = (1.0 if turns > 0 else -1.0), climb / (2 * pi)
    parts = max(1, ceil(abs(turns) * 2 * pi / ANGLE_STEP))
    angles = [abs(turns) * 2 * pi * k / parts for k in range(parts + 1)]

    def place(angle: float) -> Point:
        at = begin + turn * angle
        return centre.plus((radius * cos(at), radius * sin(at), rise * angle))

    def derivative(angle: float) -> Point:
        at = begin + turn * angle
        return Point(-turn * radius * sin(at), turn * radius * cos(at), rise)

    return traced(place, derivative, angles)[0]


def onto_circle(here: Point, centre: Point, radius: float, turn: float) -> tuple[Path, float]:
    """A path from a place onto a circle, which it meets along it and level at the centre's height.

    ``turn`` is 1 for a circle flown counter-clockwise, -1 for clockwise. From outside it is the
    tangent, from inside and near by a spiral; on the circle there is no way to go. Also returns
    the direction from the centre of the place where they meet, radians.
    """
    away, direction = horizontal_distance(centre, here), bearing(centre, here)
    rise = centre.z - here.z
    apart = max(abs(radius - away), abs(rise))
    if apart < _ON_IT:
        rim = centre.plus((radius * cos(direction), radius * sin(direction), 0.0))
        along = Point(-turn * sin(direction), turn * cos(direction), 0.0)
        return Path([rim], [along], [0.0]), direction
    if away > radius + _NEAR:
        meets = direction + turn * acos(radius / away)
        east = centre.x + radius * cos(meets) - here.x
        north = centre.y + radius * sin(meets) - here.y

        def place(t: float) -> Point:
            return here.plus((east * t, north * t, rise * t * t * (3 - 2 * t)))

        def derivative(t: float) -> Point:
            return Point(east, north, rise * 6 * t * (1 - t))

        return traced(place, derivative, [k / 40 for k in range(41)])[0], meets

    sweep = min(_SWEEP, 2 * apart / radius)

    def on_spiral(t: float) -> Point:
        r, at = away + (radius - away) * t * (2 - t), direction + turn * sweep * t
        level = centre.plus((r * cos(at), r * sin(at), 0.0))
        return level._replace(z=here.z + rise * t * t * (3 - 2 * t))

    def along_spiral(t: float) -> Point:
        r, at = away + (radius - away) * t * (2 - t), direction + turn * sweep * t
        out, around = (radius - away) * (2 - 2 * t), turn * sweep * r
        east, north = rotate_xy(out, around, at)
        return Point(east, north, rise * 6 * t * (1 - t))

    path, _ = traced(on_spiral, along_spiral, [k / 40 for k in range(41)])
    return path, direction + turn * sweep


def spiral(centre: Point, radius: float, spacing: float, begin: float, turn: float) -> Path:
    """Archimedes' spiral from a point outwards, up to a radius, its turns ``spacing`` metres apart.

    ``begin`` is the direction in which it leaves the point, radians; ``turn`` as for onto_circle.
    """
    gain, end = spacing / (2 * pi), 2 * pi * radius / spacing

    def place(angle: float) -> Point:
        at = begin + turn * angle
        return centre.plus((gain * angle * cos(at), gain * angle * sin(at), 0.0))

    def derivative(angle: float) -> Point:
        return Point(*rotate_xy(gain, turn * gain * angle, begin + turn * angle), 0.0)

    parts = ceil(end / ANGLE_STEP)
    return traced(place, derivative, [end * k / parts for k in range(parts + 1)])[0]


def lemniscate(
    centre: Point, length: float, width: float, heading: float, laps: int
) -> tuple[Path, Pace]:
    """The figure eight x = length/2·cos ωt, y = width/2·sin 2ωt, and its pace with ω = 1.

    ``heading`` is the direction of its length, where it also begins, radians.
    """
    a, b = length / 2, width / 2

    def place(angle: float) -> Point:
        x, y = rotate_xy(a * cos(angle), b * sin(2 * angle), heading)
        return centre.plus((x, y, 0.0))

    def derivative(angle: float) -> Point:
        x, y = rotate_xy(-a * sin(angle), 2 * b * cos(2 * angle), heading)
        return Point(x, y, 0.0)

    # A lap turns by 3π or so, at its tips faster than elsewhere.
    parts = ceil(16 * pi / ANGLE_STEP * max(1.0, sqrt(length / width), sqrt(width / length)))
    angles = [2 * pi * k / parts for k in range(parts + 1)]
    path, speeds = traced(place, derivative, angles)
    whole = repeated(path, laps)
    times = [2 * pi * k / parts for k in range(parts * laps + 1)]
    return whole, Pace(times, whole.ways, [*speeds, *speeds[1:] * (laps - 1)])
