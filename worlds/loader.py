"""Reads world files. What is wrong in a file is told all at once."""

from __future__ import annotations

import re
from collections.abc import Callable
from hashlib import sha256
from math import inf, isfinite, pi
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

from vencejo.errors import Fault, UserError, Where, nearest
from vencejo.geometry import Point
from vencejo.nodes import Mapping, Node, Scalar, Sequence, kind, read_file
from vencejo.units import ANGLE, LENGTH, RATIO, Dimension, parse_number, read_quantity
from worlds.model import Beacon, Box, Ground, Origin, Start, World
from worlds.things import Color

COLORS: dict[str, Color] = {
    "asphalt": (70, 70, 75),
    "black": (0, 0, 0),
    "blue": (30, 60, 220),
    "brick": (160, 75, 55),
    "concrete": (150, 150, 145),
    "grass": (85, 130, 60),
    "gray": (128, 128, 128),
    "green": (30, 170, 50),
    "magenta": (210, 40, 200),
    "orange": (245, 130, 20),
    "red": (220, 30, 30),
    "sand": (205, 185, 140),
    "white": (255, 255, 255),
    "yellow": (240, 220, 40),
}
"""Colours by name."""

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_DEGREE = pi / 180
_T = TypeVar("_T")


def load_world(path: Path) -> World:
    """The world in a file. Raises UserError with every fault of the file."""
    root = read_file(path)
    reader = _Reader()
    world = reader.world(root, path)
    if reader.faults:
        raise UserError.of(sorted(reader.faults, key=lambda fault: fault.where or root.where))
    return world


