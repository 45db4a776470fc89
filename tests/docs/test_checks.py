"""docs/checks.md names every code that the source can report, and no other."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("vencejo", "fsm", "behaviors", "worlds", "hal", "runner", "cli")
REPORTERS = {
    "UserError",
    "VehicleError",
    "OutputError",
    "cannot_write",
    "Fault",
    "Misfit",
    "fail",
    "warn",
}
CODE = re.compile(r"[a-z]+(-[a-z0-9]+)*")


def codes_in(path: Path) -> Iterator[str]:
    """The codes of the faults that a file makes."""
    module = ast.parse(path.read_text())
    named = {
        target.id: node.value
        for node in module.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    for node in ast.walk(module):
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "id", getattr(node.func, "attr", ""))
        if name in REPORTERS and node.args:
            # The code stands first, or after the node of an expression.
            for code in node.args[:2]:
                code = named.get(code.id, code) if isinstance(code, ast.Name) else code
                for part in (code.body, code.orelse) if isinstance(code, ast.IfExp) else (code,):
                    if isinstance(part, ast.Constant) and CODE.fullmatch(str(part.value)):
                        yield part.value


def in_source() -> set[str]:
    return {
        code
        for package in PACKAGES
        for path in (ROOT / package).rglob("*.py")
        for code in codes_in(path)
    }


def test_every_code_is_explained() -> None:
    rows = re.findall(r"^\| `([a-z][a-z0-9-]*)` \|", (ROOT / "docs/checks.md").read_text(), re.M)
    assert len(rows) == len(set(rows))
    assert set(rows) == in_source()
