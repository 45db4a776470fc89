# ruff: noqa: E501  (a mission's lines stay whole)
"""Variables, parameters, defined names, and what expressions see."""

from __future__ import annotations

from tests.fsm.toy import END, Run
from vencejo.geometry import Point


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


def test_typed_lists_hold_what_they_say() -> None:
    run = Run(
        """
parameters: {heights: {type: [length], default: [1 m, 50 cm]}}
events: {got.list: {values: [time]}}
data: {seen: {type: [length]}, grid: {type: [[number]], default: [[1], [2, 3]]}}
states:
  a:
    entry: [{append: {seen: 2 m}}, {append: {seen: "${heights[0] / 4}"}}, {append: {grid: [4]}}]
    on: {got.list: {target: end, guard: sum(event.values) > 2 s}}
    when: {max(heights) > 3 m: end}
  end: {type: final, output: {seen: $seen, grid: $grid}}
"""
    )
    run.run()
    run.post("got.list", values=[1.0, 2.0])
    run.run()
    assert run.instance.output == {"seen": [2.0, 0.25], "grid": [[1], [2, 3], [4]]}


def test_range_counts_and_dt_is_the_period() -> None:
    run = Run(
        """
data: {total: 0 s, squares: []}
throughout: {set: {total: "${total + dt}"}}
states:
  a:
    entry: [{set: {squares: "${[i * i for i in range(1, 4)]}"}}, {log: "${dt}"}]
    on: {operator.abort: end}
  end: {type: final}
"""
    )
    run.run(3)
    assert run.logged() == ["0.025"]
    assert run.value("squares") == [1, 4, 9]
    assert abs(run.value("total") - 0.075) < 1e-9
    run.now += 0.1
    run.run()
    assert abs(run.value("total") - 0.2) < 1e-9


def test_a_point_that_leaves_its_height_open_is_measured_at_the_other() -> None:
    text = """
parameters: {where: {type: point, default: home}}
states:
  a:
    entry: {log: "${distance(where, vehicle.position)} ${where.x}"}
    on: {operator.abort: end}
  end: {type: final}
"""
    for where, expected in (("home", "5 0"), ({"x": 3.0, "y": 0.0}, "4 3")):
        run = Run(text, parameters={"where": where})
        run.run(1, position=Point(3.0, 4.0, 7.0))
        assert run.logged() == [expected]
