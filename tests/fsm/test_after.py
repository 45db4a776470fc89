"""Timers: `after`."""

from __future__ import annotations

from tests.fsm.toy import Run

AFTER = """
data: {{patience: 50 ms}}
states:
  a:
    entry: {{set: {{patience: 75 ms}}}}
    after: {{patience: {after}}}
    on: {{operator.abort: end}}
  b: {{on: {{operator.abort: end}}}}
  end: {{type: final}}
"""


def test_a_duration_is_evaluated_at_entry_after_the_entry_actions() -> None:
    run = Run(AFTER.format(after="b"))
    assert run.run(3) == ["a"]
    assert run.run(1) == ["b"]


def test_a_timer_whose_guards_fail_is_spent() -> None:
    run = Run(AFTER.format(after="{guard: vehicle.altitude > 1 m, target: b}"))
    run.run(4)
    assert run.run(3, altitude=2.0) == ["a"]


def test_a_targetless_timer_is_taken_once() -> None:
    run = Run(AFTER.format(after="{actions: {log: late}}"))
    run.run(10)
    assert run.logged() == ["late"]
