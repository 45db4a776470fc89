"""From a mission's file to a graph that may fly: what `check` and `run` have in common."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from behaviors import drone_vocabulary, load_uses
from cli.missions import Found
from fsm import Graph, MissionSpec, compile_mission, read_mission
from fsm.scxml import Element, import_mission, is_mission, load_document, read_document
from fsm.spec import StateSpec
from vencejo.errors import Where
from worlds import World, find_world

DEFAULT_WORLD = "empty"


@dataclass(frozen=True)
class Prepared:
    """A checked mission with the world it flies in."""

    found: Found
    spec: MissionSpec
    graph: Graph
    world: World
    world_word: str
    """How a backend finds that world: a name or a path."""
    files: tuple[Path, ...]
    """Everything the flight depends on that a person wrote, the mission first."""


def prepare(found: Found, world: str | None = None) -> Prepared:
    """Read and check a mission; runs the Python files it uses.

    Raises UserError with every fault that was found.
    """
    document = read_document(found.path, found.shown_as) if _is_scxml(found) else None
    spec = _spec(found, document)
    folder = found.path.parent
    word, where = _world_word(spec, folder, world)
    place = find_world(word, where)
    vocabulary = drone_vocabulary(load_uses(spec.uses, folder), place.places)
    if document is not None and not is_mission(document):
        graph = load_document(document, spec.name, vocabulary)
    else:
        graph = compile_mission(spec, vocabulary)
    files = (found.path, *(folder / scalar.text for scalar in spec.uses))
    return Prepared(found, spec, graph, place, word, files)


def _is_scxml(found: Found) -> bool:
    return found.path.suffix == ".scxml"


def _spec(found: Found, document: Element | None) -> MissionSpec:
    """The mission as written; of a foreign document no more than its name."""
    if document is None:
        return read_mission(found.path, found.shown_as)
    if is_mission(document):
        return import_mission(document, found.shown_as)
    name = document.get("name") or found.path.stem
    return MissionSpec(name, found.shown_as, StateSpec("", document.where, "compound"))


def _world_word(spec: MissionSpec, folder: Path, given: str | None) -> tuple[str, Where | None]:
    if given is not None:
        return given, Where("--world")
    if spec.world is None:
        return DEFAULT_WORLD, None
    word = spec.world.text
    if word.endswith((".yaml", ".yml")):
        # A world's file is named from where the mission lies, not from where one happens to be.
        return str(folder / word), spec.world.where
    return word, spec.world.where
