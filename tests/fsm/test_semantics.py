# ruff: noqa: E501  (missions and tables keep their lines)
"""The rules by which a graph runs, one case each."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from fsm import Outcome
from tests.fsm.toy import Run, graph_of

END = "  end: {type: final}\n"


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


# -- outcomes --------------------------------------------------------------------------------

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


# -- events -----------------------------------------------------------------------------------


def test_urgent_events_go_first_and_the_rest_in_order_of_arrival() -> None:
    run = Run(
        """
states:
  a:
    on:
      word.said: {actions: {log: "$event.word"}}
      battery.low: {actions: {log: "${event.level}"}}
      operator.abort: end
  end: {type: final}
"""
    )
    run.run()
    run.post("word.said", word="one").post("word.said", word="two")
    run.post("battery.low", level=0.25)
    run.run()
    assert run.logged() == ["0.25", "one", "two"]


@pytest.mark.parametrize(("priority", "who"), [("inner", "inner"), ("outer", "outer")])
@pytest.mark.parametrize("event", ["word.said", "wish.made"])
def test_which_of_nested_states_is_asked_first(priority: str, who: str, event: str) -> None:
    run = Run(
        f"""
priority: {priority}
events: {{wish.made: {{}}}}
states:
  a:
    on: {{{event}: {{actions: {{log: outer}}}}, operator.abort: end}}
    states:
      b: {{on: {{{event}: {{actions: {{log: inner}}}}}}}}
  end: {{type: final}}
"""
    )
    run.run()
    run.post(event)
    run.run()
    assert run.logged() == [who]


@pytest.mark.parametrize(
    ("pattern", "event", "heard"),
    [
        ("'*'", "word.said", True),
        ("word.*", "word.said", True),
        ("'*'", "battery.low", False),
        ("battery.*", "battery.low", True),
        ("'*'", "error.execution", False),
        ("error.*", "error.execution", True),
    ],
)
def test_families_of_events(pattern: str, event: str, heard: bool) -> None:
    run = Run(
        f"states:\n  a: {{on: {{{pattern}: {{actions: {{log: heard}}}}, operator.abort: end}}}}\n"
        + END
    )
    run.run()
    run.post(event)
    run.run()
    assert run.logged() == (["heard"] if heard else [])


def test_the_first_alternative_whose_guard_passes_is_taken() -> None:
    text = """
states:
  a:
    on:
      word.said:
        - {guard: event.word == 'b', target: b}
        - {guard: event.word == 'c', target: c}
        - end
  b: {on: {operator.abort: end}}
  c: {on: {operator.abort: end}}
  end: {type: final}
"""
    for word, state in {"b": "b", "c": "c", "z": "end"}.items():
        run = Run(text)
        run.run()
        run.post("word.said", word=word)
        assert run.run() == [state]


def test_an_unheard_event_is_gone_and_an_urgent_one_needs_the_host() -> None:
    run = Run(
        "states:\n  a: {on: {operator.abort: {target: end, guard: 1 > 2}, word.said: end}}\n" + END
    )
    run.run()
    run.post("operator.abort").post("link.lost", age=4.0).post("battery.low", level=0.1)
    run.run()
    assert run.instance.reactions == [("operator.abort", {}), ("link.lost", {"age": 4.0})]
    assert run.instance.paths() == ["a"]


def test_a_transition_without_target_handles_an_urgent_event() -> None:
    run = Run("states:\n  a: {on: {operator.abort: {}, word.said: end}}\n" + END)
    run.run()
    run.post("operator.abort")
    assert run.run() == ["a"]
    assert run.instance.reactions == []


def test_raised_events_are_heard_in_the_macrostep_and_after_always() -> None:
    run = Run(
        """
data: {n: 0}
states:
  a:
    on:
      word.said: {actions: [{raise: {my.own: {n: 5}}}, {set: {n: 1}}]}
      my.own: {target: end, actions: {log: "own ${event.n}"}}
    always: {guard: n == 1, actions: [{log: always}, {set: {n: 2}}]}
  end: {type: final}
