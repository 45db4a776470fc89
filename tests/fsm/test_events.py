"""Events: their order, who takes them, and `raise`, `send` and `cancel`."""

from __future__ import annotations

import pytest

from tests.fsm.toy import END, Run


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
