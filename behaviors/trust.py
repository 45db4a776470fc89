"""Behaviours beside a mission as they can be known without running their file: by name only."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from pathlib import Path

from behaviors.behavior import snake_case
from behaviors.catalog import path_of
from fsm.vocabulary import Behavior as BehaviorInfo
from vencejo.errors import Fault, UserError
from vencejo.nodes import MAX_BYTES, Scalar


def trusted_behaviors(
    files: Sequence[Scalar], folder: Path, faults: list[Fault]
) -> dict[str, BehaviorInfo]:
    """The behaviours that the files seem to hold; whatever a mission says of them is believed.

    Runs nothing. Files that may not be used go to ``faults``; what is no Python holds none.
    """
    found = {}
    for scalar in files:
        try:
            path = path_of(scalar, folder)
        except UserError as error:
            faults.extend(error.faults)
            continue
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
