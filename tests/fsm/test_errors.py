# ruff: noqa: E501  (a mission's lines stay whole)
"""`error.execution`: expressions and actions that fail."""

from __future__ import annotations

import pytest

from tests.fsm.toy import END, Run


def test_a_condition_that_fails_is_heard_of_in_the_same_period() -> None:
    run = Run(
        "data: {n: 0}\nstates:\n  a: {when: {1 / n > 1: end}, on: {error.execution: b}}\n"
        "  b: {on: {operator.abort: end}}\n" + END
    )
    run.run(1)
    assert run.run(1) == ["b"]


@pytest.mark.parametrize(
    "place",
    [
        "when: {1 / n > 1: b}",
        "throughout: {log: '${1 / n}'}",
        "throughout: [{set: {m: '${1 / n}'}}]",
        "do: go\n    live: {speed: '${1 / n}'}",
    ],
)
def test_a_failing_expression_is_an_event_once_until_it_works_again(place: str) -> None:
    run = Run(
        f"""
data: {{n: 1, m: 0}}
states:
  a:
    {place}
    on:
      error.execution: {{actions: {{log: broken}}}}
      word.said: {{actions: {{set: {{n: 0}}}}}}
      wish.made: {{actions: {{set: {{n: 1}}}}}}
      operator.abort: b
{"      done: b" if "do:" in place else ""}
{"      blocked: b" if "do:" in place else ""}
  b: {{type: final}}
events: {{wish.made: {{}}}}
"""
    )
    run.run(3)
    run.take()
    run.post("word.said")
    run.run(5)
    assert run.logged().count("broken") == 1
    run.post("wish.made")
    run.run(3)
    run.post("word.said")
    run.run(5)
    assert run.logged().count("broken") == 1


def test_an_unhandled_error_needs_the_host_and_skips_the_rest_of_its_block() -> None:
    run = Run(
        "data: {n: 0}\nstates:\n  a: {entry: [{log: '${1 / n}'}, {log: never}], on: {word.said: end}}\n"
        + END
    )
    assert run.run() == ["a"]
    assert run.logged() == []
    name, fields = run.instance.reactions[0]
    assert name == "error.execution"
    assert fields["where"] == "m.yaml:3:16"
