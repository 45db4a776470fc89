"""Points and angles. Metres and radians; x east, y north, z up unless a caller says otherwise."""

from __future__ import annotations

from math import asin, atan2, cos, dist, hypot, pi, sin, sqrt
from typing import NamedTuple

Quaternion = tuple[float, float, float, float]
"""A rotation as (x, y, z, w), unit length."""

EARTH_RADIUS = 6_378_137.0
"""Equatorial radius of WGS 84, metres."""


class Point(NamedTuple):
    """A place or vector with three coordinates, in metres or metres per second."""

    x: float
    y: float
    z: float

    def plus(self, other: tuple[float, float, float]) -> Point:
        return Point(self.x + other[0], self.y + other[1], self.z + other[2])

    def minus(self, other: tuple[float, float, float]) -> Point:
        return Point(self.x - other[0], self.y - other[1], self.z - other[2])

    def times(self, factor: float) -> Point:
        return Point(self.x * factor, self.y * factor, self.z * factor)

    def norm(self) -> float:
        return sqrt(self.x * self.x + self.y * self.y + self.z * self.z)


Pose = tuple[Point, Quaternion]
"""The origin of a frame in an outer frame, and the rotation from the frame to the outer one."""

distance = dist
"""Straight-line distance between two points, metres."""


def bearing(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
    """Direction from ``a`` to ``b`` over the ground, counter-clockwise from east, radians."""
    return atan2(b[1] - a[1], b[0] - a[0])


def wrap(angle: float) -> float:
    """The equivalent angle in (−π, π], radians."""
    if -pi < angle <= pi:
        return angle
    turned = angle % (2 * pi)
    return turned - 2 * pi if turned > pi else turned


def yaw_of(q: Quaternion) -> float:
    """Heading of a body, counter-clockwise from east, radians (ZYX Euler angles)."""
    x, y, z, w = q
    return atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def roll_pitch_of(q: Quaternion) -> tuple[float, float]:
    """Roll and pitch of an FLU body, radians (ZYX Euler angles; pitch is positive nose down)."""
    x, y, z, w = q
    roll = atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return roll, asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))


def yaw_quaternion(yaw: float) -> Quaternion:
    """The attitude of a level body with heading ``yaw``, radians."""
    return (0.0, 0.0, sin(yaw / 2), cos(yaw / 2))


def about_x(angle: float) -> Quaternion:
    """The rotation about the x axis by ``angle``, radians."""
    return (sin(angle / 2), 0.0, 0.0, cos(angle / 2))


OPTICAL: Quaternion = (-0.5, 0.5, -0.5, 0.5)
"""The rotation from optical axes (x right, y down, z out) to body axes, for a camera along x."""


def about_y(angle: float) -> Quaternion:
    """The rotation about the y axis by ``angle``, radians."""
    return (0.0, sin(angle / 2), 0.0, cos(angle / 2))


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation ``b`` followed by the rotation ``a`` (the Hamilton product a·b)."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def turned(vector: tuple[float, float, float], q: Quaternion) -> Point:
    """Rotate a vector by a quaternion, as from body axes to the frame of the body's attitude."""
    (a, b, c), (x, y, z, w) = vector, q
    # v + 2·w·(q × v) + 2·q × (q × v)
    p, r, t = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return Point(a + w * p + y * t - z * r, b + w * r + z * p - x * t, c + w * t + x * r - y * p)


def rotate_xy(x: float, y: float, yaw: float) -> tuple[float, float]:
    """Rotate a vector (forward, left) of the heading frame to (east, north)."""
    c, s = cos(yaw), sin(yaw)
    return x * c - y * s, x * s + y * c


def enu_of(lat: float, lon: float, origin_lat: float, origin_lon: float) -> tuple[float, float]:
    """East and north of a place from an origin, metres. Latitudes and longitudes are in degrees.

    Equirectangular projection on a sphere of the equatorial radius, as ArduPilot's
    ``Location::get_distance_NE``; a few centimetres off at one kilometre.
    """
    to_rad = pi / 180
    east = (lon - origin_lon) * to_rad * EARTH_RADIUS * cos(origin_lat * to_rad)
    north = (lat - origin_lat) * to_rad * EARTH_RADIUS
    return east, north


def lat_lon_of(
    east: float, north: float, origin_lat: float, origin_lon: float
) -> tuple[float, float]:
    """Latitude and longitude of a place by its metres from an origin, degrees: :func:`enu_of` the
    other way round.
    """
    to_degrees = 180 / pi
    lat = origin_lat + north / EARTH_RADIUS * to_degrees
    lon = origin_lon + east / (EARTH_RADIUS * cos(origin_lat * pi / 180)) * to_degrees
    return lat, lon


def horizontal_distance(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
    """Distance over the ground, metres."""
    return hypot(a[0] - b[0], a[1] - b[1])
