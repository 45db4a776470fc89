"""The catalogue of worlds: shipped ones by name, generated ones by number, others by path."""

from __future__ import annotations

import re
from pathlib import Path

from vencejo.errors import UserError, Where, nearest
from worlds.generators import FAMILIES, generate
from worlds.loader import load_world, read_world
from worlds.world import World

_FOLDER = Path(__file__).parent / "files"


def world_names() -> list[str]:
    """The names of the shipped worlds."""
    return sorted(path.stem for path in _FOLDER.glob("*.yaml"))


def world_families() -> dict[str, str]:
    """The families of generated worlds by name, with a sentence about each."""
    return {name: (family.__doc__ or "").partition("\n")[0] for name, family in FAMILIES.items()}


def find_world(word: str, where: Where | None = None) -> World:
    """Find a world: a shipped one by name, a generated one (``roads:17``), or a file by its path.

    ``where`` is the place in a mission file that names the world. Raises UserError
    (``unknown-world``, and what :func:`worlds.loader.load_world` raises).
    """
    names = world_names()
    if word in names:
        return load_world(_FOLDER / f"{word}.yaml")
    if word.endswith((".yaml", ".yml")) or "/" in word:
        return load_world(Path(word))
    family, colon, number = word.partition(":")
    if family in FAMILIES:
        if not re.fullmatch(r"[0-9]{1,9}", number):
            raise UserError(
                "unknown-world",
                f"'{word}' does not say which of the generated worlds",
                where,
                f"give its number: {family}:17",
            )
        return read_world(generate(family, int(number)), f"{family}:{int(number)}")
    families = [f"{name}:{number}" for name in FAMILIES] if colon else [*FAMILIES]
    raise UserError(
        "unknown-world",
        f"no world is called '{word}'",
        where,
        nearest(word, [*names, *families], "a file is named by its path: worlds/mine.yaml"),
    )
