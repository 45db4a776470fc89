"""Behaviours beside a mission as they can be known without running their file: by name only."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from pathlib import Path

from behaviors.behavior import snake_case
from fsm.vocabulary import Behavior as BehaviorInfo
from vencejo.nodes import MAX_BYTES, Scalar


def trusted_behaviors(files: Sequence[Scalar], folder: Path) -> dict[str, BehaviorInfo]:
    """The behaviours that the files seem to hold; whatever a mission says of them is believed.

    Runs nothing. What cannot be read holds none.
    """
    found = {}
    for scalar in files:
        path = (folder / scalar.text).resolve()
        if path.is_relative_to(folder.resolve()) and path.is_file():
            for name in _names_in(path):
                found[name] = BehaviorInfo(name, on_trust=True)
    return found


def _names_in(path: Path) -> Iterator[str]:
    """What the classes of a Python file are called after ``do:``."""
    try:
        if path.stat().st_size > MAX_BYTES:
            return
        tree = ast.parse(path.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.bases and not node.name.startswith("_"):
            yield next(_given_names(node), snake_case(node.name))


def _given_names(node: ast.ClassDef) -> Iterator[str]:
    for line in node.body:
        match line:
            case (
                ast.Assign(targets=[ast.Name(id="name")], value=ast.Constant(value=str(name)))
                | ast.AnnAssign(target=ast.Name(id="name"), value=ast.Constant(value=str(name)))
            ):
                yield name
