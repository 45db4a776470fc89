# ruff: noqa: E501  (a mission's lines stay whole)
"""Behaviours of states: what they are given, publish, and end with."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

from tests.fsm.toy import END, VOCABULARY, Run, graph_of


def test_a_behaviour_that_cannot_be_given_its_values_fails() -> None:
    run = Run(
        """
data: {n: 0}
states:
  a: {do: go, with: {height: "${1 m / n}"}, on: {done: end, blocked: end, failed: {target: b, actions: {log: $event.reason}}}}
  b: {do: wait, on: {done: end}}
  end: {type: final}
"""
    )
    assert run.run(2) == ["b"]
    assert run.logged() == ["the parameter 'height' has no value: a division by zero"]
    assert run.log == ["begin b", "step b"]


def test_an_ended_behaviour_leaves_its_state_active_without_it() -> None:
    run = Run("states:\n  a: {do: wait, on: {done: {}, word.said: end}}\n" + END, {"a": ["done"]})
    assert run.run(5) == ["a"]
    assert run.log == ["begin a", "step a"]
    assert not run.instance.is_controlled("motion")


def test_with_is_evaluated_once_and_live_before_every_step() -> None:
    run = Run(
        """
data: {v: 1 m/s}
states:
  a:
    do: go
    with: {height: $vehicle.altitude}
    live: {speed: $v}
    on: {word.said: {actions: {set: {v: 3 m/s}}}, done: end, blocked: end}
  end: {type: final}
"""
    )
    run.run(1, altitude=5.0)
    run.post("word.said")
    run.run(1, altitude=6.0)
    (activity,) = run.activities
    assert activity.parameters == {"height": 5.0, "speed": 1.0}
    assert activity.seen == [{"speed": 1.0}, {"speed": 3.0}]


def test_published_values_are_seen_in_the_state_and_inside_it() -> None:
    run = Run(
        """
states:
  a:
    do: look
    as: eye
    when: {eye.visible: {actions: {log: "${[t.id for t in eye.tags]}"}}}
    on: {operator.abort: end}
    states: {b: {do: go, live: {to: ["${eye.x * 1}", 0, 0]}, on: {done: {}, blocked: {}}}}
  end: {type: final}
""",
        {"a": [SimpleNamespace(visible=True, x=4.0, tags=[SimpleNamespace(id=7)])]},
    )
    run.run(2)
    assert run.logged() == ["[7]"]
    assert run.activities[1].seen[0]["to"].x == 4.0


def test_published_values_begin_blank_at_each_entry() -> None:
    run = Run(
        """
data: {told: []}
states:
  a:
    do: look
    as: eye
    entry: {append: {told: $eye.x}}
    throughout: {append: {told: $eye.x}}
    on: {word.said: b}
  b: {on: {word.said: a, operator.abort: end}}
  end: {type: final}
""",
        {"a": [SimpleNamespace(visible=True, x=float(n), tags=[]) for n in (1, 2, 3, 4)]},
    )
    run.run(3)
    # The entry, then each period before that period's step.
    assert run.value("told") == [0.0, 0.0, 1.0, 2.0]
    run.post("word.said").run(1)
    run.post("word.said").run(2)
    assert run.value("told") == [0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 4.0]


def test_a_behaviour_that_ended_leaves_what_it_published() -> None:
    look = VOCABULARY.behaviors["look"]
    seek = replace(look, name="seek", outcomes={"done": {}})
    text = """
states:
  a:
    do: seek
    as: it
    on: {done: {actions: {log: $it.x}}, word.said: {actions: {log: $it.x}}, operator.abort: end}
  end: {type: final}
"""
    seen = SimpleNamespace(visible=True, x=2.5, tags=[])
    vocabulary = replace(VOCABULARY, behaviors={**VOCABULARY.behaviors, "seek": seek})
    run = Run(text, {"a": [seen, "done"]}, graph=graph_of(text, vocabulary))
    run.run(3)
    run.post("word.said").run(1)
    assert run.logged() == ["2.5", "2.5"]
