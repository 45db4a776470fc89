# ruff: noqa: E501  (a mission's lines stay whole)
"""The order of things in a mission period, and in a microstep."""

from __future__ import annotations

from tests.fsm.toy import END, Run, graph_of


def test_a_period_is_events_then_world_then_throughout_then_behaviours() -> None:
    run = Run(
        """
data: {looks: 0}
states:
  a:
    do: go
    live: {speed: "${looks * 1 m/s}"}
    on: {word.said: {actions: {log: event}}, done: end, blocked: end}
    when: {vehicle.altitude > 1 m: {actions: {log: world}}}
    throughout: [{log: "throughout ${looks}"}, {set: {looks: "${looks + 1}"}}]
  end: {type: final}
"""
    )
    run.run()
    run.take()
    run.post("word.said", word="x", more=1)
    run.run(altitude=2.0)
    assert run.take() == [
        "event word.said",
        "a ->  by on word.said",
        "log event",
        "a ->  by when vehicle.altitude > 1 m",
        "log world",
        "log throughout 1",
        "set looks 2",
    ]
    assert run.log == ["begin a", "step a", "step a"]
    assert run.activities[0].seen == [{"speed": 1.0}, {"speed": 2.0}]


def test_states_are_left_inner_first_and_entered_outer_first_with_actions_between() -> None:
    run = Run(
        """
states:
  a:
    entry: {log: in a}
    exit: {log: out a}
    states:
      b: {do: wait, entry: {log: in b}, exit: {log: out b}, on: {done: {target: c, actions: {log: go}}}}
  c: {entry: {log: in c}, do: wait, on: {done: end}}
  end: {type: final}
""",
        {"a.b": ["done"]},
    )
    run.run(2)
    assert run.take() == [
        "enter /", "enter a", "log in a", "enter a.b", "log in b", "start a.b",
        "event a.b:done", "log out b", "exit a.b", "log out a", "exit a", "a.b -> c by on done",
        "log go", "enter c", "log in c", "start c",
    ]  # fmt: skip
    assert run.log == ["begin a.b", "step a.b", "stop a.b", "begin c", "step c"]


def test_two_runs_of_one_graph_share_nothing() -> None:
    graph = graph_of(
        "data: {l: []}\nstates:\n  a: {on: {word.said: {actions: {append: {l: 1}}}, operator.abort: end}}\n"
        + END
    )
    one, two = Run("", graph=graph), Run("", graph=graph)
    one.run(), two.run()
    one.post("word.said")
    one.run(), two.run()
    assert (one.value("l"), two.value("l")) == ([1], [])


def test_stopping_leaves_every_state() -> None:
    run = Run("states:\n  a: {do: wait, exit: {log: bye}, on: {done: end}}\n" + END)
    run.run()
    run.instance.stop("aborted")
    assert run.logged() == ["bye"]
    assert (run.instance.outcome, run.instance.paths(), run.log[-1]) == ("aborted", [], "stop a")
