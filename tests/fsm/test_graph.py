"""A compiled graph: it stays as it is, and what instances work out of it is bounded."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator
from dataclasses import FrozenInstanceError, replace
from typing import Any

import pytest

from fsm import Graph, Vocabulary
from fsm.chart import configuration as configurations
from fsm.chart.configuration import MAX_KEPT, Configuration
from fsm.engine import shared
from fsm.engine.shared import shared_by
from fsm.scxml import load_document, parse_document
from tests.fsm.test_saving import ROUND, SCRIPT
from tests.fsm.toy import VOCABULARY, Run, graph_of
from vencejo.errors import Fault

DOCUMENT = """
<scxml xmlns="http://www.w3.org/2005/07/scxml">
  <datamodel><data id="n" expr="0"/></datamodel>
  <state id="a">
    <transition event="go" target="b"><assign location="n" expr="n + 1"/></transition>
    <state id="a1"/><history id="h"><transition target="a1"/></history>
  </state>
  <state id="b"><transition event="go" cond="n &lt; 9" target="h"/></state>
</scxml>
"""


def shape(graph: Graph) -> Iterator[tuple[object, dict[str, Any]]]:
    """Every attribute of the graph, its states and its transitions, with copies of containers."""
    edges = [edge for node in graph.nodes for edge in node.edges()]
    for thing in (graph, *graph.nodes, *edges):
        yield (
            thing,
            {
                name: value.copy() if isinstance(value, (list, dict, set)) else value
                for name, value in vars(thing).items()
            },
        )


def fly_mission() -> Graph:
    graph = graph_of(ROUND)
    before = [*shape(graph)]
    run = Run("", SCRIPT, graph=graph)
    for number in range(40):
        run.post("turn.back" if number == 13 else f"word.number_{number}")
        run.run(1, battery=0.4 if number % 16 > 6 else 0.9)
    run.instance.may_trigger("turn.back")
    run.instance.suspend()
    run.instance.resume()
    run.instance.stop()
    assert [*shape(graph)] == before
    return graph


def test_flying_leaves_a_mission_as_it_was() -> None:
    assert graph_of(ROUND).digest == fly_mission().digest


def test_flying_leaves_a_document_as_it_was() -> None:
    graph = load_document(parse_document(DOCUMENT, "d.scxml"), "d")
    before = [*shape(graph)]
    run = Run("", graph=graph)
    for _ in range(5):
        run.instance.trigger("go")
    assert run.instance.paths() == ["b"]
    assert [*shape(graph)] == before


def test_a_graph_is_frozen_and_gets_its_warnings_in_a_copy() -> None:
    graph = graph_of(ROUND)
    fault = Fault("odd", "this is odd", severity="warning")
    with pytest.raises(FrozenInstanceError):
        graph.warnings = (fault,)  # type: ignore[misc]
    assert replace(graph, warnings=(fault,)).warnings == (fault,)
    assert fault not in graph.warnings


def compiled() -> list[Graph]:
    return [graph_of(ROUND), load_document(parse_document(DOCUMENT, "d.scxml"), "d")]


@pytest.mark.parametrize("graph", compiled(), ids=["mission", "document"])
def test_states_and_transitions_refuse_changes(graph: Graph) -> None:
    edges = [edge for node in graph.nodes for edge in node.edges()]
    assert edges
    for thing in (*graph.nodes, *edges):
        before = dict(vars(thing))
        assert set(type(thing).__annotations__) <= set(before), "an attribute was left out"
        for name in (*before, "something_new"):
            with pytest.raises(AttributeError, match="a compiled graph does not change"):
                setattr(thing, name, None)
            with pytest.raises(AttributeError, match="a compiled graph does not change"):
                delattr(thing, name)
        assert vars(thing) == before


CALLBACKS = {"on_enter", "on_exit", "prepare", "before", "after", "conditions"}
"""Lists that users of `transitions` add to."""


@pytest.mark.parametrize("graph", compiled(), ids=["mission", "document"])
def test_what_a_graph_holds_cannot_be_changed_either(graph: Graph) -> None:
    edges = [edge for node in graph.nodes for edge in node.edges()]
    invocations = [node.invocation for node in graph.nodes if node.invocation is not None]
    held = [
        value for thing in (graph, *graph.nodes, *edges) for name, value in vars(thing).items()
        if name not in CALLBACKS
    ]  # fmt: skip
    held += [mapping for each in invocations for mapping in (each.with_, each.live)]
    assert not [value for value in held if isinstance(value, (list, dict, set))]


def test_whose_event_is_urgent_is_said_by_the_vocabulary_asked_with() -> None:
    graph = graph_of("states: {a: {on: {word.said: b, '*': b}}, b: {type: final}}")
    node = graph.by_path["a"]
    own, caught = node.on[0][1], node.on[1][1]
    calm, urgent = VOCABULARY, Vocabulary(urgent=("word.*",))
    for _ in range(2):
        assert node.edges_for("word.said", calm) == (*own, *caught)
        assert node.edges_for("word.said", urgent) == own
        assert node.edges_for("word.other", urgent) == ()
        assert node.edges_for("error.execution", calm) == ()


# -- what is worked out of a graph --------------------------------------------------------------


def test_instances_share_what_is_worked_out_of_a_graph_and_take_it_with_them() -> None:
    run = Run(ROUND, SCRIPT)
    run.run(3)
    kept = shared_by(run.graph)
    assert shared_by(run.graph) is kept
    assert run.instance.state.configuration in kept.configurations.values()
    second = Run("", SCRIPT, graph=run.graph)
    second.run(3)
    assert second.instance.state.configuration is run.instance.state.configuration
    # A callback that knows its instance is the hardest case: graph and instance know each other.
    run.graph.by_path["work"].add_callback("enter", lambda data, run=run: run.log.append("in"))
    gone = [weakref.ref(run.graph), weakref.ref(kept)]
    del run, second, kept
    gc.collect()
    assert [ref() for ref in gone] == [None, None]


FOUR = "{states: {a: {on: {go.%s: b}}, b: {on: {go.%s: a}}}}"
REGIONS = f"""
events: {{{", ".join(f"go.{name}: {{}}" for name in "wxyz")}}}
type: parallel
states: {{{", ".join(f"{name}: {FOUR % (name, name)}" for name in "wxyz")}}}
"""


def test_configurations_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(configurations, "MAX_CONFIGURATIONS", 5)
    run = Run(REGIONS)
    seen, most = set(), 0
    for number in range(1, 33):
        # One region moves at a time, as in a Gray code: all 16 configurations come up.
        run.post(f"go.{'wxyz'[(number & -number).bit_length() % 4]}")
        seen.add(tuple(run.run()))
        most = max(most, len(shared_by(run.graph).configurations))
    assert len(seen) == 16
    assert most == 5


@pytest.mark.parametrize("text", [REGIONS, "states: {a: {on: {word.said: b}}, b: {type: final}}"])
def test_what_is_kept_for_a_configuration_is_bounded(text: str) -> None:
    run = Run(text)
    run.run()
    configuration = run.instance.state.configuration
    first = next(edge for node in run.graph.nodes for edge in node.edges())
    for number in range(3 * MAX_KEPT):
        run.instance.trigger(f"word.number_{number}")
        configuration.step((first,) * number)
    kept = [getattr(configuration, name) for name in Configuration.__slots__]
    sizes = [len(table) for table in kept if isinstance(table, dict)]
    assert len(sizes) == 3
    assert max(sizes) == MAX_KEPT


def test_model_classes_are_bounded() -> None:
    run = Run(ROUND)
    for number in range(3 * shared.MAX_MODELS):
        Run("", graph=run.graph, model=type(f"Model{number}", (type(run.instance),), {}))
    tables = [value for value in vars(shared_by(run.graph)).values() if type(value) is dict]
    assert [len(table) <= shared.MAX_MODELS for table in tables] == [True]
