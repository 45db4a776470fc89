"""Colours by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from worlds.things import Color

COLORS: Mapping[str, Color] = MappingProxyType(
    {
        "asphalt": (70, 70, 75),
        "black": (0, 0, 0),
        "blue": (30, 60, 220),
        "brick": (160, 75, 55),
        "brown": (115, 80, 50),
        "concrete": (150, 150, 145),
        "cyan": (40, 190, 210),
        "grass": (85, 130, 60),
        "gray": (128, 128, 128),
        "green": (30, 170, 50),
        "leaves": (50, 95, 45),
        "magenta": (210, 40, 200),
        "orange": (245, 130, 20),
        "purple": (120, 50, 170),
        "red": (220, 30, 30),
        "sand": (205, 185, 140),
        "silver": (190, 195, 200),
        "skin": (225, 180, 150),
        "white": (255, 255, 255),
        "yellow": (240, 220, 40),
    }
)
