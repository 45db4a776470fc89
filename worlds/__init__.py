"""Worlds to fly in: what they consist of, how they are read and where the shipped ones are."""

from worlds.catalog import find_world, world_families, world_names
from worlds.loader import load_world
from worlds.motion import pose_at
from worlds.outlines import Outline, outlines_of
from worlds.things import Color, Thing
from worlds.world import Ground, Light, Origin, Road, Start, World

__all__ = [
    "Color",
    "Ground",
    "Light",
    "Origin",
    "Outline",
    "Road",
    "Start",
    "Thing",
    "World",
    "find_world",
    "load_world",
    "outlines_of",
    "pose_at",
    "world_families",
    "world_names",
]
