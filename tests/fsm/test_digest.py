"""The digest: a hash of an author's words, by which saved runs know their mission."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from fsm import read_mission, read_mission_text
from fsm.chart.digest import digest_of
from fsm.language.spec import MissionSpec
from fsm.scxml import parse_document
from fsm.scxml.document import Element
from tests.fsm.toy import graph_of
from vencejo.errors import Where
from vencejo.nodes import Mapping, Scalar, Sequence, YamlNode

MISSION = """
mission: golden
data: {found: [], height: 4 m}
events: {turn.back: {}}
graphs:
  point: {states: {a: {do: wait, on: {done: b}}, b: {type: final, output: {n: "7"}}}}
states:
  first: {include: point, on: {done: {target: second, actions: {append: {found: $event.n}}}}}
  second: {on: {turn.back: first, operator.abort: end}}
  end: {type: final}
"""
DOCUMENT = """
<scxml xmlns="http://www.w3.org/2005/07/scxml" initial="b">
  <state id="a"/>
  <state id="b"><transition event="e f" cond="1 &lt; 2" target="a"/><onentry><script>
    n = 1
  </script></onentry></state>
</scxml>
"""


def test_golden_digests_stay() -> None:
    """Another digest would void every saved run: then VERSION in fsm.engine.saving goes up too."""
    assert graph_of(MISSION).digest == (
        "7b54ba41b0590a6821538c90fffecd4b7fcfb9550b10b9b97240892c2c1b8f17"
    )
    assert digest_of(parse_document(DOCUMENT, "d.scxml")) == (
        "7800411fe5ad208a00547758e94e6db1c923b4fa8d4c2ace8a7897117ea129bf"
    )


class Word(Scalar):
    """A scalar of another name."""


class Row(Sequence):
    """A list of another name."""


class Table(Mapping):
    """A map of another name."""


class Written(MissionSpec):
    """A mission of another name."""


def renamed(node: YamlNode) -> YamlNode:
    match node:
        case Scalar():
            return Word(node.text, Where("elsewhere"), node.plain)
        case Sequence():
            return Row([*map(renamed, node.items)], Where("elsewhere"))
    entries = [(Word(key.text, key.where, key.plain), renamed(value)) for key, value in node]
    return Table(entries, Where("elsewhere"))


def test_how_our_classes_are_called_plays_no_part() -> None:
    spec = read_mission_text(MISSION)
    assert spec.node is not None
    node = renamed(spec.node)
    assert isinstance(node, Mapping)
    other = Written(spec.name, "elsewhere", spec.root, node=node, included=spec.included)
    assert digest_of(other) == digest_of(spec)


@dataclass(frozen=True)
class Tag:
    """An element of another make."""

    before: str
    text: str
    tag: str
    attributes: dict[str, str]
    children: list[Tag] = field(default_factory=list)


def test_how_fields_are_ordered_and_what_else_there_is_plays_no_part() -> None:
    def tag(element: Element) -> Tag:
        attributes = dict(reversed(element.attributes.items()))
        return Tag("", element.text, element.tag, attributes, [*map(tag, element.children)])

    document = parse_document(DOCUMENT, "d.scxml")
    assert digest_of(tag(document)) == digest_of(document)


def changes(node: YamlNode) -> Iterator[YamlNode]:
    """The node with one thing changed: a word, its quotes, the order or the number of parts."""
    match node:
        case Scalar():
            yield replace(node, text=node.text + "x")
            yield replace(node, plain=not node.plain)
        case Sequence(items=items):
            for place, item in enumerate(items):
                yield replace(node, items=[*items[:place], *items[place + 1 :]])
                for other in changes(item):
                    yield replace(node, items=[*items[:place], other, *items[place + 1 :]])
            yield replace(node, items=[*items, Scalar("more", node.where)])
        case Mapping(entries=entries):
            for place, (key, value) in enumerate(entries):
                before, after = entries[:place], entries[place + 1 :]
                yield replace(node, entries=[*before, *after])
                yield replace(
                    node, entries=[*before, (replace(key, text=key.text + "x"), value), *after]
                )
                if place:
                    yield replace(node, entries=[*before[:-1], entries[place], before[-1], *after])
                for other in changes(value):
                    yield replace(node, entries=[*before, (key, other), *after])


def test_any_change_of_a_mission_is_another_digest() -> None:
    spec = read_mission_text(MISSION)
    assert spec.node is not None
    variants = [
        replace(spec, node=node) for node in changes(spec.node) if isinstance(node, Mapping)
    ]
    variants += [spec, replace(spec, name="other"), replace(spec, included={})]
    assert len({digest_of(variant) for variant in variants}) == len(variants) > 100


def element_changes(element: Element) -> Iterator[Element]:
    yield replace(element, tag=element.tag + "x")
    yield replace(element, text=element.text + "x")
    yield replace(element, attributes={**element.attributes, "more": ""})
    for name, value in element.attributes.items():
        others = {n: v for n, v in element.attributes.items() if n != name}
        yield replace(element, attributes=others)
        yield replace(element, attributes={**others, name: value + "x"})
        yield replace(element, attributes={**others, name + "x": value})
    children = element.children
    for place, child in enumerate(children):
        before, after = children[:place], children[place + 1 :]
        yield replace(element, children=[*before, *after])
        if place:
            yield replace(element, children=[*before[:-1], child, before[-1], *after])
        for other in element_changes(child):
            yield replace(element, children=[*before, other, *after])


def test_any_change_of_a_document_is_another_digest() -> None:
    document = parse_document(DOCUMENT, "d.scxml")
    variants = [document, *element_changes(document)]
    assert len({digest_of(variant) for variant in variants}) == len(variants) > 30


def test_layout_comments_and_places_are_the_same_mission() -> None:
    spread = MISSION.replace("{turn.back: {}}", "\n  # a comment\n  turn.back:   {}\n")
    assert graph_of(spread).digest == graph_of(MISSION).digest
    document = parse_document(DOCUMENT, "d.scxml")
    moved = parse_document(
        "<!-- a comment -->\n\n" + DOCUMENT.replace("><", ">\n <"), "other.scxml"
    )
    assert moved.where != document.where == Where("d.scxml", 2, 1)
    assert digest_of(moved) == digest_of(document)


def test_what_is_included_counts_from_files_too(tmp_path: Path) -> None:
    def digest(part: str, file: str = "part.yaml") -> str:
        (tmp_path / file).write_text(part)
        whole = f"states: {{a: {{include: {file}, on: {{done: b}}}}, b: {{type: final}}}}"
        (tmp_path / "whole.yaml").write_text(whole)
        return digest_of(read_mission(tmp_path / "whole.yaml"))

    part = "mission: part\nstates: {x: {after: {1 s: y}}, y: {type: final}}"
    first = digest(part)
    assert digest(part + "  # the same") == first
    assert digest(part.replace("1 s", "2 s")) != first
    assert digest(part, "other.yaml") != first
