"""One form for two languages: the same chart in YAML and in SCXML becomes the same graph."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import pytest

from fsm import Graph
from fsm.chart.draft import Draft, compatible
from fsm.chart.nesting import domain_of
from fsm.scxml import load_document, parse_document
from tests.fsm.toy import graph_of
from vencejo.errors import Where

MISSION = """
events: {go.in: {}, go.out: {}, go.both: {}, go.self: {}, go.back: {}}
states:
  off: {on: {go.in: on, go.both: {target: [on.left.b, on.right.b]}, go.back: on.left.h}}
  on:
    type: parallel
    on: {go.out: off, go.self: {target: on.left, reenter: true}}
    states:
      left:
        initial: b
        on: {go.in: left.a, go.back: {target: left.a, reenter: true}}
        states:
          a: {on: {go.self: a}}
          b: {always: {target: a, guard: time > 5}}
          h: {type: history, deep: true, target: a}
      right:
        states:
          a: {on: {go.out: b}}
          b: {on: {go.out: {}}}
"""
DOCUMENT = """
<scxml xmlns="http://www.w3.org/2005/07/scxml">
  <state id="off">
    <transition event="go.in" target="on"/>
    <transition event="go.both" target="on.left.b on.right.b"/>
    <transition event="go.back" target="on.left.h"/>
  </state>
  <parallel id="on">
    <transition event="go.out" target="off"/>
    <transition event="go.self" target="on.left"/>
    <state id="on.left" initial="on.left.b">
      <transition event="go.in" type="internal" target="on.left.a"/>
      <transition event="go.back" target="on.left.a"/>
      <state id="on.left.a"><transition event="go.self" target="on.left.a"/></state>
      <state id="on.left.b"><transition cond="1 &gt; 5" target="on.left.a"/></state>
      <history id="on.left.h" type="deep"><transition target="on.left.a"/></history>
    </state>
    <state id="on.right">
      <state id="on.right.a"><transition event="go.out" target="on.right.b"/></state>
      <state id="on.right.b"><transition event="go.out"/></state>
    </state>
  </parallel>
</scxml>
"""


def structure(graph: Graph) -> Iterator[str]:
    """Everything that follows from where states lie and what transitions lead to."""
    for node in graph.nodes:
        inside = [inner.path for inner in graph.nodes if node.contains(inner)]
        initial = [state.path for state in node.initial]
        around = [state.path for state in node.ancestors]
        yield f"{node.index} {node.path} {node.type} {node.deep} {initial} {around} {inside}"
        for edge in node.edges():
            domain = None if edge.domain is None else edge.domain.path
            guarded = edge.guard is not None
            yield f"  {edge.kind} {edge.trigger}: {edge.dest}, in {domain!r}, guarded {guarded}"


def test_both_languages_make_the_same_graph() -> None:
    mission = [*structure(graph_of(MISSION))]
    assert mission == [*structure(load_document(parse_document(DOCUMENT, "d"), "d"))]
    assert [line for line in mission if line.startswith("  ")] == [
        "  on go.in: on, in '', guarded False",
        "  on go.both: on.left.b, on.right.b, in '', guarded False",
        "  on go.back: on.left.h, in '', guarded False",
        "  on go.out: off, in '', guarded False",
        "  on go.self: on.left, in '', guarded False",
        "  on go.in: on.left.a, in 'on.left', guarded False",
        "  on go.back: on.left.a, in '', guarded False",
        "  on go.self: on.left.a, in 'on.left', guarded False",
        "  always always: on.left.a, in 'on.left', guarded True",
        "  on go.out: on.right.b, in 'on.right', guarded False",
        "  on go.out: , in None, guarded False",
    ]


@pytest.fixture
def draft() -> Draft:
    """root(both(left(a, b), right(c)), other)."""
    draft, here = Draft(), Where("d")
    root = draft.add("", "", "compound", here, None)
    root.border = True
    both = draft.add("both", "both", "parallel", here, root)
    left = draft.add("left", "both.left", "compound", here, both)
    draft.add("a", "both.left.a", "atomic", here, left)
    draft.add("b", "both.left.b", "atomic", here, left)
    right = draft.add("right", "both.right", "compound", here, both)
    draft.add("c", "both.right.c", "atomic", here, right)
    draft.add("other", "other", "atomic", here, root)
    return draft


def test_states_are_numbered_in_document_order(draft: Draft) -> None:
    assert [(s.index, s.last, s.depth) for s in draft] == [
        (0, 7, 0), (1, 6, 1), (2, 4, 2), (3, 3, 3), (4, 4, 3), (5, 6, 2), (6, 6, 3), (7, 7, 1),
    ]  # fmt: skip
    assert [[child.name for child in s.children] for s in draft if s.children] == [
        ["both", "other"], ["left", "right"], ["a", "b"], ["c"],
    ]  # fmt: skip
    assert [s.name for s in draft[3].outwards()] == ["a", "left", "both", ""]


def test_only_states_of_different_regions_can_be_entered_together(draft: Draft) -> None:
    pairs = {
        f"{a.name}+{b.name}"
        for a, b in combinations(draft, 2)
        if compatible(a, b) and compatible(b, a)
    }
    assert pairs == {"left+right", "left+c", "a+right", "b+right", "a+c", "b+c"}
    assert not any(compatible(b, a) for a, b in combinations(draft, 2) if not compatible(a, b))


def test_a_history_state_stands_for_everything_beside_it() -> None:
    draft, here = Draft(), Where("d")
    both = draft.add("both", "both", "parallel", here, draft.add("", "", "compound", here, None))
    of_both = draft.add("h", "both.h", "history", here, both)
    left = draft.add("left", "both.left", "compound", here, both)
    of_left = draft.add("h", "both.left.h", "history", here, left)
    draft.add("a", "both.left.a", "atomic", here, left)
    right = draft.add("right", "both.right", "atomic", here, both)
    assert not any(compatible(of_both, each) or compatible(each, of_both) for each in draft)
    beside = [each for each in draft if compatible(of_left, each) and compatible(each, of_left)]
    assert beside == [right]


@pytest.mark.parametrize(
    ("source", "targets", "reenter", "domain"),
    [
        (2, [3], False, "left"),  # inside a compound state: it is not left
        (2, [3], True, ""),  # unless that is asked for; a parallel state is no domain
        (1, [3, 6], False, ""),  # inside a parallel state: it is left
        (3, [4], False, "left"),
        (3, [3], False, "left"),
        (3, [7], False, ""),
        (0, [7], True, ""),  # the root is never left
        (3, [], True, None),
    ],
)
def test_the_domain_of_a_transition(
    draft: Draft, source: int, targets: list[int], reenter: bool, domain: str | None
) -> None:
    found = domain_of(draft[source], [draft[index] for index in targets], reenter)
    assert (None if found is None else found.name) == domain


def test_the_root_of_an_included_graph_is_not_left_by_its_own_transitions(draft: Draft) -> None:
    left = draft[2]
    left.border = True
    assert domain_of(left, [draft[3]], True) is left
