"""Parallel states: their end, and transitions of several regions."""

from __future__ import annotations

import pytest

from tests.fsm.toy import Run

PARALLEL = """
states:
  both:
    type: parallel
    on: {done: end, operator.abort: end}
    states:
      l: {do: wait}
      r: {states: {x: {do: wait, on: {done: out}}, out: {type: final}}}
  end: {type: final}
"""


@pytest.mark.parametrize(
    "script",
    [
        {"both.l": ["done"], "both.r.x": [None, "done"]},
        {"both.l": [None, None, "done"], "both.r.x": ["done"]},
        {"both.l": ["done"], "both.r.x": ["done"]},
    ],
)
def test_a_parallel_state_is_done_when_all_its_regions_are(script: dict[str, list[str]]) -> None:
    run = Run(PARALLEL, script)
    assert run.run(1) == ["both.l", "both.r.x"]
    run.run(1)
    assert run.run(2) == ["end"]
    assert run.instance.outcome == "done"


def test_the_parallel_done_comes_after_the_region_s_own() -> None:
    run = Run(PARALLEL, {"both.l": [None, None, "done"], "both.r.x": ["done"]})
    run.run(3)
    run.take()
    run.post("battery.low", level=0.2)
    run.run(1)
    events = [line for line in run.take() if line.startswith("event")]
    assert events == ["event battery.low unheard", "event both.l:done unheard", "event both:done"]


def test_behaviours_that_end_in_one_period_make_their_parallel_state_done_once() -> None:
    run = Run(
        """
states:
  both:
    type: parallel
    on: {done: {actions: {log: done}}, operator.abort: end}
    states: {l: {do: wait}, r: {states: {x: {do: wait, on: {done: out}}, out: {type: final}}}}
  end: {type: final}
""",
        {"both.l": [None, "done"], "both.r.x": ["done"]},
    )
    run.run(5)
    assert run.logged() == ["done"]


def test_a_mission_of_regions_ends_when_all_have() -> None:
    run = Run(
        "type: parallel\nstates: {a: {do: wait}, b: {do: wait}}", {"a": ["done"], "b": ["done"]}
    )
    run.run(2)
    assert run.instance.outcome == "done"


def test_of_two_regions_that_both_leave_the_earlier_wins() -> None:
    run = Run(
        """
states:
  both:
    type: parallel
    states:
      l: {on: {word.said: x}}
      r: {on: {word.said: y}}
  x: {on: {operator.abort: end}}
  y: {on: {operator.abort: end}}
  end: {type: final}
"""
    )
    run.run()
    run.post("word.said")
    assert run.run() == ["x"]


def test_of_two_conflicting_transitions_the_inner_one_wins() -> None:
    run = Run(
        """
states:
  both:
    type: parallel
    states:
      l: {on: {my.own: {}}}
      r:
        on: {word.said: both_out, my.own: y}
        states: {deep: {on: {word.said: y}}}
    on: {word.said: x, operator.abort: end}
  both_out: {on: {operator.abort: end}}
  x: {on: {operator.abort: end}}
  y: {on: {operator.abort: end}}
  end: {type: final}
events: {my.own: {}}
"""
    )
    run.run()
    run.post("word.said")
    assert run.run() == ["y"], "the parallel state's own comes first, for the other region"


def test_regions_that_do_not_meet_both_move() -> None:
    run = Run(
        """
states:
  both:
    type: parallel
    on: {operator.abort: end}
    states:
      l: {states: {a: {on: {word.said: b}}, b: {on: {word.said: a}}}}
      r: {states: {a: {on: {word.said: b}}, b: {on: {word.said: a}}}}
  end: {type: final}
"""
    )
    run.run()
    run.post("word.said")
    assert run.run() == ["both.l.b", "both.r.b"]


def test_a_list_as_target_enters_several_regions() -> None:
    run = Run(
        """
states:
  start: {on: {word.said: {target: [both.r.b, both.l.b]}}}
  both:
    type: parallel
    on: {operator.abort: end}
    states:
      l: {states: {a: {on: {word.said: b}}, b: {on: {word.said: a}}}}
      r: {states: {a: {on: {word.said: b}}, b: {on: {word.said: a}}}}
      z: {do: blink}
  end: {type: final}
"""
    )
    run.run()
    run.post("word.said")
    assert run.run() == ["both.l.b", "both.r.b", "both.z"]


def test_a_region_that_is_entered_again_has_not_finished() -> None:
    text = PARALLEL.replace("operator.abort: end", "word.said: both, operator.abort: end")
    run = Run(text, {"both.l": ["done", None, None, "done"], "both.r.x": [None, None, "done"]})
    run.run(2)
    run.post("word.said").run()
    assert run.run(2) == ["both.l", "both.r.out"], "the left one works again"
    assert run.run(2) == ["end"]
