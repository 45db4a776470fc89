from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fsm import Graph
from fsm.drawing import draw, render, write_dot, write_mermaid, write_svg, write_text
from fsm.scxml import load_document, parse_document
from tests.fsm.drawing.random_graphs import random_graph
from tests.fsm.drawing.rules import broken_rules
from tests.fsm.toy import graph_of

SVG = "{http://www.w3.org/2000/svg}"
LOOPS = """\
mission: loops
states:
  outer:
    on: {battery.low: {target: inner.one, reenter: true}, link.lost: outer}
    states:
      inner:
        on: {operator.abort: two}
        states:
          one: {on: {word.said: [{guard: event.word == 'up', target: outer}, {target: one}]}}
          two: {always: {guard: time_in_state > 1 s, target: one}, after: {2 s: back}}
          back: {type: history, deep: true, target: one}
  side:
    type: parallel
    on: {link.lost: end}
    states:
      left: {do: wait, on: {done: left}}
      right: {states: {only: {after: {1 s: only}}}}
  end: {type: final, outcome: tired}
"""
LOOPS = LOOPS.replace("link.lost: outer}", "link.lost: outer, word.said: side}").replace(
    "done: left", "done: {target: left, reenter: true}"
)
WORDS = """\
mission: words
data: {seen: 0}
states:
  look:
    do: look
    entry: {log: "a text that nobody wants to read in a box because it is long"}
    on:
      tag.seen: {guard: event.id > 3, actions: [{set: {seen: $event.id}}, {raise: a.b}]}
      battery.low: {guard: seen > 1000 and time_in_state > 1000 s, target: end, name: enough}
    when: {vehicle.altitude > 2 m: {for: 2 s, target: end, actions: {send: {event: a.b}}}}
    after: {3 s: end}
    always: {guard: seen > 7, target: end}
  end: {type: final}
"""


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), states=st.integers(2, 60))
def test_no_diagram_breaks_a_rule(seed: int, states: int) -> None:
    graph = random_graph(seed, states)
    assert broken_rules(graph, draw(graph)) == []


@pytest.mark.parametrize("text", [LOOPS, WORDS])
def test_these_neither(text: str) -> None:
    graph = graph_of(text)
    assert broken_rules(graph, draw(graph)) == []


def test_a_graph_of_one_state_with_a_long_name() -> None:
    graph = graph_of(f"mission: m\nstates: {{{'w' * 60}: {{type: final}}}}\n")
    assert broken_rules(graph, draw(graph)) == []


def test_the_same_graph_gives_the_same_diagram() -> None:
    assert draw(random_graph(7, 40)) == draw(random_graph(7, 40))


def _titles(svg: str) -> list[str]:
    return [element.text or "" for element in ElementTree.fromstring(svg).iter(f"{SVG}title")]


def test_what_is_shortened_is_whole_in_the_titles() -> None:
    graph = graph_of(WORDS)
    (line,) = (line for line in draw(graph).lines if line.source == "look")
    assert line.label is not None
    assert line.label.lines == (
        "enough [seen > 1000 and time_…]",
        "when vehicle.altitude > 2 m… / send a.b",
        "after 3 s",
        "[seen > 7]",
    )
    titles = _titles(write_svg(graph))
    assert line.title in titles
    assert line.title == (
        "look → end\n"
        "battery.low [seen > 1000 and time_in_state > 1000 s]\n"
        "when vehicle.altitude > 2 m for 2 s / send {event: a.b}\n"
        "after 3 s\n"
        "[seen > 7]"
    )
    assert (
        "look\ndo look\n"
        "entry: log a text that nobody wants to read in a box because it is long\n"
        "tag.seen [event.id > 3] / set {seen: $event.id}; raise a.b"
    ) in titles


def _count(graph: Graph, tag: str, kind: str, active: tuple[str, ...] = ()) -> int:
    drawn = ElementTree.fromstring(render(draw(graph), active))
    return sum(kind in (e.get("class") or "").split() for e in drawn.iter(SVG + tag))


