"""Families of generated worlds, by number: road 17, forest 3. Equal numbers give equal worlds.

Each function writes a world file. Every world of a family has the solution that its docstring
promises.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import cos, dist, pi, sin
from random import Random
from types import MappingProxyType

from vencejo.seeds import generator
from worlds import curves
from worlds.narrow_roads import corner_roads, narrow_roads

XY = tuple[float, float]
_BRIGHT = ("blue", "cyan", "green", "magenta", "orange", "purple", "red", "yellow")


def generate(family: str, number: int) -> str:
    """The text of the world file of that number in a family."""
    return FAMILIES[family](number, generator(number, "world", family))


# Roads.


def roads(number: int, random: Random) -> str:
    """A road that begins below the start, leads ahead, and ends at the place `end`.

    It bends smoothly or has sharp corners and keeps away from itself; it may have edge lines, a
    gap of up to 3 m and a branch.
    """
    width = random.choice((2.0, 3.0, 4.0))
    smooth = random.random() < 0.7
    corners = _corners(random, smooth, 4 * width)
    line = curves.smooth(corners) if smooth else corners
    long = curves.length(line)
    style = f"width: {width:g}, color: {random.choice(('asphalt', 'concrete', 'sand'))}"
    style += ", edges: white" if random.random() < 0.5 else ""
    keys = style + (", smooth: true" if smooth else "")
    if random.random() < 0.5:
        begin = random.uniform(0.3, 0.7) * long
        keys += f", gaps: [[{begin:.1f}, {begin + random.uniform(1, 3):.1f}]]"
    (x, y) = corners[-1]
    out = [
        f"world: roads_{number}",
        f"description: Generated road number {number}, {long:.0f} m long.",
        "ground: {color: grass, size: 600 m}",
        "start: {at: [0, 0]}",
        "roads:",
        f"  main: {{through: {_listed(corners)}, {keys}}}",
        f"places: {{end: [{x:g}, {y:g}, 0]}}",
    ]
    branch = _branch(random, line, 4 * width) if random.random() < 0.4 else None
    if branch:
        out.insert(-1, f"  branch: {{through: {_listed(branch)}, {style}}}")
    return "\n".join(out) + "\n"


def _corners(random: Random, smooth: bool, room: float) -> list[XY]:
    """Corners of a road, metres, no part of which comes nearer than ``room`` to another."""
    while True:
        line, heading = [(0.0, 0.0), (12.0, 0.0)], 0.0
        for _ in range(random.randint(4, 10)):
            heading += random.uniform(-1.2, 1.2) if smooth else random.choice((-1, 0, 1)) * pi / 2
            step = random.uniform(14, 24)
            x, y = line[-1]
            line.append((round(x + step * cos(heading), 1), round(y + step * sin(heading), 1)))
        places = curves.every(curves.smooth(line) if smooth else line, 2.0)
        later = round(1.5 * room)  # samples that are three times `room` further along the road
        if all(dist(a, b) > room for k, a in enumerate(places) for b in places[k + later :]):
            return line


def _branch(random: Random, line: Sequence[curves.Coordinates], room: float) -> list[XY] | None:
    """A straight road away from the middle of another; None where it would come too near it."""
    places = curves.every(line, 2.0)
    k = len(places) // 2
    (x, y), (u, v) = places[k], places[k + 1]
    side = random.choice((-1, 1))
    across = (side * (y - v) / 2, side * (u - x) / 2)
    end = (x + 15 * across[0], y + 15 * across[1])
    far = [place for j, place in enumerate(places) if abs(j - k) > room]
    if any(dist(end, place) < room for place in far):
        return None
    return [(round(x, 1), round(y, 1)), (round(end[0], 1), round(end[1], 1))]


# Search fields.


def search(number: int, random: Random) -> str:
    """A field of 60 x 60 m before the start, with people lying in it and things like them.

    People and things lie 5 m apart or more; the place `middle` is the field's.
    """
    spots = _scattered(random, 60, (5, 65), (-30, 30), 5.0)
    persons = random.randint(3, 7)
    decoys = random.randint(4, 10)
    out = [
        f"world: search_{number}",
        f"description: Generated search field number {number}, with {persons} people.",
        "ground: {color: grass, size: 200 m}",
        "start: {at: [0, 0]}",
        "people:",
    ]
    for k in range(persons):
        x, y = spots.pop()
        pose = f"heading: {random.uniform(-3, 3):.2f}, color: {random.choice(('orange', 'red'))}"
        lying = "true" if random.random() < 0.7 else "false"
        out.append(f"  person_{k + 1}: {{at: [{x:g}, {y:g}], {pose}, lying: {lying}}}")
    out.append("boxes:")
    for k in range(decoys):
        x, y = spots.pop()
        size = [round(random.uniform(0.4, 2.0), 1) for _ in range(3)]
        color = random.choice(_BRIGHT)
        turn = random.uniform(0, 3)
        out.append(
            f"  thing_{k + 1}: {{at: [{x:g}, {y:g}], size: {size}, heading: {turn:.2f},"
            f" color: {color}}}"
        )
    out.append("places: {middle: [35, 0, 0]}")
    return "\n".join(out) + "\n"


# Forests.

FOREST = (6.0, 54.0, -20.0, 20.0)
"""West, east, south and north of the trees, metres."""
TREES_APART = 2.5
"""Least distance between trunks, metres."""


def forest(number: int, random: Random) -> str:
    """60 to 140 trees between the start and the place `goal`, 60 m east of it.

    Trunks stand 2.5 m apart or more and are 24 to 54 cm thick; crowns begin above 2.5 m. So there
    is a way below them everywhere.
    """
    west, east, south, north = FOREST
    count = random.randint(60, 140)
    spots = _scattered(random, count, (west, east), (south, north), TREES_APART)
    out = [
        f"world: forest_{number}",
        f"description: Generated forest number {number}, of {len(spots)} trees.",
        "ground: {color: grass, size: 200 m}",
        "start: {at: [0, 0]}",
        "trees:",
    ]
    for k, (x, y) in enumerate(spots):
        height = random.uniform(5, 9)
        out.append(f"  tree_{k + 1}: {{at: [{x:g}, {y:g}], height: {height:.1f}}}")
    out.append("places: {goal: [60, 0, 1.5]}")
    return "\n".join(out) + "\n"


def _scattered(random: Random, count: int, across: XY, along: XY, apart: float) -> list[XY]:
    """Up to ``count`` places in a rectangle, none nearer to another than ``apart``."""
    spots: list[XY] = []
    for _ in range(20 * count):
        spot = (round(random.uniform(*across), 1), round(random.uniform(*along), 1))
        if len(spots) < count and all(dist(spot, other) >= apart for other in spots):
            spots.append(spot)
    return spots


def _listed(points: Sequence[XY]) -> str:
    return "[" + ", ".join(f"[{x:g}, {y:g}]" for x, y in points) + "]"


FAMILIES: Mapping[str, Callable[[int, Random], str]] = MappingProxyType(
    {
        "roads": roads,
        "narrow_roads": narrow_roads,
        "corner_roads": corner_roads,
        "search": search,
        "forest": forest,
    }
)
