# ruff: noqa: E501  (a mission's lines stay whole)
"""`always` transitions, and graphs that do not come to rest."""

from __future__ import annotations

from tests.fsm.toy import Run


def test_always_is_tested_in_every_microstep_and_not_because_time_passes() -> None:
    run = Run(
        """
data: {n: 0}
states:
  a: {always: [{guard: vehicle.altitude > 1 m, target: b}], on: {word.said: {}, operator.abort: end}}
  b: {always: [{guard: n > 0, target: a}, c]}
  c: {on: {operator.abort: end}}
  end: {type: final}
"""
    )
    assert run.run(3, altitude=2.0) == ["c"]
    run = Run("", graph=run.graph)
    run.run(1)
    assert run.run(3, altitude=2.0) == ["a"]
    run.post("word.said")
    assert run.run(1) == ["c"]


def test_a_livelock_is_an_event_that_leads_out() -> None:
    run = Run(
        """
data: {n: 0}
states:
  a: {always: {guard: n == 0, target: b}}
  b: {always: {guard: n == 0, target: a}}
  safe: {entry: {raise: my.own}, on: {my.own: {actions: {log: rest}}, operator.abort: end}}
  end: {type: final}
on: {error.livelock: safe}
"""
    )
    assert run.run() == ["safe"]
    assert run.logged() == ["rest"]
    run = Run(
        "data: {n: 0}\nstates:\n  a: {always: {guard: n == 0, target: b}}\n"
        "  b: {always: {guard: n == 0, target: a}}\n"
    )
    run.run()
    assert [name for name, _ in run.instance.reactions] == ["error.livelock"]
