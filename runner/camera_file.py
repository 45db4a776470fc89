"""Cameras from a file, for `--cameras`: every property, with units."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hal.camera_settings import CAMERA
from vencejo.errors import UserError
from vencejo.nodes import Scalar, YamlNode, read_file
from worlds.values import Value, names

Cameras = Mapping[str, Mapping[str, Any] | None]
"""Name of a camera → settings that differ from its defaults; None to remove it."""


def _camera(node: YamlNode) -> dict[str, Any] | None:
    if isinstance(node, Scalar) and node.text == "false":
        return None
    return CAMERA.read(node)


def read_camera_file(path: Path) -> dict[str, Mapping[str, Any] | None]:
    """The cameras of a YAML file: a map of names; ``false`` for no such camera.

    Lengths are metres, angles radians where no unit is given. Raises UserError with every fault.
    """
    found = names("a camera file", Value(_camera, CAMERA.schema)).read(read_file(path))
    if found.faults:
        raise UserError.of(found.faults)
    return {name.text: camera for name, camera in found.entries}


def joined(first: Cameras, second: Cameras) -> dict[str, Mapping[str, Any] | None]:
    """The cameras of both, property by property; where both set one, the second counts."""
    found = dict(first)
    for name, camera in second.items():
        found[name] = None if camera is None else {**(first.get(name) or {}), **camera}
    return found
