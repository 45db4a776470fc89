"""Cameras from a file, for `--cameras`: every property, with units."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vencejo.errors import UserError
from vencejo.nodes import Scalar, YamlNode, read_file
from vencejo.units import FREQUENCY, RATIO, TIME
from worlds.values import ANGLE_VALUE, PLACE, Field, Value, array, count, names, quantity, record

Cameras = Mapping[str, Mapping[str, Any] | None]
"""Name of a camera → settings that differ from its defaults; None to remove it."""
_DISTORTION = array("a distortion is [k1, k2, p1, p2, k3]", quantity(RATIO), 4, 5)


def _given(**keys: Any) -> dict[str, Any]:
    return {key: value for key, value in keys.items() if value is not None}


_CAMERA = record(
    "a camera",
    {
        "at": Field(PLACE, None),
        "pan": Field(ANGLE_VALUE, None),
        "tilt": Field(ANGLE_VALUE, None),
        "roll": Field(ANGLE_VALUE, None),
        "width": Field(count(1), None),
        "height": Field(count(1), None),
        "rate": Field(quantity(FREQUENCY), None),
        "view": Field(ANGLE_VALUE, None),
        "distortion": Field(_DISTORTION, None),
        "exposure": Field(quantity(TIME), None),
        "noise": Field(quantity(RATIO), None),
    },
    _given,
)


def _camera(node: YamlNode) -> dict[str, Any] | None:
    if isinstance(node, Scalar) and node.text == "false":
        return None
    return _CAMERA.read(node)


def read_camera_file(path: Path) -> dict[str, Mapping[str, Any] | None]:
    """The cameras of a YAML file: a map of names; ``false`` for no such camera.

    Lengths are metres, angles radians where no unit is given. Raises UserError with every fault.
    """
    found = names("a camera file", Value(_camera, _CAMERA.schema)).read(read_file(path))
    if found.faults:
        raise UserError.of(found.faults)
    return {name.text: camera for name, camera in found.entries}


def joined(first: Cameras, second: Cameras) -> dict[str, Mapping[str, Any] | None]:
    """The cameras of both, property by property; where both set one, the second counts."""
    found = dict(first)
    for name, camera in second.items():
        found[name] = None if camera is None else {**(first.get(name) or {}), **camera}
    return found
