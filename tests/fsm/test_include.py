# ruff: noqa: E501  (a mission stands in one line with what becomes of it)
"""Graphs inside graphs: names, parameters, outcomes, borders, files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from fsm import compile_mission, read_mission
from tests.fsm.toy import VOCABULARY, Run, faults_of, graph_of, shown
from vencejo.errors import UserError

SCAN = """\
mission: scan
parameters: {at: {type: point}, patience: 1 s, level: 1}
events: {scan.stop: {}}
data: {id: 0}
on: {scan.stop: stopped}
states:
  approach: {do: go, with: {to: $at}, on: {done: look, blocked: empty}}
  look: {entry: {set: {id: "${id + level}"}}, after: {patience: empty}, on: {word.said: found}}
  found: {type: final, output: {id: $id, word: seen}}
  empty: {type: final, outcome: empty}
  stopped: {type: final, outcome: stopped}
"""
TWICE = """\
data: {ids: [], base: 10}
states:
  north:
    include: scan.yaml
    with: {at: [0, 10, 4], level: $base}
    entry: {set: {base: 20}}
    on: {done: {target: south, actions: {append: {ids: $event.id}}}, empty: south, stopped: end}
  south:
    include: scan.yaml
    with: {at: [0, -10, 4], patience: 50 ms}
    initial: look
    on: {done: end, empty: end, stopped: end}
  end: {type: final, output: {ids: $ids}}
"""


def files(folder: Path, **texts: str) -> Path:
    """Write missions; the path of the one called m."""
    for name, text in texts.items():
        path = folder / (name.replace("__", "/") + ".yaml")
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return folder / "m.yaml"


def flown(folder: Path, script: Mapping[str, list[str | None]] | None = None, **texts: str) -> Run:
    graph = compile_mission(read_mission(files(folder, **texts), "m.yaml"), VOCABULARY)
    assert graph.warnings == ()
    return Run("", script, graph=graph)


def wrong(folder: Path, **texts: str) -> list[str]:
    with pytest.raises(UserError) as error:
        path = files(folder, **texts)
        compile_mission(read_mission(path, path.name), VOCABULARY)
    return [f"{fault.where}: {fault.code}" for fault in error.value.faults]


def test_a_flight_through_two_includes_of_one_file(tmp_path: Path) -> None:
    run = flown(tmp_path, {"north.approach": ["done"]}, m=TWICE, scan=SCAN)
    assert run.run() == ["north.approach"]
    assert run.activities[0].parameters["to"] == (0.0, 10.0, 4.0)
    assert run.run() == ["north.look"]
    run.take()
    # The level is the base after the entry of the including state.
    assert run.post("word.said", word="hi").run() == ["south.look"]
    assert run.take() == [
        "event word.said",
        "exit north.look",
        "north.look -> north.found by on word.said",
        "enter north.found",
        "event north:done",
        "exit north.found",
        "exit north:scan",
        "exit north",
        "north -> south by on done",
        "append ids 20",
        "enter south",
        "enter south:scan",
        "enter south.look",
        "set id 1",
    ]
    run.run(3)
    assert (run.instance.outcome, run.instance.output) == ("done", {"ids": [20]})


def test_what_two_includes_of_one_file_have_they_do_not_share(tmp_path: Path) -> None:
    run = flown(tmp_path, m=TWICE, scan=SCAN)
    north, south = run.graph.by_path["north:scan"], run.graph.by_path["south:scan"]
    slots = [
        {*(g.slot for g in root.given), *(d.slot for d in root.data)} for root in (north, south)
    ]
    assert len(slots[0]) == 4 and not slots[0] & slots[1]


def test_its_events_cross_the_border_both_ways(tmp_path: Path) -> None:
    outer = """\
states:
  a: {include: part.yaml, on: {done: b}, after: {1 s: {actions: {raise: part.stop}}}}
  b: {include: part.yaml, on: {part.began: end, done: end}}
  end: {type: final}
"""
    part = """\
events: {part.stop: {}}
states:
  wait: {entry: {raise: part.began}, on: {part.stop: out}}
  out: {type: final}
"""
    run = flown(tmp_path, m=outer, part=part)
    assert run.run(40) == ["a.wait"]
    run.run(2)
    assert run.instance.outcome == "done"


def test_failed_climbs_out_and_nothing_else_does(tmp_path: Path) -> None:
    outer = """\
