"""The surface that `transitions` users know: triggers, questions and callbacks."""

from __future__ import annotations

from typing import Any

import pytest
from transitions.core import EventData

from fsm import Instance
from tests.fsm.toy import Run

TEXT = """
states:
  a: {on: {word.said: {target: b, guard: event.word == 'go'}, battery.low: {}}}
  b: {on: {word.said: end}, states: {inner: {on: {link.lost: other}}, other: {}}}
  end: {type: final}
"""


def test_trigger_processes_an_event_at_once() -> None:
    model = Run(TEXT).instance
    assert not model.trigger("word.said", word="no")
    assert model.paths() == ["a"]
    assert model.trigger("battery.low", level=0.2)
    assert model.trigger("word.said", word="go")
    assert model.paths() == ["b.inner"]
    assert model.trigger("word.said", word="")
    assert model.outcome == "done"
    assert not model.trigger("word.said", word="go")


def test_may_trigger_changes_nothing() -> None:
    model = Run(TEXT).instance
    model.trigger("battery.low", level=0.2)
    before = list(model.records)
    assert model.may_trigger("word.said", word="go")
    assert not model.may_trigger("word.said", word="no")
    assert not model.may_trigger("word.said"), "a guard that fails does not pass"
    assert not model.may_trigger("never.heard")
    assert (model.records, model.paths()) == (before, ["a"])
    assert model.trigger("battery.low", level=0.2)
    assert "error" not in [what for what, _ in model.records]


def test_questions_by_path_and_by_name() -> None:
    model = Run(TEXT).instance
    model.trigger("word.said", word="go")
    assert model.is_active("b")
    assert model.is_active("b.inner")
    assert not model.is_active("a")
    assert model.is_b()
    assert model.is_inner()
    assert not model.is_a()
    with pytest.raises(KeyError):
        model.is_active("nowhere")
    with pytest.raises(AttributeError):
        model.is_nowhere()


def test_named_questions_belong_to_one_graph_and_hide_no_method() -> None:
    away = "{on: {word.said: c}}"
    inside = f"c: {{states: {{same: {away}, other: {away}}}}}"
    run = Run(f"states: {{active: {away}, b: {{states: {{same: {away}}}}}, {inside}}}")
    model, first = run.instance, Run(TEXT).instance
    model.period(0.0)
    assert model.is_active("active")
    assert (model.is_b(), model.is_other()) == (False, False)
    assert not hasattr(model, "is_same"), "two states have this name"
    assert not hasattr(model, "is_inner")
    assert not hasattr(first, "is_c")
    assert not first.is_other()
    assert type(Instance(run.graph, run)) is type(model)


class Told(Instance):
    """A model whose methods are callbacks."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.told: list[str] = []

    def tell(self, event: EventData) -> None:
        self.told.append(f"tell {event.kwargs.get('word')} at {', '.join(self.paths())}")


def test_callbacks_are_honoured_in_order() -> None:
    run = Run(TEXT, model=Told)
    model = run.instance
    assert isinstance(model, Told)
    said: list[str] = []
    a, b = run.graph.by_path["a"], run.graph.by_path["b"]
    edge = a.on[0][1][0]
    edge.add_callback("prepare", lambda event: said.append(f"prepare {event.kwargs['word']}"))
    edge.add_callback("before", lambda event: said.append("before"))
    edge.add_callback("after", lambda event: said.append("after"))
    edge.add_callback("after", "tell")
    a.add_callback("exit", lambda event: said.append(f"exit {event.model is model}"))
    b.add_callback("enter", lambda event: said.append("enter"))
    model.trigger("word.said", word="no")
    assert said == ["prepare no"]
    model.trigger("word.said", word="go")
    assert said == ["prepare no", "prepare go", "before", "exit True", "enter", "after"]
    assert model.told == ["tell go at b.inner"]


def test_callbacks_see_the_configuration_of_their_moment() -> None:
    graph = Run(TEXT).graph
    model = Run(TEXT, graph=graph).instance
    seen: list[Any] = []
    for path in ("a", "b", "b.inner"):
        for when in ("enter", "exit"):
            graph.by_path[path].add_callback(
                when,
                lambda event, now=(when, path): seen.append(
                    (*now, [node.path for node in model.active[1:]], model.paths(), model.is_b())
                ),
            )
    model.trigger("word.said", word="go")
    model.stop()
    assert seen == [
        ("enter", "a", ["a"], ["a"], False),
        ("exit", "a", ["a"], ["a"], False),
        ("enter", "b", ["b"], [], True),
        ("enter", "b.inner", ["b", "b.inner"], ["b.inner"], True),
        ("exit", "b.inner", ["b", "b.inner"], ["b.inner"], True),
        ("exit", "b", ["b"], [], True),
    ]
    assert (model.active, model.paths()) == ((), [])


def test_a_condition_added_to_a_transition_counts() -> None:
    from transitions.core import Condition

    run = Run(TEXT)
    edge = run.graph.by_path["a"].on[0][1][0]
    allowed = [False]
    edge.conditions.append(Condition(lambda event: allowed[0]))
    assert not run.instance.trigger("word.said", word="go")
    allowed[0] = True
    assert run.instance.trigger("word.said", word="go")


def test_states_and_transitions_are_those_of_transitions() -> None:
    from transitions.core import State, Transition

    graph = Run(TEXT).graph
    assert all(isinstance(node, State) for node in graph.nodes)
    edges = [edge for node in graph.nodes for edge in node.edges()]
    assert all(isinstance(edge, Transition) for edge in edges)
    assert [(edge.source, edge.dest) for edge in edges] == [
        ("a", "b"), ("a", ""), ("b", "end"), ("b.inner", "b.other"),
    ]  # fmt: skip
    assert graph.by_path["end"].final


def test_entry_and_exit_callbacks_of_a_microstep_share_their_data() -> None:
    run = Run(TEXT)
    told: list[tuple[str, EventData]] = []
    for node in run.graph.nodes:
        node.add_callback("enter", lambda data, path=node.path: told.append((path, data)))
        node.add_callback("exit", lambda data, path=node.path: told.append((path, data)))
    run.run()
    run.instance.trigger("word.said", word="go")
    run.instance.stop()
    steps = [["", "a"], ["a", "b", "b.inner"], ["b.inner", "b", ""]]
    assert [path for path, _ in told] == [path for step in steps for path in step]
    each = [data for _, data in told]
    assert [data is each[0] for data in each] == [True] * 2 + [False] * 6
    assert [data is each[2] for data in each] == [False] * 2 + [True] * 3 + [False] * 3
    assert [data is each[5] for data in each] == [False] * 5 + [True] * 3
    assert each[2].kwargs == {"word": "go"}
    assert each[5].kwargs == {}
