"""Conformance with SCXML: the 112 structural cases of its test framework, by group.

All active atomic states are compared, as a set, at the start and after every event. The cases are
found in the folder that VENCEJO_CONFORMANCE names, or in ../shared/conformance beside the
checkout. With ``--peers`` other engines are installed into a throw-away environment and run the
same cases; a case that an engine cannot express is counted apart.

    python -m bench.conformance [--json] [--peers]
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from typing import Any

from bench.machine import machine
from bench.no_host import NoHost
from fsm import Instance
from fsm.scxml import advance, load_document, read_document
from vencejo.errors import UserError

_BESIDE = Path(__file__).parents[2] / "shared" / "conformance"
FOLDER = Path(os.environ.get("VENCEJO_CONFORMANCE", _BESIDE))
DISPUTED = ("more-parallel/test10", "more-parallel/test10b")
"""They expect that leaving a region for itself does not leave its parallel state, against the
W3C's findLCCA and the framework's own test2 to test8."""


def cases() -> list[str]:
    """The names of all cases; none where the folder is absent."""
    listed = FOLDER / "structural.txt"
    if not listed.exists():
        return []
    return [line for line in listed.read_text().split("\n") if line and not line.startswith("#")]


def verdict(case: str) -> str:
    """The error in a case; empty when it passed."""
    path = FOLDER / "scion" / f"{case}.scxml"
    expected = json.loads(path.with_suffix(".json").read_text())
    try:
        instance = Instance(load_document(read_document(path), case), NoHost())
    except UserError as error:
        return str(error)
    now = 0.0
    advance(instance, now)
    wrong = _difference(instance, "the start", expected["initialConfiguration"])
    for step in expected["events"]:
        now += step.get("after", 0) / 1000
        advance(instance, now)
        event = step["event"]
        instance.post(event["name"], event.get("data"))
        advance(instance, now)
        wrong = wrong or _difference(instance, event["name"], step["nextConfiguration"])
    return wrong


def _difference(instance: Instance, after: str, expected: list[str]) -> str:
    active = sorted(instance.paths())
    return "" if active == sorted(expected) else f"after {after}: {active}, not {sorted(expected)}"


PEERS = (
    "python-statemachine==3.2.2",
    "sismic==1.6.14",
    "transitions==0.9.3",
    "xstate-statemachine==0.11.0",
)
CANNOT = "cannot"
"""The first word of a peer's verdict on a case that it cannot express."""


def peer_verdicts() -> dict[str, dict[str, str]]:
    """The error in each case (see :func:`verdict`), by engine."""
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = str(Path(folder) / "bin" / "python")
        subprocess.run([python, "-m", "pip", "--quiet", "install", *PEERS], check=True)
        script = str(Path(__file__).parent / "conformance_peers.py")
        done = subprocess.run(
            [python, script, str(FOLDER)],
            input="\n".join(cases()),
            capture_output=True,
            text=True,
            check=True,
        )
    found: dict[str, dict[str, str]] = json.loads(done.stdout.splitlines()[-1])
    return {peer: found[peer.partition("==")[0]] for peer in PEERS}


def measure(peers: bool = False) -> dict[str, Any]:
    """Counts of passed cases by group, and the failed cases."""
    found = {case: verdict(case) for case in cases()}
    if not found:
        return {"cases": 0, "machine": machine()}
    result = _table(found)
    if peers:
        result["peers"] = {peer: _table(found) for peer, found in peer_verdicts().items()}
    return {**result, "machine": machine()}


def _table(verdicts: dict[str, str]) -> dict[str, Any]:
    groups: dict[str, list[int]] = {}
    for case, wrong in sorted(verdicts.items()):
        passed, cannot, total = groups.get(case.split("/")[0], (0, 0, 0))
        counts = [passed + (not wrong), cannot + wrong.startswith(CANNOT), total + 1]
        groups[case.split("/")[0]] = counts
    passed, cannot, total = (sum(counts) for counts in zip(*groups.values(), strict=True))
    return {
        "cases": total,
        "passed": passed,
        "cannot": cannot,
        "groups": groups,
        "failed": {
            case: ("disputed; " if case in DISPUTED else "") + wrong
            for case, wrong in verdicts.items()
            if wrong
        },
    }


def _cell(passed: int, cannot: int) -> str:
    return f"{passed} ({cannot} {CANNOT})" if cannot else f"{passed}"


def main() -> None:
    result = measure(peers="--peers" in sys.argv and bool(cases()))
    if "--json" in sys.argv:
        print(json.dumps(result))
        return
    if not result["cases"]:
        print("conformance: the cases are not here; set VENCEJO_CONFORMANCE to their folder")
        return
    columns = {"vencejo": result, **result.get("peers", {})}
    print(f"conformance, SCXML test framework, {result['machine']}")
    print(f"  {'passed':32}  of {' '.join(f'{name:>26}' for name in columns)}")
    for group, (_, _, count) in result["groups"].items():
        cells = (_cell(*table["groups"][group][:2]) for table in columns.values())
        print(f"  {group:32} {count:3} {' '.join(f'{cell:>26}' for cell in cells)}")
    cells = (_cell(table["passed"], table["cannot"]) for table in columns.values())
    print(f"  {'all':32} {result['cases']:3} {' '.join(f'{cell:>26}' for cell in cells)}")
    for case, wrong in result["failed"].items():
        print(f"  {case}: {wrong}")


if __name__ == "__main__":
    main()
