from __future__ import annotations

from pathlib import Path

import pytest

from fsm.drawing import draw
from runner.missions import find
from runner.preparation import prepare
from tests.cli.run_cli import run_cli
from tests.fsm.drawing.rules import broken_rules
from tests.missions.shipped import MISSIONS

TEXT = """\
hop: Up and down.
  > takeoff
      do takeoff (altitude)
      done -> land
  land
      do land
      done -> finish
  finish (final)
"""
MERMAID = """\
---
title: "hop"
---
stateDiagram-v2
  state "takeoff\\ndo takeoff" as s1
  state "land\\ndo land" as s2
  state "finish" as s3
  [*] --> s1
  s3 --> [*]
  s1 --> s2: done
  s2 --> s3: done
"""


def test_text_is_the_default(hop: str) -> None:
    result = run_cli("show", hop)
    assert (result.code, result.out, result.err) == (0, TEXT, "")


def test_mermaid(hop: str) -> None:
    assert run_cli("show", hop, "--format", "mermaid").out == MERMAID


def test_dot_has_every_state_and_transition(hop: str) -> None:
    out = run_cli("show", hop, "--format", "dot").out
    assert '    s3 [label="finish", peripheries=2];' in out
    assert '  s1 -> s2 [label="done"];' in out
    assert out.startswith('digraph "hop" {') and out.endswith("}\n")


@pytest.mark.parametrize("mission", MISSIONS)
@pytest.mark.parametrize("format_", ["text", "mermaid", "dot", "svg"])
def test_every_shipped_mission_is_shown_the_same_each_time(mission: str, format_: str) -> None:
    first = run_cli("show", mission, "--format", format_)
    assert first.code == 0 and first.out
    assert run_cli("show", mission, "--format", format_).out == first.out


def test_a_file_is_written_and_an_impossible_one_is_named(hop: str) -> None:
    assert run_cli("show", hop, "--output", "hop.txt").out == ""
    assert Path("hop.txt").read_text() == TEXT
    wrong = run_cli("show", hop, "-o", "nowhere/hop.txt")
    assert wrong.code == 2
    assert "nowhere/hop.txt: error: this file cannot be written: No such" in wrong.err


def test_an_unknown_format_gets_the_nearest(hop: str) -> None:
    result = run_cli("show", hop, "--format", "mermaids")
    assert result.code == 2
    assert "mermaid" in result.err


@pytest.mark.parametrize("mission", MISSIONS)
def test_pictures_of_shipped_missions_break_no_rule(mission: str) -> None:
    graph = prepare(find(mission)).graph
    assert broken_rules(graph, draw(graph)) == []


def test_an_exported_mission_is_checked_with_what_it_includes() -> None:
    Path("part.yaml").write_text("states: {down: {do: land, on: {done: z}}, z: {type: final}}\n")
    Path("whole.yaml").write_text(
        "mission: whole\nstates:\n  up: {do: takeoff, on: {done: rest, failed: rest}}\n"
        "  rest: {include: part.yaml, on: {done: z, failed: z}}\n  z: {type: final}\n"
    )
    assert run_cli("show", "whole.yaml", "--format", "scxml", "-o", "whole.scxml").code == 0
    shown = [run_cli("show", f"whole.{end}") for end in ("yaml", "scxml")]
    assert [result.code for result in shown] == [0, 0]
    assert shown[0].out == shown[1].out
