"""The kinds of things that a world file can hold: their keys, and the parts made of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vencejo.errors import UserError
from vencejo.geometry import Point
from vencejo.nodes import YamlNode
from worlds import curves, figures
from worlds.assets import IMAGE, file_of
from worlds.colors import COLORS
from worlds.markers import (
    DICTIONARY,
    FIDUCIAL,
    MARKER_ON_TOP,
    POSTURE,
    board_parts,
    marker_parts,
    plate_side,
)
from worlds.placement import ThingDraft, placed
from worlds.roundel import roundel_parts
from worlds.things import UPRIGHT, Color, Fiducial, Image, Mesh, Part
from worlds.values import (
    COLOR,
    FACTOR,
    FLAG,
    FLAT_SPOT,
    PLACE,
    SIZE,
    Field,
    Misfit,
    Spot,
    Value,
    array,
    count,
    record,
)


def _color(name: str) -> Field:
    return Field(COLOR, COLORS[name])


def _box(
    size: tuple[float, ...],
    color: Color,
    texture: Image | None,
    marker: tuple[Fiducial, float] | None,
) -> tuple[Part, ...]:
    cuboid = figures.box(Point(*size), color, texture)
    if marker is None:
        return cuboid
    fiducial, side = marker[0], plate_side(marker[0].dictionary, marker[1])
    if side > min(size[:2]):
        raise Misfit(
            "marker-too-large",
            f"the marker and its white border need {side:.2f} m, more than the box has on top",
            "marker",
        )
    return (*cuboid, figures.lying_marker(fiducial, side, side, size[2]))


def _wall(through: tuple[tuple[float, float], ...], **keys: Any) -> ThingDraft:
    if len(curves.without_repeats(through)) < len(through):
        raise Misfit("bad-path", "a point stands twice in a row in this wall", "through")
    x, y = through[0]
    own = [(u - x, v - y) for u, v in through]
    return ThingDraft("wall", figures.wall(own, **keys), True, Spot(x, y), 0.0, None)


def _mesh(file: Mesh, scale: float, color: Color) -> tuple[Part, ...]:
    shape = Mesh(file.vertices * scale, file.faces)
    return (Part(shape, Point(0.0, 0.0, 0.0), UPRIGHT, color),)


def _read_mesh(node: YamlNode) -> Mesh:
    from worlds.mesh_files import load_mesh  # late: it needs numpy

    path = file_of(node)
    try:
        return load_mesh(path)
    except ValueError as error:
        raise UserError("bad-mesh", f"'{path}' is no mesh: {error}", node.where) from None


def _read_model(node: YamlNode) -> tuple[Part, ...]:
    from worlds.model_files import load_model  # late: it needs numpy

    path = file_of(node)
    try:
        return load_model(path)
    except ValueError as error:
        raise UserError("bad-model", f"'{path}' cannot be used: {error}", node.where) from None


WALL = record(
    "a wall",
    {
        "through": Field(array("a wall is a list of two places or more", FLAT_SPOT, 2)),
        "height": Field(SIZE, 2.0),
        "thickness": Field(SIZE, 0.2),
        "color": _color("concrete"),
    },
    _wall,
)
_SIZE3 = array("a size is [x, y, z] in metres", SIZE, 3, 3)
_SIZE2 = array("this size is [width, height] in metres", SIZE, 2, 2)

KINDS: Mapping[str, Value[ThingDraft]] = {
    "boxes": placed(
        "box",
        {
            "size": Field(_SIZE3),
            "color": _color("gray"),
            "texture": Field(IMAGE, None),
            "marker": Field(MARKER_ON_TOP, None),
        },
        _box,
        may_charge=True,
    ),
    "cylinders": placed(
        "cylinder",
        {"radius": Field(SIZE), "height": Field(SIZE), "color": _color("gray")},
        figures.cylinder,
        may_charge=True,
    ),
    "spheres": placed("sphere", {"radius": Field(SIZE), "color": _color("gray")}, figures.sphere),
    "walls": WALL,
    "houses": placed(
        "house",
        {
            "size": Field(_SIZE3, (8.0, 10.0, 4.0)),
            "color": _color("sand"),
            "roof": _color("brick"),
        },
        lambda size, color, roof: figures.house(Point(*size), color, roof),
    ),
    "cars": placed("car", {"color": _color("red")}, figures.car),
    "people": placed(
        "person", {"color": _color("orange"), "lying": Field(FLAG, False)}, figures.person
    ),
    "trees": placed("tree", {"height": Field(SIZE, 5.0), "color": _color("leaves")}, figures.tree),
    "gates": placed(
        "gate",
        {"size": Field(_SIZE2, (2.0, 2.5)), "color": _color("orange")},
        lambda size, color: figures.gate(size[0], size[1], color),
    ),
    "signs": placed(
        "sign",
        {
            "size": Field(_SIZE2, (0.8, 0.6)),
            "top": Field(SIZE, 2.2),
            "color": _color("blue"),
            "texture": Field(IMAGE, None),
        },
        lambda size, **keys: figures.sign(size[0], size[1], **keys),
    ),
    "markers": placed("marker", {**FIDUCIAL, **POSTURE}, marker_parts),
    "roundels": placed("roundel", {"size": Field(SIZE)}, roundel_parts),
    "boards": placed(
        "board",
        {
            "columns": Field(count(2)),
            "rows": Field(count(2)),
            "square": Field(SIZE),
            "marker": Field(SIZE),
            "dictionary": Field(DICTIONARY, "4X4_50"),
            **POSTURE,
        },
        board_parts,
    ),
    "meshes": placed(
        "mesh",
        {
            "file": Field(Value(_read_mesh, {"type": "string"})),
            "scale": Field(FACTOR, 1.0),
            "color": _color("gray"),
        },
        _mesh,
    ),
    "models": placed(
        "model",
        {"file": Field(Value(_read_model, {"type": "string"}))},
        lambda file: file,
    ),
}
"""The things that stand under each key of a world file; beacons and roads are apart."""


def _beacon(at: tuple[float, ...], radius: float, color: Color) -> ThingDraft:
    return ThingDraft("beacon", figures.beacon(radius, color), False, Spot(*at), 0.0, None)


BEACON = record(
    "a beacon",
    {"at": Field(PLACE), "radius": Field(SIZE, 0.15), "color": _color("red")},
    _beacon,
)
