"""Generated narrow roads, to be followed by sight: with gaps, branches, shadows, and things of
their colour beside them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, dist, hypot, pi, sin, tan
from random import Random

from vencejo.polylines import XY
from worlds import curves

_STEP = 0.25
"""Way between the points of a bend, metres."""
_APART = 3.0
"""Least distance of a road's parts from each other, metres."""
_CLEAR = 1.5
"""Least way from a gap or a branch to a corner, metres."""
_ROOF = 40.0
"""Height of the boards whose shadows fall on a road, metres."""
_SUN = 1.0
"""Height of the sun, radians."""


@dataclass(frozen=True)
class _Road:
    """A centre line from its begin to its end, metres."""

    line: tuple[XY, ...]
    corners: tuple[float, ...]
    """The ways at which it has sharp corners."""

    @property
    def length(self) -> float:
        return curves.length(self.line)

    def at(self, way: float) -> tuple[XY, float]:
        """The place at a way, and the direction there, radians."""
        (x, y), *_, (u, v) = curves.piece(self.line, way, way + 0.1)
        return (x, y), atan2(v - y, u - x)

    def is_clear(self, way: float) -> bool:
        """Whether no corner is near a way."""
        return all(abs(way - corner) > _CLEAR for corner in self.corners)

    def keeps_away(self) -> bool:
        """Whether no two of its parts come near each other."""
        places = curves.every(self.line, 0.5)
        later = round(4 * _APART)  # twice as far along the road as beside it
        return all(dist(a, b) > _APART for k, a in enumerate(places) for b in places[k + later :])


def narrow_roads(number: int, random: Random) -> str:
    """A road of 0.5 to 1.2 m that begins below the start, with bends of 3 m radius or more.

    It may have gaps of up to 1 m and a branch; beside it lie patches of its colour. Boards high
    above throw shadows on it (``--shadows``). The vehicle's nose points anywhere at the start; the
    road ends at the place `end`.
    """
    road = _bends(random)
    while not road.keeps_away():
        road = _bends(random)
    return _world(f"narrow_roads_{number}", road, random)


def corner_roads(number: int, random: Random) -> str:
    """A road like those of ``narrow_roads`` with sharp corners only; two may be a hairpin."""
    road = _corners(random)
    while not road.keeps_away():
        road = _corners(random)
    return _world(f"corner_roads_{number}", road, random)


def _bends(random: Random) -> _Road:
    """A road of straights and arcs."""
    (x, y), heading = (0.0, 0.0), 0.0
    line, side = [(x, y)], random.choice((-1, 1))
    for part in range(random.randint(4, 6)):
        straight = random.uniform(1, 6) if part else 4.0
        radius = random.uniform(3, 7)
        turn = random.uniform(0.5, 2.6)
        bends = [0.0] * round(straight / _STEP) + [side / radius] * round(turn * radius / _STEP)
        for bend in bends:
            middle = heading + bend * _STEP / 2
            x, y = x + _STEP * cos(middle), y + _STEP * sin(middle)
            heading += bend * _STEP
            line.append((x, y))
        side = side if random.random() < 0.3 else -side
    return _Road(tuple(line), ())


def _corners(random: Random) -> _Road:
    """A road of straight lines with right angles between them."""
    line, heading = [(0.0, 0.0), (random.uniform(4, 6), 0.0)], 0.0
    side = random.choice((-1, 1))
    for _ in range(random.randint(5, 7)):
        side = side if random.random() < 0.4 else -side
        heading += side * pi / 2
        step = random.uniform(3.5, 7)
        x, y = line[-1]
        line.append((x + step * cos(heading), y + step * sin(heading)))
    ways, passed = [], 0.0
    for a, b in pairwise(line):
        passed += dist(a, b)
        ways.append(passed)
    return _Road(tuple(line), tuple(ways[:-1]))


