"""The cases of the SCXML test framework where they are at hand, and our own tables everywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from bench.conformance import DISPUTED, cases, verdict
from bench.no_host import NoHost
from fsm import Instance
from fsm.scxml import advance, load_document, parse_document
from tests.fsm.toy import graph_of

CASES = cases()
ABSENT = "the cases are absent: set VENCEJO_CONFORMANCE to their folder"
TABLES = sorted((Path(__file__).parent / "tables").glob("*.yaml"))
WAY_OUT = "on: {{operator.abort: over}}\n{}\n  over: {{type: final}}\n"
"""No state may be without a way out; the cases need not write it."""
OWN = [
    pytest.param(case, id=f"{path.stem}: {case['case']}")
    for path in TABLES
    for case in yaml.safe_load(path.read_text())
]


@pytest.mark.skipif(not CASES, reason=ABSENT)
def test_all_but_the_two_disputed_cases_pass() -> None:
    assert len(CASES) == 112
    assert [case for case in CASES if verdict(case)] == list(DISPUTED)


@pytest.mark.parametrize("case", OWN)
def test_table(case: dict[str, Any]) -> None:
    if "scxml" in case:
        text = '<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" {} </scxml>'
        graph = load_document(parse_document(text.format(case["scxml"]), "case.scxml"), "case")
    else:
        graph = graph_of(WAY_OUT.format(case["mission"]))
    instance = Instance(graph, NoHost())
    now = 0.0
    advance(instance, now)
    found: list[Any] = [sorted(instance.paths())]
    for step in case["steps"][1:]:
        for event, _ in step.items():
            if isinstance(event, (int, float)):
                now += event
            else:
                instance.post(event)
            advance(instance, now)
            found.append({event: sorted(instance.paths())})
    assert found == case["steps"]
    logged = [fields["text"] for what, fields in instance.records if what == "log"]
    assert logged == case.get("log", [])
