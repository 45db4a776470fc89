"""The environment of a world, as world files write it: origin, ground, light and starts."""

from __future__ import annotations

from math import cos, pi, sin

from vencejo.errors import UserError, Where
from vencejo.nodes import Sequence, YamlNode
from vencejo.units import ANGLE, LENGTH
from worlds.assets import IMAGE
from worlds.colors import COLORS
from worlds.terrain import TERRAIN
from worlds.things import Color, Image, Terrain
from worlds.values import (
    ANGLE_VALUE,
    COLOR,
    SHARE,
    SIZE,
    SPOT,
    Field,
    Spot,
    Value,
    degrees,
    each,
    quantity,
    record,
)
from worlds.world import Ground, Light, Origin

ORIGIN = record(
    "an origin",
    {
        "lat": Field(degrees(90.0)),
        "lon": Field(degrees(180.0)),
        "alt": Field(quantity(LENGTH), 0.0),
    },
    Origin,
)


def _ground(
    color: Color, size: float, texture: Image | None, tile: float, terrain: Terrain | None
) -> Ground:
    return Ground(color, size, texture.path if texture else None, tile, (), terrain)


GROUND = Field(
    record(
        "the ground",
        {
            "color": Field(COLOR, COLORS["grass"]),
            "size": Field(SIZE, 100.0),
            "texture": Field(IMAGE, None),
            "tile": Field(SIZE, 10.0),
            "terrain": Field(TERRAIN, None),
        },
        _ground,
    ),
    Ground(COLORS["grass"], 100.0),
)


def _light(heading: float, height: float, ambient: float, sky: Color) -> Light:
    """The light of a sun at a heading and a height above the horizon, radians."""
    level = cos(height)
    return Light((level * cos(heading), level * sin(heading), sin(height)), ambient, sky)


_DAY = Light()
LIGHT = Field(
    record(
        "the light",
        {
            "heading": Field(ANGLE_VALUE, -pi / 3),
            "height": Field(quantity(ANGLE, 0.0, pi / 2), pi / 3),
            "ambient": Field(SHARE, _DAY.ambient),
            "sky": Field(COLOR, _DAY.sky),
        },
        _light,
    ),
    _DAY,
)

_START_PLACE: dict[str, Field] = {"at": Field(SPOT), "heading": Field(ANGLE_VALUE, 0.0)}
START: Value[tuple[Spot, float]] = record(
    "a start", _START_PLACE, lambda at, heading: (at, heading)
)
"""The start that a fleet gives to a vehicle: its spot and its heading."""
_WORLD_START: Value[tuple[Spot, float, Color | None]] = record(
    "a start",
    _START_PLACE | {"color": Field(COLOR, None)},
    lambda at, heading, color: (at, heading, color),
)


def _starts(node: YamlNode) -> list[tuple[Where, Spot, float, Color | None]]:
    if isinstance(node, Sequence) and not node.items:
        raise UserError("wrong-type", "an empty list of starts", node.where, "write {at: [0, 0]}")
    items = node.items if isinstance(node, Sequence) else [node]
    return each(items, lambda item: (item.where, *_WORLD_START.read(item)))


STARTS = Value(
    _starts,
    {
        "anyOf": [
            _WORLD_START.schema,
            {"type": "array", "items": _WORLD_START.schema, "minItems": 1},
        ]
    },
)
"""One start or a list of them; each comes with its place in the file, its spot, its heading and the
colour of the vehicle that starts there.
"""
