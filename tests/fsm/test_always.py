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


def test_a_livelock_s_way_out_that_does_not_rest_either_is_stopped() -> None:
    """What the last round raised is forgotten, so that the next period begins in peace."""
    run = Run(
        """
data: {n: 0}
events: {my.own: {}}
states:
  a: {on: {word.said: {actions: {raise: my.own}}, my.own: {actions: {raise: my.own}}, error.livelock: b}}
  b: {entry: {raise: my.own}, on: {my.own: {actions: {raise: my.own, set: {n: "${n + 1}"}}}, operator.abort: end}}
  end: {type: final}
"""
    )
    run.run()
    run.post("word.said")
    assert run.run() == ["b"]
    assert run.take().count("error more than 1000 steps without coming to rest") == 1
    taken = run.value("n")
    assert taken == 1000
    for _ in range(3):
        assert run.run() == ["b"]
        assert run.value("n") == taken
    run.post("operator.abort").run()
    assert run.instance.outcome == "done"
