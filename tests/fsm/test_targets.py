"""Targets: what a transition leaves and enters."""

from __future__ import annotations

import pytest

from tests.fsm.toy import END, Run


@pytest.mark.parametrize(
    ("transition", "entered"),
    [
        ("inner", ["enter a.inner"]),
        ("{target: inner, reenter: true}", ["enter a", "enter a.inner"]),
        ("a", ["enter a", "enter a.first"]),
    ],
)
def test_a_target_inside_does_not_leave_the_source(transition: str, entered: list[str]) -> None:
    run = Run(
        f"""
states:
  a:
    do: blink
    on: {{word.said: {transition}, operator.abort: end}}
    states: {{first: {{do: wait, on: {{done: inner}}}}, inner: {{do: wait, on: {{done: first}}}}}}
  end: {{type: final}}
"""
    )
    run.run()
    run.take()
    run.post("word.said")
    run.run()
    assert [line for line in run.take() if line.startswith("enter")] == entered


def test_a_self_transition_restarts_the_behaviour() -> None:
    run = Run(
        "states:\n  a: {do: wait, on: {done: a, operator.abort: end}}\n" + END, {"a": ["done"]}
    )
    run.run(2)
    assert run.log == ["begin a", "step a", "stop a", "begin a", "step a"]


def test_left_and_entered_in_one_period_is_one_stop_and_one_start() -> None:
    run = Run("states:\n  a: {do: blink, on: {word.said: a, operator.abort: end}}\n" + END)
    run.run()
    run.log.clear()
    run.post("word.said").post("word.said")
    run.run()
    assert run.log == ["stop a", "begin a", "step a"]