"""
    )
    run.run()
    run.post("word.said")
    assert run.run() == ["end"]
    assert run.logged() == ["always", "own 5"]


def test_send_is_heard_in_a_later_period_and_can_be_taken_back() -> None:
    run = Run(
        """
states:
  a:
    entry:
      - {send: {event: my.now, with: {n: 1}}}
      - {send: {event: my.late, delay: 100 ms}}
      - {send: {event: my.never, delay: 100 ms, id: x}}
    on:
      my.now: {actions: [{log: "now ${event.n}"}, {cancel: x}]}
      my.late: {target: end, actions: {log: late}}
      my.never: {actions: {log: never}}
  end: {type: final}
"""
    )
    run.run(1)
    assert run.logged() == []
    run.run(1)
    assert run.logged() == ["now 1"]
    assert run.run(2) == ["a"]
    assert run.run(1) == ["end"]
    assert run.logged() == ["late"]


def test_what_throughout_raises_is_heard_in_the_next_period_in_order() -> None:
    run = Run(
        """
data: {n: 0}
states:
  a:
    throughout: [{set: {n: $n + 1}}, {raise: {tick.one: {n: $n}}}, {raise: tick.two}]
    on:
      tick.one: {actions: {log: "one ${event.n}"}}
      tick.two: {actions: {log: two}}
      operator.abort: end
  end: {type: final}
""".replace("{n: $n + 1}", '{n: "${n + 1}"}')
    )
    run.run(1)
    assert run.logged() == []
    run.run(1)
    assert run.logged() == ["one 1", "two"]


# -- when and after ---------------------------------------------------------------------------

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


# -- always, livelock, errors -------------------------------------------------------------------


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


# -- actions and data ---------------------------------------------------------------------------


def test_set_takes_all_right_sides_first_and_append_makes_a_new_list() -> None:
    run = Run(
        """
data: {a: 1, b: 2, l: [], k: []}
states:
  s:
    entry: [{set: {a: $b, b: $a}}, {append: {l: $a}}, {set: {k: $l}}, {append: {l: 7}}]
    on: {operator.abort: end}
  end: {type: final}
"""
    )
    run.run()
    assert [run.value(name) for name in "ablk"] == [2, 1, [2, 7], [2]]


def test_data_begin_anew_at_each_entry_before_its_actions() -> None:
    run = Run(
        """
states:
  a:
    data: {n: 0, start: $vehicle.altitude}
    entry: [{log: "${n} ${start}"}, {set: {n: 5}}]
    on: {word.said: a, operator.abort: end}
  end: {type: final}
"""
    )
    run.run(1, altitude=3.0)
    run.post("word.said")
    run.run(1, altitude=4.0)
    assert run.logged() == ["0 3", "0 4"]


def test_define_is_evaluated_at_each_use_and_takes_arguments() -> None:
    run = Run(
        """
define: {twice(v): v * 2, high: vehicle.altitude > limit, limit: 2 m}
states:
  a:
    when: {high: {actions: {log: "${twice(twice(3))} ${time_in_state:.2f}"}}}
    on: {operator.abort: end}
  end: {type: final}
"""
    )
    run.run(2)
    run.run(1, altitude=3.0)
    assert run.logged() == ["12 0.05"]


def test_time_in_state_is_that_of_the_state_it_stands_in() -> None:
    run = Run(
        """
define: {whole: time_in_state}
states:
  a: {after: {50 ms: b}}
  b: {when: {time_in_state > 20 ms: {actions: {log: "${whole:.3f} ${time_in_state:.3f}"}}}, on: {operator.abort: end}}
  end: {type: final}
"""
    )
    run.run(4)
    assert run.logged() == ["0.075 0.025"]


def test_active_asks_for_a_state_of_another_region() -> None:
    run = Run(
        """
