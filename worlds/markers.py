"""Fiducial markers: their dictionaries, how they fill their plates, and how they are written."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from vencejo.errors import UserError, nearest
from vencejo.geometry import Quaternion
from vencejo.nodes import YamlNode
from worlds import figures
from worlds.things import UPRIGHT, Charuco, Fiducial, Part
from worlds.values import ANGLE_VALUE, SIZE, TEXT, Field, Misfit, Value, count, record

_SQUARES = {"4X4": 6, "5X5": 7, "6X6": 8, "7X7": 9}

DICTIONARIES: Mapping[str, tuple[int, int]] = MappingProxyType(
    {
        **{
            f"{bits}_{count}": (count, modules)
            for bits, modules in _SQUARES.items()
            for count in (50, 100, 250, 1000)
        },
        "ARUCO_ORIGINAL": (1024, 7),
        "ARUCO_MIP_36h12": (250, 8),
        "APRILTAG_16h5": (30, 6),
        "APRILTAG_25h9": (35, 7),
        "APRILTAG_36h10": (2320, 8),
        "APRILTAG_36h11": (587, 8),
    }
)
"""OpenCV's names without DICT_: how many ids there are, from 0, and the modules along a side of the
black square (its bits and the black border)."""


def plate_side(dictionary: str, size: float) -> float:
    """Side of the plate that shows a marker whose black square has the side ``size``, metres.

    The white border is one module wide on each side.
    """
    _, modules = DICTIONARIES[dictionary]
    return size * (modules + 2) / modules


def _dictionary(node: YamlNode) -> str:
    text = TEXT.read(node).removeprefix("DICT_")
    if text not in DICTIONARIES:
        hint = nearest(text, DICTIONARIES)
        raise UserError(
            "unknown-dictionary", f"no marker dictionary is called '{text}'", node.where, hint
        )
    return text


DICTIONARY = Value(
    _dictionary, {"enum": [p + name for name in DICTIONARIES for p in ("", "DICT_")]}
)


def _fiducial(keys: Mapping[str, Any]) -> Fiducial:
    number, dictionary = keys["id"], keys["dictionary"]
    most = DICTIONARIES[dictionary][0] - 1
    if number > most:
        raise Misfit(
            "no-such-marker", f"{dictionary} has the markers 0 to {most}, not {number}", "id"
        )
    return Fiducial(dictionary, number)


FIDUCIAL: Mapping[str, Field] = {
    "id": Field(count(0)),
    "dictionary": Field(DICTIONARY, "4X4_50"),
    "size": Field(SIZE),
}
MARKER_ON_TOP = record("a marker", FIDUCIAL, lambda **keys: (_fiducial(keys), keys["size"]))


def _posture(faces: float | None, lean: float, turn: float) -> Quaternion:
    """Of a marker or board: flat on its back, unless it faces a direction."""
    if faces is not None:
        return figures.standing(faces, lean, turn)
    for key, value in (("lean", lean), ("turn", turn)):
        if value:
            raise Misfit(
                "lies-flat",
                f"'{key}' is for what stands, and this lies flat",
                key,
                "write where it `faces`; what lies flat is turned by `heading`",
            )
    return UPRIGHT


POSTURE: Mapping[str, Field] = {
    "faces": Field(ANGLE_VALUE, None),
    "lean": Field(ANGLE_VALUE, 0.0),
    "turn": Field(ANGLE_VALUE, 0.0),
}


def marker_parts(faces: float | None, lean: float, turn: float, **keys: Any) -> tuple[Part, ...]:
    fiducial = _fiducial(keys)
    side = plate_side(fiducial.dictionary, keys["size"])
    return (figures.plate(side, side, _posture(faces, lean, turn), fiducial),)


def board_parts(
    columns: int,
    rows: int,
    square: float,
    marker: float,
    dictionary: str,
    faces: float | None,
    lean: float,
    turn: float,
) -> tuple[Part, ...]:
    if marker >= square:
        raise Misfit("bad-size", "a board's markers are smaller than its squares", "marker")
    needed, most = columns * rows // 2, DICTIONARIES[dictionary][0]
    if needed > most:
        raise Misfit(
            "no-such-marker",
            f"a board of {columns} x {rows} needs {needed} markers, and {dictionary} has {most}",
            "dictionary",
        )
    texture = Charuco(dictionary, columns, rows, marker / square)
    posture = _posture(faces, lean, turn)
    return (figures.plate(columns * square, rows * square, posture, texture),)
