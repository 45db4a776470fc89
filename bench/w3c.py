"""Conformance with SCXML: the tests of the W3C, as others have converted them to a data model.

A test passes when it ends in the state `pass`. Documents run on a simulated clock, so that a delay
of seconds costs nothing. FOLDER holds `mandatory/` and `optional/` with the documents; files that
others load (`test216sub1.scxml`) are no tests of their own. They lie, for instance, in the
repository fgmacedo/python-statemachine under tests/scxml/w3c.

    python -m bench.w3c FOLDER [--json]
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from bench.machine import machine
from bench.no_host import NoHost
from fsm import Instance
from fsm.scxml import advance, load_document, read_document
from vencejo.errors import UserError

Verdict = Literal["passed", "failed", "refused"]
VERDICTS: tuple[Verdict, ...] = ("passed", "failed", "refused")
PATIENCE = 60.0
"""Simulated seconds after which a test that has not ended has failed."""
_LOADED_BY_OTHERS = re.compile(r"test\d+sub\d+")
_NEEDS = {
    "with <invoke>": re.compile(r"<invoke[\s>]"),
    "over HTTP": re.compile("BasicHTTPEventProcessor"),
}
"""What sets a group of tests apart, and the text in its documents."""


@dataclass(frozen=True)
class Result:
    """The outcome of one test."""

    group: str
    test: str
    verdict: Verdict
    reason: str = ""
    """Why it did not pass."""


def results(folder: Path) -> Iterator[Result]:
    """Run every test below a folder."""
    for path in sorted(folder.glob("*/*.scxml")):
        if not _LOADED_BY_OTHERS.fullmatch(path.stem):
            yield Result(group_of(path), path.stem, *verdict(path))


def group_of(path: Path) -> str:
    """The group that a test is counted in: `mandatory`, or `mandatory, with <invoke>`."""
    text = path.read_text("utf-8-sig")
    needs = next((need for need, pattern in _NEEDS.items() if pattern.search(text)), None)
    return f"{path.parent.name}, {needs}" if needs else path.parent.name


def verdict(path: Path) -> tuple[Verdict, str]:
    """Run one test; why it did not pass is empty when it did."""
    try:
        graph = load_document(read_document(path, path.name), path.stem)
    except UserError as error:
        fault = next(fault for fault in error.faults if fault.severity == "error")
        return "refused", f"{fault.code}: {fault.message}"
    instance = Instance(graph, NoHost())
    try:
        advance(instance, 0.0)
        advance(instance, PATIENCE)
    except RuntimeError as error:
        return "failed", str(error)
    if instance.paths() == ["pass"]:
        return "passed", ""
    return "failed", f"ended in {', '.join(instance.paths())}"


def measure(folder: Path) -> dict[str, Any]:
    """Counts by group and by reason, and the tests that did not pass."""
    found = list(results(folder))
    groups: dict[str, dict[str, int]] = {}
    for group in sorted({result.group for result in found}):
        counts = Counter(result.verdict for result in found if result.group == group)
        groups[group] = {"tests": counts.total(), **{word: counts[word] for word in VERDICTS}}
    refused = Counter(result.reason for result in found if result.verdict == "refused")
    return {
        "groups": groups,
        "refused": dict(refused.most_common()),
        "not passed": {
            f"{result.group}: {result.test}": f"{result.verdict}: {result.reason}"
            for result in found
            if result.verdict != "passed"
        },
        "machine": machine(),
    }


def main() -> None:
    folders = [Path(word) for word in sys.argv[1:] if not word.startswith("-")]
    if len(folders) != 1 or not folders[0].is_dir():
        sys.exit("usage: python -m bench.w3c FOLDER [--json], a folder with mandatory/*.scxml")
    result = measure(folders[0])
    if "--json" in sys.argv:
        print(json.dumps(result))
        return
    print(f"W3C tests of SCXML, {result['machine']}")
    print(f"  {'':26} {'tests':>8} {' '.join(f'{word:>8}' for word in VERDICTS)}")
    for group, counts in result["groups"].items():
        print(f"  {group:26} {' '.join(f'{count:8}' for count in counts.values())}")
    print("refused because of")
    for reason, count in result["refused"].items():
        print(f"  {count:3}  {reason}")
    print("not passed")
    for test, reason in result["not passed"].items():
        print(f"  {test}: {reason}")


if __name__ == "__main__":
    main()
