"""Checks of missions that are as nasty as a file may be: bounded in steps, time and memory."""

from __future__ import annotations

from pathlib import Path

import pytest

from behaviors import drone_vocabulary
from fsm import compile_mission, prove, read_mission_text
from fsm.checks import macrosteps
from fsm.checks.exploration import Explorer
from fsm.checks.macrosteps import TooManyError
from tests.fsm.nasty_missions import NASTY, check_usage

CPU_SECONDS = 2.0
MEGABYTES = 200


QUICK = (
    "many histories",
    "a deep history of regions",
    "events sent in a circle",
    "choices in every region",
)


@pytest.mark.parametrize("name", QUICK)
def test_the_proof_is_bounded_by_its_steps(name: str) -> None:
    text = f"mission: m\n{NASTY[name]}"
    graph = compile_mission(read_mission_text(text), drone_vocabulary())
    explorer = Explorer(graph)
    with pytest.raises(TooManyError):
        explorer.explore()
    assert [fault.code for fault in prove(graph)] == ["not-proven"]
    assert explorer.macrosteps.steps <= macrosteps.MAX_STEPS + 100 * len(graph.nodes)
    assert len(explorer.situations) <= macrosteps.MAX_STEPS


@pytest.mark.slow
@pytest.mark.parametrize("text", NASTY.values(), ids=NASTY)
def test_a_whole_check_is_bounded(text: str, tmp_path: Path) -> None:
    used = (check_usage(text, tmp_path / "m.yaml") for _ in range(2))
    seconds, megabytes = zip(*used, strict=True)
    # A busy machine makes CPU time longer, never shorter.
    assert min(seconds) <= CPU_SECONDS
    assert max(megabytes) <= MEGABYTES
