"""Names of the behaviours in Python files beside a mission, found without running the files."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from pathlib import Path

from behaviors.behavior import snake_case
from behaviors.detector import OwnDetector
from behaviors.registry import Own, path_of
from fsm.host import BehaviorInfo, Function
from vencejo.errors import Fault, UserError
from vencejo.nodes import MAX_BYTES, Scalar


def trusted(files: Iterable[tuple[Scalar, Path]], faults: list[Fault]) -> Own:
    """The behaviours and functions that Python files seem to define, found in their syntax trees.

    ``files``: each name with the folder that it is relative to. Nothing is run, so parameters and
    outcomes are unknown and a mission's use of them is not checked. Files that may not be used are
    reported in ``faults``; a file that is no Python defines nothing.
    """
    found: Own = {}
    for scalar, folder in files:
        try:
            path = path_of(scalar, folder)
        except UserError as error:
            faults.extend(error.faults)
            continue
        found.update((info.name, info) for info in _contents(path))
    return found


def _contents(path: Path) -> Iterator[BehaviorInfo | Function | OwnDetector]:
    """Every public class with a base as a behaviour, every decorated function as one to call."""
    try:
        if path.stat().st_size > MAX_BYTES:
            return
        tree = ast.parse(path.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.bases and not node.name.startswith("_"):
            name = next(_given_names(node), snake_case(node.name))
            yield BehaviorInfo(name, on_trust=True)
        elif isinstance(node, ast.FunctionDef) and node.decorator_list:
            if "detector" in {_name_of(each) for each in node.decorator_list}:
                yield OwnDetector(node.name)
            else:
                yield Function(node.name, on_trust=True)


def _name_of(decorator: ast.expr) -> str:
    """``detector`` of ``@detector`` and of ``@behaviors.detector``."""
    match decorator:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name
    return ""


def _given_names(node: ast.ClassDef) -> Iterator[str]:
    for line in node.body:
        match line:
            case (
                ast.Assign(targets=[ast.Name(id="name")], value=ast.Constant(value=str(name)))
                | ast.AnnAssign(target=ast.Name(id="name"), value=ast.Constant(value=str(name)))
            ):
                yield name