def test_final_history_parallel_and_initial_have_their_signs() -> None:
    graph = graph_of(LOOPS)
    assert _count(graph, "rect", "ring") == 1
    assert _count(graph, "circle", "leaf") == 1
    assert _count(graph, "path", "apart") == 1
    assert _count(graph, "circle", "dot") == 4
    assert _count(graph, "path", "head") == len(draw(graph).lines)
    assert _count(graph, "rect", "active", ("outer", "outer.inner")) == 2


def _numbers(element: ElementTree.Element, *names: str) -> tuple[float, ...]:
    return tuple(float(element.get(name) or "nan") for name in names)


def _points(path: ElementTree.Element) -> list[tuple[float, ...]]:
    """The corners of a path, those of its curves included."""
    pairs = re.findall(r"(-?[\d.]+) (-?[\d.]+)", path.get("d") or "")
    return [tuple(map(float, pair)) for pair in pairs]


def _texts(group: ElementTree.Element, kind: str) -> list[tuple[str, float, float]]:
    return [
        (element.text or "", *_numbers(element, "x", "y"))
        for element in group.iter(f"{SVG}text")
        if element.get("class") == kind
    ]


@pytest.mark.parametrize("text", [LOOPS, WORDS])
def test_the_picture_shows_the_boxes_of_the_diagram(text: str) -> None:
    graph = graph_of(text)
    diagram, page = draw(graph), ElementTree.fromstring(write_svg(graph))
    assert _numbers(page, "width", "height") == pytest.approx((diagram.width, diagram.height))
    assert page.get("viewBox") == f"0 0 {diagram.width:g} {diagram.height:g}"
    groups = {group.get("data-state"): group for group in page.iter(f"{SVG}g")}
    for box in diagram.boxes:
        group = groups[box.path]
        if box.kind == "history":
            (circle,) = group.iter(f"{SVG}circle")
            x, y, radius = _numbers(circle, "cx", "cy", "r")
            middle = box.x + box.width / 2, box.y + box.height / 2
            assert (x, y, 2 * radius) == pytest.approx((*middle, box.width), abs=1e-3)
            assert [word for word, *_ in _texts(group, "more")] == [box.name]
            continue
        border, *ring = group.iter(f"{SVG}rect")
        place = box.x, box.y, box.width, box.height
        assert _numbers(border, "x", "y", "width", "height") == pytest.approx(place, abs=1e-3)
        assert len(ring) == (box.kind == "final")
        for inner in ring:
            x, y, width, height = place
            within = x + 3, y + 3, width - 6, height - 6
            assert _numbers(inner, "x", "y", "width", "height") == pytest.approx(within, abs=1e-3)
        ((name, x, y),) = _texts(group, "name")
        assert name == box.name and box.x < x < box.right and box.y < y < box.bottom
        lines = _texts(group, "more")
        assert [word for word, *_ in lines] == list(box.lines)
        heights = [y, *(height for _, _, height in lines)]
        assert heights == sorted(set(heights)) and heights[-1] < box.bottom


@pytest.mark.parametrize("text", [LOOPS, WORDS])
def test_the_picture_shows_the_lines_of_the_diagram(text: str) -> None:
    graph = graph_of(text)
    diagram, page = draw(graph), ElementTree.fromstring(write_svg(graph))
    groups = [group for group in page.iter(f"{SVG}g") if group.get("data-state") is None]
    joined = 0
    for line, group in zip(diagram.lines, groups, strict=True):
        path, head = group.iter(f"{SVG}path")
        first, *_, end = _points(path)
        assert first == pytest.approx(line.points[0], abs=1e-3)
        # The tip of the head is where the line ends; the line itself ends at its base.
        tip, left, right = _points(head)
        (x, y), (_, before) = line.points[-1], line.points[-2]
        base = y + 8 if y < before else y - 8
        assert tip == pytest.approx((x, y), abs=1e-3)
        assert (*left, *right) == pytest.approx((x - 4, base, x + 4, base), abs=1e-3)
        joined += end != pytest.approx((x, base), abs=1e-3)
        dots = [_numbers(dot, "cx", "cy", "r") for dot in group.iter(f"{SVG}circle")]
        above = line.points[0][0], line.points[0][1] - 5, 5.0
        assert dots == ([pytest.approx(above, abs=1e-3)] if line.dot else [])
        label = line.label
        words = _texts(group, "label")
        assert [word for word, *_ in words] == list(label.lines if label else ())
        for _, x, y in words:
            assert label and x == pytest.approx(label.x, abs=1e-3)
            assert label.y < y < label.y + label.height
    assert joined < len(diagram.lines) / 2
    borders = [path for path in page.iter(f"{SVG}path") if path.get("class") == "apart"]
    assert [_points(path) for path in borders] == [
        [pytest.approx(end, abs=1e-3) for end in ends] for ends in diagram.separators
    ]