class _Reader:
    """Turns nodes into a world and collects the faults; what is faulty reads as a stand-in."""

    def __init__(self) -> None:
        self.faults: list[Fault] = []

    def fault(self, code: str, message: str, where: Where, hint: str | None = None) -> None:
        self.faults.append(Fault(code, message, where, hint))

    def world(self, root: Mapping, path: Path) -> World:
        keys = self.fields(
            root,
            "a world",
            needed=("world",),
            others=(
                "description", "origin", "ground", "start", "battery", "boxes", "beacons", "places",
            ),
        )  # fmt: skip
        boxes = self.named(keys.get("boxes"), "boxes", self.box)
        beacons = self.named(keys.get("beacons"), "beacons", self.beacon)
        places = self.named(keys.get("places"), "places", lambda name, node: self.point(node))
        positions = {beacon.name: beacon.at for _, beacon in beacons}
        for key, point in places:
            if key.text in positions:
                self.fault(
                    "duplicate-name",
                    f"'{key.text}' is a beacon already, and beacons are places",
                    key.where,
                    "rename one of the two",
                )
            positions[key.text] = point
        starts = self.starts(keys.get("start"), root.where)
        world = World(
            name=self.text(keys["world"]) if "world" in keys else "",
            description=self.text(keys["description"]) if "description" in keys else "",
            origin=self.origin(keys.get("origin")),
            ground=self.ground(keys.get("ground")),
            starts=tuple(start for _, start in starts),
            battery=self.number(keys["battery"], RATIO, 0.0, 1.0) if "battery" in keys else 1.0,
            boxes=tuple(box for _, box in boxes),
            beacons=tuple(beacon for _, beacon in beacons),
            places=MappingProxyType(positions),
            source=path,
            sha256=sha256(path.read_bytes()).hexdigest(),
        )
        for where, start in starts:
            box = world.box_near(start.at)
            if box is not None:
                self.fault(
                    "start-in-box",
                    f"a vehicle that starts here stands in the box '{box.name}'",
                    where,
                    f"keep away from it, or start on top of it with z = {box.top:g}",
                )
        return world

    # The parts of a world.

    def origin(self, node: Node | None) -> Origin | None:
        if node is None:
            return None
        keys = self.fields(node, "an origin", needed=("lat", "lon"), others=("alt",))
        return Origin(
            self.degrees(keys["lat"], 90.0) if "lat" in keys else 0.0,
            self.degrees(keys["lon"], 180.0) if "lon" in keys else 0.0,
            self.number(keys["alt"], LENGTH) if "alt" in keys else 0.0,
        )

    def ground(self, node: Node | None) -> Ground:
        keys = self.fields(node, "the ground", others=("color", "size")) if node else {}
        return Ground(
            self.color(keys["color"]) if "color" in keys else COLORS["grass"],
            self.size(keys["size"]) if "size" in keys else 100.0,
        )

    def starts(self, node: Node | None, place: Where) -> list[tuple[Where, Start]]:
        if node is None:
            return [(place, Start(Point(0.0, 0.0, 0.0), 0.0))]
        nodes = node.items if isinstance(node, Sequence) else [node]
        if not nodes:
            self.fault("wrong-type", "an empty list of starts", node.where, "write {at: [0, 0]}")
        return [(each.where, self.start(each)) for each in nodes]

    def start(self, node: Node) -> Start:
        keys = self.fields(node, "a start", needed=("at",), others=("heading",))
        at = self.point(keys["at"], 0.0) if "at" in keys else Point(inf, inf, inf)
        return Start(at, self.heading(keys))

    def box(self, name: str, node: Node) -> Box:
        keys = self.fields(node, "a box", needed=("at", "size"), others=("heading", "color"))
        return Box(
            name,
            self.point(keys["at"], 0.0) if "at" in keys else Point(inf, inf, inf),
            self.box_size(keys["size"]) if "size" in keys else Point(1.0, 1.0, 1.0),
            self.heading(keys),
            self.color(keys["color"]) if "color" in keys else COLORS["gray"],
        )

    def beacon(self, name: str, node: Node) -> Beacon:
        keys = self.fields(node, "a beacon", needed=("at",), others=("color",))
        return Beacon(
            name,
            self.point(keys["at"]) if "at" in keys else Point(0.0, 0.0, 0.0),
            self.color(keys["color"]) if "color" in keys else COLORS["red"],
        )

    # Values.

    def text(self, node: Node) -> str:
        if isinstance(node, Scalar) and not node.null:
            return node.text
        self.fault("wrong-type", f"a text is needed here, not {kind(node)}", node.where)
        return ""

    def number(
        self, node: Node, dimension: Dimension, low: float = -inf, high: float = inf
    ) -> float:
        if not isinstance(node, Scalar):
            self.fault("wrong-type", f"{dimension} is needed here, not {kind(node)}", node.where)
            return 0.0
        try:
            value = read_quantity(node.text, dimension, node.where)
        except UserError as error:
            self.faults.extend(error.faults)
            return 0.0
        if not (isfinite(value) and low <= value <= high):
            span = f"{low:g} to {high:g}" if isfinite(high) else "a finite number"
            self.fault("out-of-range", f"{dimension} of {node.text}; it must be {span}", node.where)
            return 0.0
        return value

    def degrees(self, node: Node, most: float) -> float:
        """A latitude or longitude: a bare number is in degrees."""
        bare = parse_number(node.text) if isinstance(node, Scalar) else None
        if bare is None:
            return self.number(node, ANGLE, -most * _DEGREE, most * _DEGREE) / _DEGREE
        if not -most <= bare <= most:
            self.fault(
                "out-of-range", f"{bare:g} degrees; it must be {-most:g} to {most:g}", node.where
            )
        return float(bare)

    def heading(self, keys: dict[str, Node]) -> float:
        return self.number(keys["heading"], ANGLE) if "heading" in keys else 0.0

    def size(self, node: Node) -> float:
        before = len(self.faults)
        value = self.number(node, LENGTH)
        if value <= 0 and len(self.faults) == before:
            self.fault("bad-size", f"a size of {value:g} m; it must be above 0", node.where)
        return value

    def box_size(self, node: Node) -> Point:
        if not isinstance(node, Sequence) or len(node.items) != 3:
            self.fault("wrong-type", "a box's size is [x, y, z] in metres", node.where)
            return Point(1.0, 1.0, 1.0)
        return Point(*map(self.size, node.items))

    def point(self, node: Node, ground: float | None = None) -> Point:
        """``[x, y, z]``, or ``[x, y]`` where the height may be left out."""
        counts = (3,) if ground is None else (2, 3)
        if not isinstance(node, Sequence) or len(node.items) not in counts:
            shape = "[x, y, z]" if ground is None else "[x, y] or [x, y, z]"
            self.fault(
                "wrong-type", f"a place is {shape} in metres, not {_shown(node)}", node.where
            )
            return Point(inf, inf, inf)
        x, y, *z = (self.number(item, LENGTH) for item in node.items)
        return Point(x, y, z[0] if z else ground or 0.0)

    def color(self, node: Node) -> Color:
        if isinstance(node, Scalar):
            if node.text not in COLORS:
                hint = nearest(node.text, COLORS)
                self.fault("unknown-color", f"no colour is called '{node.text}'", node.where, hint)
            return COLORS.get(node.text, (0, 0, 0))
        items = node.items if isinstance(node, Sequence) else []
        parts = [parse_number(item.text) for item in items if isinstance(item, Scalar)]
        values = [part for part in parts if isinstance(part, int) and 0 <= part <= 255]
        if len(values) != 3 or len(items) != 3:
            self.fault(
                "wrong-type", "a colour is a name, or [red, green, blue] from 0 to 255", node.where
            )
            return (0, 0, 0)
        return (values[0], values[1], values[2])

    # Maps.

    def fields(
        self, node: Node, what: str, needed: tuple[str, ...] = (), others: tuple[str, ...] = ()
    ) -> dict[str, Node]:
        """The values of a map of known keys."""
        if not isinstance(node, Mapping):
            self.fault("wrong-type", f"{what} is a map, not {kind(node)}", node.where)
            return {}
        known = {}
        for key, value in node:
            if key.text in needed or key.text in others:
                known[key.text] = value
            else:
                hint = nearest(key.text, (*needed, *others))
                self.fault("unknown-key", f"{what} has no '{key.text}'", key.where, hint)
        for name in needed:
            if name not in known:
                self.fault("missing-key", f"{what} needs '{name}'", node.where)
        return known

    def named(
        self, node: Node | None, what: str, read: Callable[[str, Node], _T]
    ) -> list[tuple[Scalar, _T]]:
        """The entries of a map of names."""
        if node is None:
            return []
        if not isinstance(node, Mapping):
            self.fault("wrong-type", f"'{what}' is a map of names, not {kind(node)}", node.where)
            return []
        for key, _ in node:
            if not _NAME.fullmatch(key.text):
                self.fault(
                    "bad-name",
                    f"'{key.text}' is no name",
                    key.where,
                    "small letters, digits and _, a letter first",
                )
        return [(key, read(key.text, value)) for key, value in node]


def _shown(node: Node) -> str:
    return f"a list of {len(node.items)}" if isinstance(node, Sequence) else kind(node)
