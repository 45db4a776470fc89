"""Worlds to fly in: what they consist of, how they are read and where the shipped ones are."""

from worlds.catalog import find_world, world_names
from worlds.loader import load_world
from worlds.model import Beacon, Box, Ground, Light, Origin, Start, World
from worlds.things import Color

__all__ = [
    "Beacon",
    "Box",
    "Color",
    "Ground",
    "Light",
    "Origin",
    "Start",
    "World",
    "find_world",
    "load_world",
    "world_names",
]