priority: outer
states:
  a: {include: part.yaml, on: {failed: end, blocked: other}}
  other: {type: final, outcome: other}
  end: {type: final}
"""
    part = """\
states:
  go: {do: go, with: {to: home}, on: {done: again, blocked: again}}
  again: {do: go, with: {to: home}, on: {done: go, blocked: out}}
  out: {type: final, outcome: blocked}
"""
    script: Mapping[str, list[str | None]] = {"a.go": ["blocked"], "a.again": ["failed"]}
    run = flown(tmp_path, script, m=outer, part=part)
    run.run()
    assert run.run() == ["a.again"]
    run.run()
    assert run.instance.outcome == "done"
    other = flown(tmp_path, {"a.go": ["done"], "a.again": ["blocked"]}, m=outer, part=part)
    other.run(3)
    assert other.instance.outcome == "other"


def test_live_parameters_follow_each_period() -> None:
    run = Run("""\
data: {x: 1}
graphs:
  part:
    parameters: {level: 0, start: 0}
    data: {begin: $start}
    states: {a: {throughout: {log: "${level} ${begin} ${start}"}, on: {operator.abort: b}}, b: {type: final}}
throughout: {set: {x: "${x + 1}"}}
states:
  on: {include: part, with: {start: $x}, live: {level: $x}, on: {done: end}}
  end: {type: final}
""")
    run.run(3)
    assert run.logged() == ["1 1 1", "2 1 1", "3 1 1"]


def test_a_parameter_without_value_is_failed() -> None:
    run = Run("""\
data: {list: []}
graphs: {part: {parameters: {level: 0}, states: {a: {on: {operator.abort: b}}, b: {type: final}}}}
states:
  on: {include: part, with: {level: "${list[3]}"}, on: {done: end, failed: sorry}}
  sorry: {type: final, outcome: sorry}
  end: {type: final}
""")
    run.run()
    assert run.instance.outcome == "sorry"


def test_parallel_graphs_finish_and_included_graphs_are_regions() -> None:
    run = Run(
        """\
graphs:
  both:
    type: parallel
    states: {l: {do: wait}, r: {include: one, on: {done: {}}}}
  one: {states: {s: {do: wait, on: {done: e}}, e: {type: final}}}
states:
  a: {include: both, on: {done: b}}
  b: {type: parallel, on: {done: end}, states: {x: {include: one}, y: {do: wait}}}
  end: {type: final}
""",
        {"a.l": ["done"], "a.r.s": [None, "done"], "b.x.s": ["done"], "b.y": [None, "done"]},
    )
    assert run.run() == ["a.l", "a.r.s"]
    assert run.run(2) == ["b.x.s", "b.y"]
    assert run.run() == ["b.x.e", "b.y"]
    run.run(2)
    assert run.instance.outcome == "done"


def test_a_mission_may_be_nothing_but_an_include(tmp_path: Path) -> None:
    run = flown(
        tmp_path, {"approach": ["done"]}, m="include: scan.yaml\nwith: {at: home}", scan=SCAN
    )
    assert run.run(2) == ["look"]
    run.post("word.said").run()
    assert (run.instance.outcome, run.instance.output) == ("done", {"id": 1, "word": "seen"})


def test_active_is_told_from_where_it_stands() -> None:
    run = Run("""\
graphs:
  part:
    states:
      a: {when: {"active('a')": b}}
      b: {type: final}
states:
  x: {include: part, on: {done: end}, when: {"active('x.b')": end}}
  end: {type: final}
