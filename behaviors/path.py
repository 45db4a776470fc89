"""Paths: curves in space by the way along them, and the two kinds of them that points make.

A path is a sequence of nodes with a place, a direction and the way from its begin; between two of
them runs a cubic Hermite curve, which meets the directions at both. On straight lines it is exact;
curves have nodes near enough to each other.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import acos, ceil, cos, sin, tan

from vencejo.geometry import Point, distance

SAME = 1e-6
"""Places that are nearer to each other than this are one, metres."""
ANGLE_STEP = 0.1
"""Turn of a curve between two nodes, radians."""
_STRAIGHT = 1e-3
"""Turns below this are none, radians."""
_REVERSAL = 2.9
"""Turns above this are no corners but reversals, radians: their arc would be a point."""


@dataclass(frozen=True)
class Path:
    """A curve, mission frame, metres. It has one node or more."""

    places: Sequence[Point]
    directions: Sequence[Point]
    """The unit tangent at each node; at a corner, the mean of those on its two sides."""
    ways: Sequence[float]
    """The way of each node from the begin, metres."""

    @property
    def length(self) -> float:
        return self.ways[-1]

    def node_before(self, way: float) -> int:
        """The number of the last node up to a way, but not that of the end."""
        return max(0, min(bisect_right(self.ways, way), len(self.ways) - 1) - 1)

    def place(self, way: float) -> Point:
        """The place at a way, kept between begin and end."""
        if way <= 0.0 or len(self.ways) == 1:
            return self.places[0]
        if way >= self.ways[-1]:
            return self.places[-1]
        k = self.node_before(way)
        a, b, u, v = self.places[k], self.places[k + 1], self.directions[k], self.directions[k + 1]
        h = self.ways[k + 1] - self.ways[k]
        t = (way - self.ways[k]) / h
        # The basis of Hermite's cubic.
        r = 1.0 - t
        p, q = t * t * (3.0 - 2.0 * t), t * r * r * h
        s, o = t * t * r * h, r * r * (1.0 + 2.0 * t)
        return Point(
            o * a[0] + p * b[0] + q * u[0] - s * v[0],
            o * a[1] + p * b[1] + q * u[1] - s * v[1],
            o * a[2] + p * b[2] + q * u[2] - s * v[2],
        )

    def direction(self, way: float) -> Point:
        """The direction at a way: that of its node, or between those of two."""
        if len(self.ways) == 1:
            return self.directions[0]
        k = self.node_before(way)
        t = (way - self.ways[k]) / (self.ways[k + 1] - self.ways[k])
        t = max(0.0, min(1.0, t))
        u, v = self.directions[k], self.directions[k + 1]
        mean = Point(*(a + (b - a) * t for a, b in zip(u, v, strict=True)))
        size = mean.norm()
        return mean.times(1 / size) if size > SAME else v

    def bends(self) -> list[float]:
        """The largest curvature between each two nodes, 1/m: the second derivative at either."""
        found = []
        for k in range(len(self.ways) - 1):
            h = self.ways[k + 1] - self.ways[k]
            way = self.places[k + 1].minus(self.places[k]).times(6 / (h * h))
            u, v = self.directions[k], self.directions[k + 1]
            begin = way.minus(u.times(4 / h)).minus(v.times(2 / h))
            end = u.times(2 / h).plus(v.times(4 / h)).minus(way)
            found.append(max(begin.norm(), end.norm()))
        return found


class PathBuilder:
    """Puts the nodes of a path together."""

    def __init__(self, begin: Point, direction: Point) -> None:
        self._places, self._directions, self._ways = [begin], [direction], [0.0]

    @property
    def way(self) -> float:
        """The way so far, metres."""
        return self._ways[-1]

    @property
    def end(self) -> Point:
        return self._places[-1]

    def add(self, place: Point, direction: Point, length: float) -> None:
        """Go on to a place that is reached in a direction, after ``length`` metres."""
        if length <= SAME:
            self._directions[-1] = direction
            return
        self._places.append(place)
        self._directions.append(direction)
        self._ways.append(self._ways[-1] + length)

    def line(self, to: Point) -> None:
        """Go on straight to a place."""
        length = distance(self.end, to)
        if length > SAME:
            direction = to.minus(self.end).times(1 / length)
            self._directions[-1] = direction
            self.add(to, direction, length)

    def arc(self, to: Point, into: Point) -> None:
        """Go on to a place by a circle's arc, which leaves it in the direction ``into``."""
        begin, u = self.end, self._directions[-1]
        turn = angle_between(u, into)
        radius = distance(begin, to) / (2 * sin(turn / 2))
        # From the begin to the circle's centre, at right angles to the direction.
        inward = into.minus(u.times(cos(turn)))
        inward = inward.times(1 / inward.norm())
        parts = ceil(turn / ANGLE_STEP)
        for k in range(1, parts):
            angle = turn * k / parts
            x, y = radius * sin(angle), radius * (1 - cos(angle))
            place = begin.plus(u.times(x)).plus(inward.times(y))
            direction = u.times(cos(angle)).plus(inward.times(sin(angle)))
            self.add(place, direction, radius * turn / parts)
        self.add(to, into, radius * turn / parts)

    def path(self) -> Path:
        return Path(tuple(self._places), tuple(self._directions), tuple(self._ways))