states:
  both:
    type: parallel
    on: {operator.abort: end}
    states:
      l: {states: {a: {on: {word.said: b}}, b: {on: {word.said: a}}}}
      r: {when: {active('both.l.b'): {actions: {log: b}}}}
  end: {type: final}
"""
    )
    run.run(2)
    run.post("word.said")
    run.run(2)
    assert run.logged() == ["b"]


# -- final, parallel ----------------------------------------------------------------------------


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


# -- targets ------------------------------------------------------------------------------------


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


# -- history ------------------------------------------------------------------------------------

HISTORY = """
states:
  work:
    data: {{n: 0}}
    on: {{word.said: pause}}
    states:
      one: {{do: wait, on: {{done: two}}}}
      two:
        data: {{m: 0}}
        on: {{my.more: {{actions: [{{set: {{m: "${{m + 1}}", n: "${{n + 1}}"}}}}]}}}}
        states:
          x: {{do: wait, on: {{done: y}}}}
          y: {{do: wait, on: {{done: x}}}}
      back: {{type: history, target: one{deep}}}
  pause: {{on: {{my.back: work.back, my.anew: work, operator.abort: end}}}}
  end: {{type: final}}
events: {{my.more: {{}}, my.back: {{}}, my.anew: {{}}}}
"""
SCRIPT = {"work.one": ["done"], "work.two.x": ["done"]}


@pytest.mark.parametrize(
    ("deep", "state", "m", "progress"),
    [(", deep: true", "work.two.y", 1, {"steps": 3}), ("", "work.two.x", 1, None)],
)
def test_history_gives_back_states_data_and_progress(
    deep: str, state: str, m: int, progress: dict[str, int] | None
) -> None:
    run = Run(HISTORY.format(deep=deep), SCRIPT)
    run.run(3)
    run.post("my.more")
    run.run(2)
    run.post("word.said")
    assert run.run() == ["pause"]
    run.post("my.back")
    assert run.run() == [state]
    assert (run.value("n"), run.value("m")) == (1, m)
    assert run.activities[-1].resumed == progress


def test_without_history_everything_begins_anew() -> None:
    run = Run(HISTORY.format(deep=""), SCRIPT)
    run.run(3)
    run.post("my.more").post("word.said")
    run.run()
    run.post("my.anew")
    assert run.run() == ["work.one"]
    assert run.value("n") == 0
    assert run.activities[-1].resumed is None


def test_history_goes_to_its_target_the_first_time() -> None:
    run = Run(
        HISTORY.format(deep="").replace("states:\n  work", "initial: pause\nstates:\n  work", 1)
    )
    run.run()
    run.post("my.back")
    assert run.run() == ["work.one"]


def test_deep_history_restores_every_region() -> None:
    run = Run(
        """
states:
  work:
    on: {word.said: pause, operator.abort: end}
    states:
      both:
        type: parallel
        states:
          l: {states: {a: {on: {my.go: b}}, b: {on: {my.go: a}}}}
          r: {states: {a: {on: {my.go: b}}, b: {on: {my.go: a}}}}
      back: {type: history, deep: true, target: both}
  pause: {on: {my.back: work.back}}
  end: {type: final}
events: {my.go: {}, my.back: {}}
"""
    )
    run.run()
    run.post("my.go").post("word.said").post("my.back")
    assert run.run() == ["work.both.l.b", "work.both.r.b"]


# -- behaviours ---------------------------------------------------------------------------------


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


def test_parameters_count_and_can_be_given() -> None:
    text = (
        "parameters: {p: 2 m}\nstates:\n  a: {entry: {log: '${p}'}, on: {operator.abort: end}}\n"
        + END
    )
    for given, said in ((None, "2"), ({"p": 5.0}, "5")):
        run = Run(text, None, given)
        run.run()
        assert run.logged() == [said]


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