""")
    run.run(2)
    assert run.instance.outcome == "done"


PART = "parameters: {level: 1, at: {type: point}}\nstates:\n  a: {on: {operator.abort: b}}\n  b: {type: final, output: {id: 1}}\n"


def m(state: str) -> str:
    return f"states:\n  x: {{include: part.yaml, {state}}}\n  end: {{type: final}}\n"


@pytest.mark.parametrize(
    ("texts", "faults"),
    [
        ({"m": m("with: {levle: 1, at: home}, on: {done: end}")}, ["m.yaml:2:34: unknown-parameter"]),
        ({"m": m("on: {done: end}")}, ["m.yaml:2:16: missing-parameter"]),
        ({"m": m("with: {level: 3 s, at: 1}, on: {done: end}")}, ["m.yaml:2:50: unknown-place"]),
        ({"m": m("with: {at: home}, on: {operator.abort: end}")}, ["m.yaml:2:3: unhandled-outcome", "part.yaml:3:28: hidden-handler"]),
        ({"m": m("with: {at: home}, on: {done: end, empty: end}")}, ["m.yaml:2:61: unknown-outcome"]),
        ({"m": m("with: {at: home}, on: {done: x.a}")}, ["m.yaml:2:56: unknown-target"]),
        ({"m": m('with: {at: home}, on: {done: ":part"}')}, ["m.yaml:2:56: unknown-target"]),
        ({"m": m("initial: c, with: {at: home}, on: {done: end}")}, ["m.yaml:2:36: unknown-target"]),
        ({"m": m("do: wait, on: {done: end}")}, ["m.yaml:2:27: misplaced-include"]),
        (
            {"m": m("with: {at: home}, on: {done: {target: end, actions: {log: $event.di}}}")},
            ["m.yaml:2:86: unknown-field"],
        ),
        (
            {"m": "data: {mine: 1}\n" + m("with: {at: home}, on: {done: end}"),
             "part": PART + "  c: {on: {operator.abort: end}, entry: {log: $mine}}\n"},
            ["part.yaml:5:28: unknown-target", "part.yaml:5:48: unknown-name"],
        ),
        ({"m": m("on: {done: end}").replace("part.y", "prat.y")}, ["m.yaml:2:16: no-such-file"]),
        ({"m": m("on: {done: end}").replace("part.yaml", "../part.yaml")}, ["m.yaml:2:16: outside-folder"]),
        (
            {"m": m("on: {}") + "what: 1\n", "part": "wat: 1\n" + PART},
            ["m.yaml:4:1: unknown-key", "part.yaml:1:1: unknown-key"],
        ),
        ({"m": m("on: {}"), "part": "include: m.yaml"}, ["part.yaml:1:10: include-cycle"]),
        ({"m": m("on: {}"), "part": "fleet: f"}, ["part.yaml:1:8: not-a-mission"]),
        (
            {"m": m("with: {at: home}, on: {done: end}"), "part": "priority: outer\n" + PART},
            ["part.yaml:1:11: mixed-priority"],
        ),
    ],
)  # fmt: skip
def test_faults(tmp_path: Path, texts: dict[str, str], faults: list[str]) -> None:
    assert wrong(tmp_path, **{"part": PART, **texts}) == faults


def test_a_cycle_is_told_by_names() -> None:
    text = "graphs:\n  a: {states: {s: {include: b}}}\n  b: {include: a}\nstates: {s: {include: a}}"
    (fault,) = faults_of(text)
    assert (shown(fault), fault.message) == (
        "3:16 include-cycle",
        "'a' would be inside itself: a → b → a",
    )


def test_what_doubles_with_each_include_is_refused() -> None:
    graphs = "\n".join(
        f"  g{i}: {{states: {{a: {{include: g{i + 1}}}, b: {{include: g{i + 1}}}}}}}"
        for i in range(30)
    )
    text = f"graphs:\n{graphs}\n  g30: {{states: {{a: {{}}}}}}\nstates: {{s: {{include: g0}}}}"
    assert [fault.code for fault in faults_of(text)] == ["too-many-states"]


def test_many_includes_of_much_are_refused() -> None:
    actions = ", ".join("{log: x}" for _ in range(250))
    text = f"graphs:\n  part: {{states: {{a: {{entry: [{actions}]}}}}}}\nstates:\n" + "".join(
        f"  s{n}: {{include: part, after: {{1 s: s{n + 1}}}}}\n" for n in range(120)
    )
    (fault,) = faults_of(text)
    assert (fault.code, fault.message) == (
        "too-many-nodes",
        "with all includes there are more than 80,000 values",
    )


def test_files_lie_beside_the_file_that_names_them(tmp_path: Path) -> None:
    run = flown(
        tmp_path,
        m="states: {x: {include: parts/one.yaml, on: {done: end}}, end: {type: final}}",
        parts__one="include: two.yaml",
        parts__two="states: {a: {on: {operator.abort: b}}, b: {type: final}}",
    )
    assert run.run() == ["x.a"]
    assert [str(node.where.file) for node in run.graph.nodes if node.path == "x.a"] == [
        "parts/two.yaml"
    ]


def test_a_breakpoint_is_accepted() -> None:
    assert graph_of("states: {a: {breakpoint: true, on: {operator.abort: b}}, b: {type: final}}")
