# ruff: noqa: E501  (a mission's lines stay whole)
"""Variables, parameters, defined names, and what expressions see."""

from __future__ import annotations

from tests.fsm.toy import END, Run


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


def test_parameters_count_and_can_be_given() -> None:
    text = (
        "parameters: {p: 2 m}\nstates:\n  a: {entry: {log: '${p}'}, on: {operator.abort: end}}\n"
        + END
    )
    for given, said in ((None, "2"), ({"p": 5.0}, "5")):
        run = Run(text, None, given)
        run.run()
        assert run.logged() == [said]