@dataclass(frozen=True)
class Corner:
    """A point through which a path of straight lines leads, or near which it passes."""

    place: Point
    deviation: float
    """Largest distance at which the path may pass it, metres."""


def blended(corners: Sequence[Corner]) -> tuple[Path, list[float]]:
    """The path along straight lines with arcs at the corners, and the way of each corner on it.

    An arc touches both its lines, up to the middle of either, and passes its corner within the
    deviation. The path begins and ends at the first and the last corner, and must not turn back at
    one between (see :func:`turns_back`).
    """
    apart = [
        corner
        for k, corner in enumerate(corners)
        if k == 0 or distance(corner.place, corners[k - 1].place) > SAME
    ]
    builder = PathBuilder(apart[0].place, Point(1.0, 0.0, 0.0))
    ways = [0.0]
    for before, corner, after in zip(apart, apart[1:], [*apart[2:], None], strict=False):
        ways.append(_add_corner(builder, before, corner, after))
    number = -1
    passed = []
    for k, corner in enumerate(corners):
        number += k == 0 or distance(corner.place, corners[k - 1].place) > SAME
        passed.append(ways[number])
    return builder.path(), passed


def _add_corner(
    builder: PathBuilder, before: Corner, corner: Corner, after: Corner | None
) -> float:
    """Go on past a corner, or to it if nothing is ``after``; the way at which that is passed."""
    arriving, length = _direction(before.place, corner.place)
    leaving, ahead = _direction(corner.place, after.place) if after else (arriving, 0.0)
    turn = angle_between(arriving, leaving)
    if turn <= _STRAIGHT:
        builder.line(corner.place)
        return builder.way
    # An arc with tangents of length h has the radius h/tan(turn/2), and h·tan(turn/4) is its
    # distance from the corner.
    h = min(length / 2, ahead / 2, corner.deviation / tan(turn / 4))
    builder.line(corner.place.minus(arriving.times(h)))
    begin = builder.way
    builder.arc(corner.place.plus(leaving.times(h)), leaving)
    return (begin + builder.way) / 2


def turns_back(a: Point, b: Point, c: Point) -> bool:
    """Whether the way from ``a`` to ``c`` turns back at ``b``, so that no arc is possible there."""
    if distance(a, b) <= SAME or distance(b, c) <= SAME:
        return False
    return angle_between(_direction(a, b)[0], _direction(b, c)[0]) > _REVERSAL


def _direction(a: Point, b: Point) -> tuple[Point, float]:
    """The direction from a place to another one, and the distance."""
    length = distance(a, b)
    return b.minus(a).times(1 / length), length


def angle_between(u: Point, v: Point) -> float:
    """The angle between two unit vectors, radians."""
    return acos(max(-1.0, min(1.0, u.x * v.x + u.y * v.y + u.z * v.z)))


def traced(
    place: Callable[[float], Point], derivative: Callable[[float], Point], values: Sequence[float]
) -> tuple[Path, list[float]]:
    """The path that a place draws as its parameter takes some values, and the speed at each.

    ``derivative`` is that by the parameter, and so is the speed. It must be nowhere zero, and the
    values near enough for its bends (ANGLE_STEP).
    """
    speeds = [derivative(value).norm() for value in values]
    builder = PathBuilder(place(values[0]), derivative(values[0]).times(1 / speeds[0]))
    for k in range(1, len(values)):
        a, b = values[k - 1], values[k]
        # Simpson's rule.
        middle = derivative((a + b) / 2).norm()
        length = (speeds[k - 1] + 4 * middle + speeds[k]) * (b - a) / 6
        builder.add(place(b), derivative(b).times(1 / speeds[k]), length)
    return builder.path(), speeds


def joined(first: Path, second: Path) -> Path:
    """Two paths, the second of which begins where and as the first ends."""
    return Path(
        [*first.places, *second.places[1:]],
        [*first.directions, *second.directions[1:]],
        [*first.ways, *(first.length + way for way in second.ways[1:])],
    )


def repeated(path: Path, times: int) -> Path:
    """A closed path, flown so many times."""
    places, directions, ways = list(path.places), list(path.directions), list(path.ways)
    for lap in range(1, times):
        places += path.places[1:]
        directions += path.directions[1:]
        ways += [way + lap * path.length for way in path.ways[1:]]
    return Path(places, directions, ways)


