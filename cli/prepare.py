"""From a mission's file to a graph that may fly: what `check` and `run` have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from behaviors import drone_vocabulary, load_uses, trusted_behaviors
from cli.missions import Found
from fsm import Behavior, Graph, MissionSpec, compile_mission, prove, read_mission
from fsm.faults import Faults
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


def prepare(found: Found, world: str | None = None, *, code: bool = True) -> Prepared:
    """Read and check a mission; runs the Python files it uses, unless ``code`` is False.

    Raises UserError with every fault that was found.
    """
    faults = Faults()
    spec = read_mission(found.path, found.shown_as, faults)
    folder = found.path.parent
    word, where = _world_word(spec, folder, world)
    place: World | None = None
    own: Mapping[str, Behavior] | None = None
    with faults.collecting():
        place = find_world(word, where)
    if code:
        with faults.collecting():
            own = load_uses(spec.uses, folder)
    if own is None:
        own = trusted_behaviors(spec.uses, folder, faults)
    graph = compile_mission(spec, drone_vocabulary(own, place.places if place else None), faults)
    assert place is not None, "a world that is not there is a fault"
    graph.warnings += tuple(prove(graph))
    files = (found.path, *(folder / scalar.text for scalar in spec.uses))
    return Prepared(found, spec, graph, place, word, files)


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