def test_lines_that_have_joined_are_drawn_once() -> None:
    """Else a state that all others lead to makes a file of megabytes."""
    states = ", ".join(f"s{n}: {{on: {{battery.low: s{n + 1}, link.lost: s0}}}}" for n in range(40))
    graph = graph_of(f"mission: m\nstates: {{{states}, s40: {{type: final}}}}\n")
    paths = ElementTree.fromstring(write_svg(graph)).iter(f"{SVG}path")
    corners = [(path.get("d") or "").count("Q") for path in paths if path.get("class") == "line"]
    together = {point for line in draw(graph).lines for point in line.points}
    assert sum(corners) < 1.5 * len(together)


def test_what_svg_would_misread_is_escaped() -> None:
    guard = "time_in_state < 1 s"
    graph = graph_of(
        "mission: m\ndescription: a <b> & c\nstates:\n"
        f"  one: {{after: {{1 s: {{target: two, guard: {guard}}}, 2 s: two}}}}\n"
        "  two: {type: final}\n"
    )
    svg = write_svg(graph)
    assert f"one → two\nafter 1 s [{guard}]\nafter 2 s" in _titles(svg)
    assert ElementTree.fromstring(svg).findtext(f"{SVG}desc") == "a <b> & c"


def test_letters_that_no_xml_can_hold_are_marked() -> None:
    graph = graph_of('mission: m\ndescription: "a\\x01b"\nstates: {one: {type: final}}\n')
    assert ElementTree.fromstring(write_svg(graph)).findtext(f"{SVG}desc") == "a\ufffdb"


DOCUMENT = """\
<scxml xmlns="http://www.w3.org/2005/07/scxml" name="a: [b] &#10;&quot;c&quot; #">
  <state id="one&quot;{"><transition event="go" cond="1 &lt; 2" target="back"/></state>
  <parallel id="both">
    <history id="back" type="deep"><transition target="left.b right.b"/></history>
    <state id="left"><state id="left.a"/><state id="left.b"/></state>
    <state id="right"><state id="right.a"/><state id="right.b"/></state>
  </parallel>
</scxml>
"""


def test_a_history_of_several_regions_leads_to_each() -> None:
    diagram = draw(load_document(parse_document(DOCUMENT, "d.scxml"), "d"))
    boxes = {box.path: box for box in diagram.boxes}
    ends = {line.target: line.points[-1] for line in diagram.lines if line.source == "back"}
    assert {path: y for path, (_, y) in ends.items()} == {
        path: boxes[path].y for path in ("left.b", "right.b")
    }


def test_odd_names_do_not_end_a_text_of_mermaid() -> None:
    lines = write_mermaid(load_document(parse_document(DOCUMENT, "d.scxml"), "d")).splitlines()
    assert lines[:5] == [
        "---",
        "title: \"a∶ [b] 'c' ＃\"",
        "---",
        "stateDiagram-v2",
        '  state "one\'(" as s1',
    ]
    assert "  s1 --> s3: go [1 ＜ 2]" in lines


def test_the_languages_of_other_tools_have_every_state_and_transition() -> None:
    graph = graph_of(LOOPS)
    lines = sum(len(edge.targets) for node in graph.nodes for edge in node.edges())
    mermaid, dot, text = write_mermaid(graph), write_dot(graph), write_text(graph)
    assert mermaid.count(" as s") == len(graph.nodes) - 1
    assert mermaid.count("  --\n") == 1
    assert mermaid.count(" --> ") == lines + 4 + 1 + 1  # initial, to the end, history's own
    assert dot.count("[label=") + dot.count("subgraph") >= len(graph.nodes)
    assert dot.count("{") == dot.count("}")
    assert text.count(" -> ") == lines + 1
    assert "    back (deep history)\n" in text
    assert "  end (final, outcome tired)\n" in text