def _world(name: str, road: _Road, random: Random) -> str:
    """The file of a world with a road."""
    width, long = round(random.uniform(0.5, 1.2), 2), road.length
    ways = [random.uniform(0.2, 0.4) * long, random.uniform(0.65, 0.85) * long]
    gaps = [(way, way + random.uniform(0.3, 1.0)) for way in ways if random.random() < 0.7]
    gaps = [gap for gap in gaps if all(map(road.is_clear, gap))]
    x, y = road.line[-1]
    sun = random.uniform(-pi, pi)
    ground = random.choice(("grass", "grass", "sand"))
    out = [
        f"world: {name}",
        f"description: A narrow road, {long:.0f} m long and {width:g} m wide.",
        f"ground: {{color: {ground}, size: 240 m}}",
        f"light: {{heading: {sun:.2f}, height: {_SUN:g}, ambient: 55 %}}",
        f"start: {{at: [0, 0], heading: {random.uniform(-pi, pi):.2f}}}",
        "roads:",
        f"  main: {{through: {_listed(road.line)}, width: {width:g},"
        f" gaps: [{', '.join(f'[{a:.2f}, {b:.2f}]' for a, b in gaps)}]}}",
    ]
    if random.random() < 0.7:
        out.append(_branch(road, width, gaps, random))
    out += [_patch(k, road, width, random) for k in range(random.randint(2, 5))]
    out.append("boxes:")
    out += [_board(k, road, sun, random) for k in range(4)]
    out.append(f"places: {{end: [{x:.2f}, {y:.2f}, 0]}}")
    return "\n".join(out) + "\n"


def _branch(road: _Road, width: float, gaps: Sequence[XY], random: Random) -> str:
    """A straight road that leaves another one."""
    while True:
        way = random.uniform(0.35, 0.65) * road.length
        if road.is_clear(way) and all(not a - 2 < way < b + 2 for a, b in gaps):
            break
    begin, heading = road.at(way)
    heading += random.choice((-1, 1)) * random.uniform(0.9, pi / 2)
    end = (begin[0] + 6 * cos(heading), begin[1] + 6 * sin(heading))
    return f"  branch: {{through: {_listed([begin, end])}, width: {width:g}, crossing: true}}"


def _patch(number: int, road: _Road, width: float, random: Random) -> str:
    """A patch of a road's colour beside it."""
    (x, y), heading = road.at(random.uniform(0.1, 0.95) * road.length)
    long, wide = random.uniform(0.4, 2.0), random.uniform(0.3, 1.5)
    aside = width / 2 + random.uniform(0.0, 0.8) + hypot(long, wide) / 2
    across = heading + random.choice((-1, 1)) * pi / 2
    x, y = x + aside * cos(across), y + aside * sin(across)
    turn = random.uniform(-pi, pi)
    dx, dy = long / 2 * cos(turn), long / 2 * sin(turn)
    ends = [(x - dx, y - dy), (x + dx, y + dy)]
    return f"  patch_{number + 1}: {{through: {_listed(ends)}, width: {wide:.2f}}}"


def _board(number: int, road: _Road, sun: float, random: Random) -> str:
    """A board high above whose shadow falls across a road."""
    (x, y), heading = road.at((number + random.uniform(0.1, 0.9)) * road.length / 4)
    away = _ROOF / tan(_SUN)
    x, y = x + away * cos(sun), y + away * sin(sun)
    turn = heading + random.uniform(0.3, 2.8)
    size = f"[{random.uniform(4, 7):.1f}, {random.uniform(0.4, 2):.1f}, 0.1]"
    return (
        f"  board_{number + 1}:"
        f" {{at: [{x:.2f}, {y:.2f}, {_ROOF:g}], size: {size}, heading: {turn:.2f}}}"
    )


def _listed(points: Sequence[XY]) -> str:
    return "[" + ", ".join(f"[{x:.3f}, {y:.3f}]" for x, y in points) + "]"
