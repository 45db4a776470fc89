"""Outcomes: who hears how a behaviour or an inner state ended."""

from __future__ import annotations

import pytest

from fsm import Outcome
from tests.fsm.toy import Run

OUTCOMES = """
states:
  outer:
    on: {{{outer}}}
    states:
      inner: {{do: {do}, on: {{{inner}}}}}
      rest: {{do: wait, on: {{done: end}}}}
  end: {{type: final}}
"""


@pytest.mark.parametrize(
    ("do", "word", "inner", "outer", "state"),
    [
        ("wait", "done", "done: rest", "failed: end", ["outer.rest"]),
        ("go", "blocked", "done: rest", "blocked: end", ["end"]),
        ("go", "blocked", "done: rest, blocked: rest", "blocked: end", ["outer.rest"]),
        ("go", "failed", "done: rest, blocked: rest", "failed: end", ["end"]),
        ("go", "failed", "done: rest, blocked: rest, failed: rest", "failed: end", ["outer.rest"]),
    ],
)
def test_an_outcome_goes_outwards_from_its_state(
    do: str, word: str, inner: str, outer: str, state: list[str]
) -> None:
    run = Run(OUTCOMES.format(do=do, inner=inner, outer=outer), {"outer.inner": [word]})
    assert run.run(2) == state
    assert run.instance.reactions == []


def test_done_does_not_travel() -> None:
    run = Run(
        """
states:
  outer:
    on: {done: end}
    states:
      inner: {do: wait, on: {done: last}}
      last: {do: wait, on: {done: {}, word.said: last2}}
      last2: {type: final}
  end: {type: final}
""",
        {"outer.inner": ["done"], "outer.last": ["done"]},
    )
    assert run.run(4) == ["outer.last"], "the outer `done` is that of the children alone"
    run.post("word.said")
    assert run.run() == ["end"]


def test_an_outcome_never_reaches_another_region() -> None:
    run = Run(
        """
states:
  both:
    type: parallel
    states:
      left: {states: {go: {do: go, on: {done: go, blocked: {actions: {log: left}}}}}}
      right:
        on: {word.said: end}
        states: {look: {do: blink, on: {failed: {actions: {log: right}}}}}
  end: {type: final}
""",
        {"both.left.go": ["blocked", "failed"]},
    )
    run.run(2)
    assert run.logged() == ["left"]


def test_a_failure_of_one_region_is_not_heard_in_the_other_but_needs_the_host() -> None:
    run = Run(
        """
states:
  both:
    type: parallel
    on: {operator.abort: end}
    states:
      left: {do: wait}
      right: {do: blink, on: {failed: {actions: {log: right}}}}
  end: {type: final}
""",
        {"both.left": [Outcome("failed", {"reason": "wind"})]},
    )
    run.run(2)
    assert run.instance.reactions == [("failed", {"reason": "wind"})]
    assert run.logged() == []


def test_the_outcome_of_a_state_left_meanwhile_is_dropped() -> None:
    run = Run(
        """
states:
  a:
    do: wait
    on: {battery.low: a, done: end, failed: end}
  end: {type: final}
""",
        {"a": ["done", None, None, "failed"]},
    )
    run.run()
    run.post("battery.low", level=0.2)
    assert run.run(2) == ["a"]
    assert run.log == ["begin a", "step a", "stop a", "begin a", "step a", "step a"]
    assert "event a:done" not in run.take()


def test_a_final_outcome_is_dropped_when_its_state_was_left_and_entered_again() -> None:
    run = Run(
        """
states:
  a:
    on: {lost: end, oops.now: {target: a, actions: {log: again}}}
    states:
      work: {do: wait, on: {done: {target: out, actions: {raise: oops.now}}}}
      out: {type: final, outcome: lost}
  end: {type: final}
""",
        {"a.work": ["done"]},
    )
    assert run.run(2) == ["a.work"]
    assert run.logged() == ["again"]
    assert not run.instance.ended


def test_a_final_child_gives_its_outcome_and_output() -> None:
    run = Run(
        """
data: {n: 4}
states:
  part:
    on: {empty: {target: end, actions: {log: "${event.n}"}}}
    states: {x: {always: out}, out: {type: final, outcome: empty, output: {n: $n}}}
  end: {type: final, outcome: lost, output: {all: "${n + 1}"}}
"""
    )
    run.run()
    assert run.logged() == ["4"]
    assert (run.instance.outcome, run.instance.output) == ("lost", {"all": 5})
    run.take()
    run.run(3)
    assert run.take() == [], "nothing happens after the end"
