"""The settings of a camera as YAML files give them, with units."""

from __future__ import annotations

from typing import Any

from vencejo.units import FREQUENCY, RATIO, TIME
from worlds.values import ANGLE_VALUE, PLACE, Field, array, count, quantity, record

_DISTORTION = array("a distortion is [k1, k2, p1, p2, k3]", quantity(RATIO), 4, 5)


def _given(**keys: Any) -> dict[str, Any]:
    return {key: value for key, value in keys.items() if value is not None}


CAMERA = record(
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
"""A map of the settings that are given; lengths in metres, angles in radians."""
