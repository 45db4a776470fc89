"""Fiducial markers: the dictionaries, how many markers each has and how they fill their plate."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

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
