"""Reads a mission with the graphs it includes, from other files or from under its own `graphs`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from fsm.faults import Faults
from fsm.language.reader import spec_of
from fsm.language.spec import MissionSpec
from vencejo.errors import UserError
from vencejo.files import file_inside, nearest_file
from vencejo.nodes import Mapping, Scalar, read_file, read_text

MAX_INCLUDES = 64
"""The most levels of graphs inside graphs."""


def read_mission(
    path: Path, shown_as: str | None = None, faults: Faults | None = None
) -> MissionSpec:
    """Read a mission from its file. Raises UserError with the mistakes of form of all its files.

    With ``faults`` they are added there instead, so that the compiler can add the mistakes of
    meaning; a file that cannot be read at all is raised in any case.
    """
    found = Faults() if faults is None else faults
    spec = _Library(found).mission(path, shown_as or str(path))
    if faults is None:
        found.raise_any()
    return spec


def read_mission_text(
    text: str,
    file: str = "mission.yaml",
    folder: Path | None = None,
    faults: Faults | None = None,
) -> MissionSpec:
    """Read a mission from a text; its includes are in ``folder`` (see :func:`read_mission`)."""
    return mission_of(read_text(text, file), file, Path(file).stem, folder, faults)


def mission_of(
    node: Mapping,
    file: str,
    name: str,
    folder: Path | None = None,
    faults: Faults | None = None,
) -> MissionSpec:
    """Read a mission from YAML nodes (see :func:`read_mission`)."""
    found = Faults() if faults is None else faults
    spec = spec_of(node, file, name, found)
    _Library(found).link(spec, folder, spec.graphs, (spec,))
    if faults is None:
        found.raise_any()
    return spec


class _Library:
    """Reads every file once, and links every graph once."""

    def __init__(self, faults: Faults) -> None:
        self.faults = faults
        self.files: dict[Path, MissionSpec] = {}
        self.linked: set[int] = set()

    def mission(self, path: Path, shown_as: str) -> MissionSpec:
        spec = self.file(path, shown_as)
        self.link(spec, path.parent, spec.graphs, (spec,))
        return spec

    def file(self, path: Path, shown_as: str) -> MissionSpec:
        key = path.resolve()
        if key not in self.files:
            node = read_file(path, shown_as)
            self.files[key] = spec_of(node, shown_as, path.stem, self.faults)
        return self.files[key]

    def link(
        self,
        spec: MissionSpec,
        folder: Path | None,
        graphs: Sequence[MissionSpec],
        trail: tuple[MissionSpec, ...],
    ) -> None:
        """Find the graphs that ``spec`` includes; ``trail`` are those around it, itself last."""
        self.linked.add(id(spec))
        for state in spec.root.walk():
            if state.include is not None and state.include.text not in spec.included:
                with self.faults.collecting():
                    found, place, near = self.find(state.include, spec, folder, graphs)
                    self.refuse(state.include, found, trail)
                    spec.included[state.include.text] = found
                    if id(found) not in self.linked:
                        self.link(found, place, near, (*trail, found))

    def find(
        self, word: Scalar, spec: MissionSpec, folder: Path | None, graphs: Sequence[MissionSpec]
    ) -> tuple[MissionSpec, Path | None, Sequence[MissionSpec]]:
        """The graph of a word, with the folder and the kept graphs that it may include from."""
        named = {graph.name: graph for graph in graphs}
        if word.text in named:
            return named[word.text], folder, graphs
        path = file_inside(folder, word, "what is included") if folder else None
        if folder is None or path is None or not path.is_file():
            is_file = word.text.endswith((".yaml", ".yml"))
            what = "file" if is_file else "graph"
            raise UserError(
                "no-such-file" if is_file else "unknown-graph",
                f"there is no {what} '{word.text}' to include",
                word.where,
                nearest_file(word.text, [*named, *_files(folder)]),
            )
        found = self.file(path, str(PurePosixPath(spec.file).parent / word.text))
        return found, path.parent, found.graphs

    def refuse(self, word: Scalar, found: MissionSpec, trail: tuple[MissionSpec, ...]) -> None:
        """Raises UserError when a graph would be inside itself."""
        if any(found is outer for outer in trail):
            first = next(index for index, outer in enumerate(trail) if outer is found)
            names = [*(graph.name for graph in trail[first:]), found.name]
            raise UserError(
                "include-cycle",
                f"'{found.name}' would be inside itself: {' → '.join(names)}",
                word.where,
                "a graph cannot include itself, nor one that includes it",
            )
        if len(trail) > MAX_INCLUDES:
            message = f"graphs include each other at most {MAX_INCLUDES} deep"
            raise UserError("too-deep", message, word.where)


def _files(folder: Path | None) -> list[str]:
    """The files that may be included from a folder, for a hint."""
    if folder is None:
        return []
    found = (*folder.glob("*.y*ml"), *folder.glob("*/*.y*ml"))
    return [file.relative_to(folder).as_posix() for file in found]