def spline(points: Sequence[Point], closed: bool = False) -> tuple[Path, list[float]]:
    """The cubic spline through points, and the way of each: natural, or periodic if ``closed``.

    Its parameter is the length of the chords between the points, and its second derivative is
    continuous (C. de Boor, *A Practical Guide to Splines*, ch. IV). A closed one comes back to its
    first point. Points must differ from those beside them.
    """
    if closed and distance(points[0], points[-1]) > SAME:
        points = [*points, points[0]]
    if len(points) < (4 if closed else 3):
        return blended([Corner(point, 0.0) for point in points])
    chords = [distance(a, b) for a, b in pairwise(points)]
    columns = [_moments([p[axis] for p in points], chords, closed) for axis in range(3)]
    moments = [Point(*each) for each in zip(*columns, strict=True)]
    builder: PathBuilder | None = None
    passed = [0.0]
    for k, chord in enumerate(chords):
        piece = _Cubic(points[k], points[k + 1], moments[k], moments[k + 1], chord)
        if builder is None:
            begin = piece.derivative(0.0)
            builder = PathBuilder(points[0], begin.times(1 / begin.norm()))
        piece.add_to(builder)
        passed.append(builder.way)
    assert builder is not None
    return builder.path(), passed


@dataclass(frozen=True)
class _Cubic:
    """A piece of a spline, by the second derivatives (moments) at its ends."""

    a: Point
    b: Point
    moment_a: Point
    moment_b: Point
    h: float

    def place(self, t: float) -> Point:
        h, r = self.h, self.h - t
        return Point(
            *(
                (m * r**3 + n * t**3) / (6 * h) + (a / h - m * h / 6) * r + (b / h - n * h / 6) * t
                for a, b, m, n in zip(self.a, self.b, self.moment_a, self.moment_b, strict=True)
            )
        )

    def derivative(self, t: float) -> Point:
        h, r = self.h, self.h - t
        return Point(
            *(
                (n * t * t - m * r * r) / (2 * h) + (b - a) / h - (n - m) * h / 6
                for a, b, m, n in zip(self.a, self.b, self.moment_a, self.moment_b, strict=True)
            )
        )

    def add_to(self, builder: PathBuilder) -> None:
        """Add nodes that are near enough to each other for the bend of the piece."""
        bend = max(self.moment_a.norm(), self.moment_b.norm())
        parts = max(4, ceil(2 * bend * self.h / ANGLE_STEP))
        dt = self.h / parts
        speed = self.derivative(0.0).norm()
        for k in range(1, parts + 1):
            t = self.h if k == parts else k * dt
            tangent = self.derivative(t)
            # Simpson's rule.
            middle, after = self.derivative(t - dt / 2).norm(), tangent.norm()
            length = (speed + 4 * middle + after) * dt / 6
            speed = after
            if after > SAME:
                builder.add(self.place(t), tangent.times(1 / after), length)


def _moments(values: Sequence[float], h: Sequence[float], closed: bool) -> list[float]:
    """The second derivatives of the spline through values, h apart, in one coordinate."""
    slopes = [(b - a) / d for a, b, d in zip(values, values[1:], h, strict=False)]
    n = len(h)
    if not closed:
        inner = [6 * (slopes[k] - slopes[k - 1]) for k in range(1, n)]
        diagonal = [2 * (h[k - 1] + h[k]) for k in range(1, n)]
        return [0.0, *_solved(diagonal, h[1 : n - 1], inner), 0.0]
    right = [6 * (slopes[k] - slopes[k - 1]) for k in range(n)]
    diagonal = [2 * (h[k - 1] + h[k]) for k in range(n)]
    # The corners of the cyclic matrix are taken out by the formula of Sherman and Morrison.
    corner = h[-1]
    gamma = -diagonal[0]
    diagonal[0] -= gamma
    diagonal[-1] -= corner * corner / gamma
    x = _solved(diagonal, h[: n - 1], right)
    z = _solved(diagonal, h[: n - 1], [gamma, *[0.0] * (n - 2), corner])
    share = (x[0] + x[-1] * corner / gamma) / (1 + z[0] + z[-1] * corner / gamma)
    moments = [a - share * b for a, b in zip(x, z, strict=True)]
    return [*moments, moments[0]]


def _solved(
    diagonal: Sequence[float], beside: Sequence[float], right: Sequence[float]
) -> list[float]:
    """The solution of a symmetric tridiagonal system (Thomas's algorithm)."""
    scale, found = [diagonal[0]], [right[0]]
    for k in range(1, len(diagonal)):
        factor = beside[k - 1] / scale[-1]
        scale.append(diagonal[k] - factor * beside[k - 1])
        found.append(right[k] - factor * found[-1])
    for k in reversed(range(len(diagonal))):
        ahead = beside[k] * found[k + 1] if k + 1 < len(diagonal) else 0.0
        found[k] = (found[k] - ahead) / scale[k]
    return found
