"""Preparation of missions: from a file to a checked graph and the world it flies in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from behaviors import Calls, drone_vocabulary, load_all, trusted
from behaviors.registry import Own
from fsm import Graph, MissionSpec, compile_mission, read_mission, warnings_with_proof
from fsm.faults import Faults
from fsm.host import Vocabulary
from fsm.language.spec import StateSpec
from runner.mission_files import read_mission_files
from runner.missions import Found
from vencejo.errors import Where
from vencejo.files import named_from
from vencejo.nodes import Scalar
from worlds import World, find_world

if TYPE_CHECKING:
    # Most missions are YAML: what reads others is imported when there is one.
    from fsm.scxml import Element

DEFAULT_WORLD = "empty"


@dataclass(frozen=True)
class Prepared:
    """A checked mission with the world it flies in."""

    found: Found
    spec: MissionSpec
    graph: Graph
    world: World
    world_word: str
    """The name or path by which a backend finds that world."""
    files: tuple[Path, ...]
    """The files that the flight depends on, the mission's first."""


def prepare(
    found: Found,
    world: str | None = None,
    *,
    code: bool = True,
    calls: Calls | None = None,
    peers: Iterable[str] | None = None,
) -> Prepared:
    """Read and check a mission; runs the Python files it uses, unless ``code`` is False.

    ``calls`` are those that run them, for whoever limits their time; ``peers`` the vehicles of the
    fleet that it is part of. Raises UserError with every fault that was found.
    """
    faults = Faults()
    spec, document = _read(found, faults)
    word, where = world_word(spec.world, found.path.parent, world)
    place: World | None = None
    with faults.collecting():
        place = find_world(word, where)
    vocabulary = _vocabulary_of(
        spec, found.path, place, faults, code=code, peers=peers, calls=calls
    )
    if document is not None:
        from fsm.scxml import load_document

        graph = load_document(document, spec.name, vocabulary)
        faults.raise_any()
    else:
        graph = compile_mission(spec, vocabulary, faults)
        graph = replace(graph, warnings=warnings_with_proof(graph))
    assert place is not None, "a world that is not there is a fault"
    return _prepared(found, spec, graph, (place, word), _sources(document))


def prepare_member(
    spec: MissionSpec,
    found: Found,
    place: tuple[World, str],
    peers: Iterable[str],
    *,
    code: bool = True,
    calls: Calls | None = None,
) -> Prepared:
    """Check a mission of a fleet that has been read, for the fleet's world and the word for it.

    Raises UserError with every fault that was found.
    """
    faults, (world, _) = Faults(), place
    vocabulary = _vocabulary_of(
        spec, found.path, world, faults, code=code, peers=peers, calls=calls
    )
    graph = compile_mission(spec, vocabulary, faults)
    graph = replace(graph, warnings=warnings_with_proof(graph))
    return _prepared(found, spec, graph, place)


def _prepared(
    found: Found,
    spec: MissionSpec,
    graph: Graph,
    place: tuple[World, str],
    sources: Iterable[Path] = (),
) -> Prepared:
    """A mission with the files that it names. Raises UserError for what is wrong with them."""
    path, (world, word) = found.path, place
    folders = {each.file: _path(each, spec, path).parent for each in spec.closure()}
    named = read_mission_files(graph, folders)
    others = dict.fromkeys((*_others(spec, path), *named.paths, *sources))
    return Prepared(found, spec, replace(graph, files=named.contents), world, word, (path, *others))


def _read(found: Found, faults: Faults) -> tuple[MissionSpec, Element | None]:
    """The mission as written; of a foreign SCXML document no more than its name, and its root."""
    if found.path.suffix != ".scxml":
        return read_mission(found.path, found.shown_as, faults), None
    from fsm.scxml import import_mission, is_mission, read_document

    document = read_document(found.path, found.shown_as)
    if is_mission(document):
        return import_mission(document, found.shown_as, found.path.parent), None
    name = document.get("name") or found.path.stem
    return MissionSpec(name, found.shown_as, StateSpec("", document.where, "compound")), document


def _vocabulary_of(
    spec: MissionSpec,
    path: Path,
    world: World | None,
    faults: Faults,
    *,
    code: bool = True,
    peers: Iterable[str] | None = None,
    calls: Calls | None = None,
) -> Vocabulary:
    """The vocabulary of a mission: that of drones, and the Python files that its graphs use.

    Runs those files; what is wrong with them goes to ``faults``. When they cannot be run, or with
    ``code`` False must not, their behaviours are taken on trust. ``world`` is None when unknown.
    """
    files = [
        (scalar, _path(graph, spec, path).parent)
        for graph in spec.closure()
        for scalar in graph.uses
    ]
    own: Own | None = None
    if code:
        with faults.collecting():
            own = load_all(files, calls)
    if own is None:
        own = trusted(files, faults)
    return drone_vocabulary(own, world.places if world else None, peers, calls)


def _path(graph: MissionSpec, spec: MissionSpec, path: Path) -> Path:
    """The path of a graph's file, from that of its mission: messages name both in the same way."""
    return path.parent / PurePosixPath(graph.file).relative_to(PurePosixPath(spec.file).parent)


def _others(spec: MissionSpec, path: Path) -> Iterator[Path]:
    """The files that a mission includes and uses, each once."""
    found: dict[Path, None] = {}
    for graph in spec.closure():
        file = _path(graph, spec, path)
        found[file] = None
        found.update(dict.fromkeys(file.parent / scalar.text for scalar in graph.uses))
    del found[path]
    yield from found


def _sources(document: Element | None) -> list[Path]:
    """The files that a foreign SCXML document takes values and scripts from."""
    if document is None:
        return []
    from fsm.scxml import sources

    return sources(document)


def world_word(named: Scalar | None, folder: Path, given: str | None) -> tuple[str, Where | None]:
    """The world to fly in, and the place that names it: ``--world``, or a file in ``folder``."""
    if given is not None:
        return given, Where("--world")
    if named is None:
        return DEFAULT_WORLD, None
    return named_from(folder, named.text), named.where
