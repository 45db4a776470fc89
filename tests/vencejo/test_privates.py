"""No module touches another's privates: what has a leading underscore is its module's own."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = (
    "vencejo",
    "fsm",
    "worlds",
    "hal",
    "behaviors",
    "runner",
    "cli",
)
PUBLIC = {"_replace", "_asdict", "_fields", "_make", "_exit"}
"""Public names of every NamedTuple, whose underscore avoids clashes with field names; and the end
of a process in Python's ``os``.
"""


def private(name: str) -> bool:
    return name.startswith("_") and not name.endswith("__") and name not in PUBLIC | {"_"}


def own_names(tree: ast.Module) -> set[str]:
    """Names that a module defines: functions, classes, variables, fields, attributes of `self`."""
    names = set()
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                names.add(name)
            case ast.ClassDef(name=name) | ast.Name(id=name, ctx=ast.Store()):
                names.add(name)
            case ast.Attribute(value=ast.Name(id="self"), attr=name, ctx=ast.Store()):
                names.add(name)
            case ast.Assign(targets=[ast.Name(id="__slots__")], value=ast.Tuple(elts=slots)):
                names.update(slot.value for slot in slots if isinstance(slot, ast.Constant))
    return names


def accesses(source: str) -> Iterator[tuple[int, str]]:
    """Each use of a private name that the module does not define itself, with its line."""
    tree = ast.parse(source)
    own = own_names(tree)
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(attr=name) if private(name) and name not in own:
                yield node.lineno, ast.unparse(node)
            case ast.ImportFrom(module=module, names=names):
                for alias in names:
                    if private(alias.name):
                        yield node.lineno, f"{module}.{alias.name}"


@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_touches_the_privates_of_another(package: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line} {what}"
        for path in sorted((ROOT / package).rglob("*.py"))
        for line, what in accesses(path.read_text(encoding="utf-8"))
    ]
    assert found == []


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("thing._x", ["thing._x"]),
        ("thing._x = 1", ["thing._x"]),
        ("self._x", ["self._x"]),
        ("from other import _x", ["other._x"]),
        ("class A:\n def f(self, other): self._x = other._x", []),
        ("class A:\n _x: int\ndef f(a): return a._x", []),
        ("class A:\n __slots__ = ('_x',)\ndef f(a): return a._x", []),
        ("import sys\nsys.__stdout__, point._replace(x=1)", []),
    ],
)
def test_what_counts_as_an_access(source: str, found: list[str]) -> None:
    assert [what for _, what in accesses(source)] == found
