"""Conditions: `when` and `for`."""

from __future__ import annotations

import pytest

from tests.fsm.toy import Run

WHEN = """
states:
  a:
    when: {{{when}}}
    on: {{operator.abort: end}}
  b: {{on: {{operator.abort: end}}}}
  end: {{type: final}}
"""

HIGH = "vehicle.altitude > 1 m"


def test_a_condition_is_first_tested_in_the_period_after_entry() -> None:
    run = Run(WHEN.format(when=f"{HIGH}: b"))
    assert run.run(1, altitude=2.0) == ["a"]
    assert run.run(1) == ["b"]


def test_a_condition_is_taken_once_until_it_was_seen_false() -> None:
    run = Run(WHEN.format(when=f"{HIGH}: {{actions: {{log: high}}}}"))
    run.run(5, altitude=2.0)
    assert run.logged() == ["high"]
    run.run(1, altitude=0.0)
    run.run(3, altitude=2.0)
    assert run.logged() == ["high"]


def test_for_needs_the_condition_without_a_break() -> None:
    run = Run(WHEN.format(when=f"{HIGH}: {{for: 50 ms, target: b}}"))
    run.run(1)
    run.run(2, altitude=2.0)
    run.run(1, altitude=0.0)
    assert run.run(2, altitude=2.0) == ["a"]
    assert run.run(1) == ["b"]


PENDING = """
states:
  a:
    when: {{{outer}}}
    on: {{operator.abort: end}}
    states:
      x: {{when: {{{inner}}}, on: {{my.no: a}}, entry: {{send: my.no}}}}
  b: {{on: {{operator.abort: end}}}}
  end: {{type: final}}
""".replace(", on: {{my.no: a}}, entry: {{send: my.no}}", "")


@pytest.mark.parametrize("outer", [f"{HIGH}: b", f"{HIGH}: {{for: 0 s, target: b}}"])
def test_a_forestalled_condition_stays_pending_even_when_false_again(outer: str) -> None:
    run = Run(PENDING.format(outer=outer, inner=f"{HIGH}: {{actions: {{log: inner}}}}"))
    run.run(1)
    assert run.run(1, altitude=2.0) == ["a.x"]
    assert run.logged() == ["inner"]
    assert run.run(1, altitude=0.0) == ["b"]


def test_a_forestalled_alternative_with_for_stays_pending() -> None:
    run = Run(
        PENDING.format(
            outer=f"{HIGH}: {{for: 50 ms, target: b}}",
            inner="time_in_state >= 75 ms: {actions: {log: inner}}",
        )
    )
    run.run(1)
    run.run(2, altitude=2.0)
    assert run.run(1) == ["a.x"], "the inner one went first"
    assert run.run(1, altitude=0.0) == ["b"]


def test_a_pending_condition_taken_while_false_is_armed_at_once() -> None:
    run = Run(
        PENDING.format(
            outer=f"{HIGH}: {{actions: {{log: outer}}}}",
            inner=f"{HIGH}: {{actions: {{log: inner}}}}",
        )
    )
    run.run(1)
    run.run(1, altitude=2.0)
    run.run(1, altitude=0.0)
    assert run.logged() == ["inner", "outer"]
    run.run(2, altitude=2.0)
    assert run.logged() == ["inner", "outer"]


def test_a_condition_whose_guards_fail_is_spent_until_it_was_false() -> None:
    run = Run(WHEN.format(when=f"{HIGH}: {{guard: vehicle.battery < 50 %, target: b}}"))
    run.run(1)
    run.run(1, altitude=2.0)
    assert run.run(2, battery=0.2) == ["a"]
    run.run(1, altitude=0.0)
    assert run.run(1, altitude=2.0) == ["b"]


def test_conditions_go_before_timers_and_the_timer_stays_due() -> None:
    run = Run(
        WHEN.format(when=f"{HIGH}: {{actions: {{log: when}}}}").replace(
            "    on:", "    after: {25 ms: b}\n    on:", 1
        )
    )
    run.run(1, altitude=2.0)
    assert run.run(1) == ["a"]
    assert run.logged() == ["when"]
    assert run.run(1) == ["b"]
