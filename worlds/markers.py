"""Fiducial markers and boards: their dictionaries, their sizes and their keys in world files."""

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

_LARGEST_INSIDE = 0.4
"""Largest side of the plate of a marker inside another one over the side of that one's black
square: more would hide too many of its bits."""

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
"""OpenCV's name without DICT_ → the number of ids, from 0 on, and the modules along a side of the
black square (its bits and the black border)."""


def plate_side(dictionary: str, size: float) -> float:
    """The side of the plate that shows a marker, metres; ``size`` is that of its black square.

    The white border is one module wide.
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
    """The marker of the values of FIDUCIAL.

    Raises Misfit (``no-such-marker``, ``marker-too-large``).
    """
    number, dictionary = keys["id"], keys["dictionary"]
    most = DICTIONARIES[dictionary][0] - 1
    if number > most:
        raise Misfit(
            "no-such-marker", f"{dictionary} has the markers 0 to {most}, not {number}", "id"
        )
    if keys.get("inside") is None:
        return Fiducial(dictionary, number)
    inside, size = keys["inside"]
    side = plate_side(inside.dictionary, size)
    if side > _LARGEST_INSIDE * keys["size"]:
        raise Misfit(
            "marker-too-large",
            f"the marker inside and its white border need {side:.2f} m, which hides too much of "
            "the outer one",
            "inside",
            f"{100 * _LARGEST_INSIDE:.0f} % of the outer one's size at most",
        )
    return Fiducial(dictionary, number, inside, side / plate_side(dictionary, keys["size"]))


_PLAIN: Mapping[str, Field] = {
    "id": Field(count(0)),
    "dictionary": Field(DICTIONARY, "4X4_50"),
    "size": Field(SIZE),
}


def _sized(**keys: Any) -> tuple[Fiducial, float]:
    return _fiducial(keys), keys["size"]


FIDUCIAL: Mapping[str, Field] = {
    **_PLAIN,
    "inside": Field(record("a marker", _PLAIN, _sized), None),
}
MARKER_ON_TOP = record("a marker", FIDUCIAL, _sized)


def _posture(keys: Mapping[str, Any]) -> Quaternion:
    """The attitude of a marker or board: it lies flat, unless it faces a direction.

    Raises Misfit (``lies-flat``).
    """
    if keys["faces"] is not None:
        return figures.standing(keys["faces"], keys["lean"], keys["turn"])
    for key in ("lean", "turn"):
        if keys[key]:
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


def marker_parts(**keys: Any) -> tuple[Part, ...]:
    """A marker, from the values of FIDUCIAL and POSTURE. Raises Misfit."""
    fiducial = _fiducial(keys)
    side = plate_side(fiducial.dictionary, keys["size"])
    return (figures.plate(side, side, _posture(keys), fiducial),)


def board_parts(
    columns: int, rows: int, square: float, marker: float, dictionary: str, **posture: Any
) -> tuple[Part, ...]:
    """A ChArUco board, its posture from the values of POSTURE. Raises Misfit.

    ``square`` and ``marker`` are the sides of its squares and of the markers in them, metres.
    """
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
    attitude = _posture(posture)
    return (figures.plate(columns * square, rows * square, attitude, texture),)
