"""Faulty missions as files: the first line of each says which faults stand where."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from fsm import prove
from tests.fsm.toy import VOCABULARY, faults_of, graph_of, shown

FILES = sorted((Path(__file__).parent / "faults").glob("*.yaml"))
HOST = replace(VOCABULARY, must_land=("link.lost",))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_faulty_file_has_the_faults_it_says(path: Path) -> None:
    text = path.read_text()
    expected = text.splitlines()[0].partition("expected: ")[2].split(", ")
    found = faults_of(text)
    if all(fault.severity == "warning" for fault in found):
        found += prove(graph_of(text, HOST))
    assert [shown(fault) for fault in found] == expected
    assert path.stem in {fault.code for fault in found}


def test_at_least_thirty_kinds_have_a_file() -> None:
    assert len(FILES) >= 30
