"""The files that the parameters of a mission's behaviours name, read before the flight."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any

from behaviors.path_file import read_path_file
from fsm import Graph
from fsm.chart.graph import Node
from fsm.expressions.compiled import Compiled
from fsm.faults import Faults
from fsm.values.types import Text
from vencejo.errors import UserError
from vencejo.files import file_inside, nearest_file
from vencejo.nodes import Scalar


@dataclass(frozen=True)
class MissionFiles:
    """Files by the names that a mission has for them."""

    paths: tuple[Path, ...]
    contents: Mapping[str, Any]


def read_mission_files(graph: Graph, folders: Mapping[str, Path]) -> MissionFiles:
    """Read the files that a graph names; ``folders`` are those of the graphs' files, by the names
    that these have in errors.

    Raises UserError with all faults: ``computed-file``, ``no-such-file``, ``not-a-file``,
    ``outside-folder``, ``same-name`` and those of :func:`behaviors.path_file.read_path_file`.
    """
    paths: dict[str, Path] = {}
    contents: dict[str, Any] = {}
    faults = Faults()
    for value in _names(graph):
        with faults.collecting():
            word = _word(value)
            folder = folders[word.where.file]
            path = _found(word, folder)
            if paths.setdefault(word.text, folder / word.text).resolve() != path:
                message = f"another graph of this mission has another file '{word.text}'"
                raise UserError("same-name", message, word.where, "give one of them another name")
            if word.text not in contents:
                shown_as = str(PurePosixPath(word.where.file).parent / word.text)
                contents[word.text] = read_path_file(path, shown_as)
    faults.raise_any()
    return MissionFiles(tuple(paths.values()), MappingProxyType(contents))


def _names(graph: Graph) -> Iterator[Compiled]:
    """The values that name files, each place of a file once."""
    found = {value.where: value for node in graph.nodes for value in _names_in(node)}
    yield from found.values()


def _names_in(node: Node) -> Iterator[Compiled]:
    if node.invocation is None:
        return
    for name, value in node.invocation.with_.items():
        parameter = node.invocation.behavior.parameters.get(name)
        if parameter and isinstance(parameter.type, Text) and parameter.type.file:
            yield value


def _word(value: Compiled) -> Scalar:
    """The name of a file. Raises UserError where only the flight knows it."""
    if not value.constant:
        message = f"'{value.source}' is computed, and files are read before the flight"
        raise UserError("computed-file", message, value.where, "write the name of a file")
    return Scalar(value.value(), value.where)


def _found(word: Scalar, folder: Path) -> Path:
    """The resolved path of a file. Raises UserError where it may not be read or is not there."""
    path = file_inside(folder, word, "what a mission names")
    if path.is_dir():
        message = f"'{word.text}' is a folder"
        raise UserError("not-a-file", message, word.where, "name a .csv file inside it")
    if not path.exists():
        files = [str(file.relative_to(folder)) for file in folder.glob("*.csv")]
        hint = nearest_file(word.text, files, None if files else "no CSV file lies there")
        raise UserError("no-such-file", f"there is no file '{word.text}'", word.where, hint)
    return path
