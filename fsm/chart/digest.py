"""A hash of what a mission says: the same for the same words, whatever its layout and comments.

Only what its author wrote is hashed: keys and values of YAML, or elements and attributes of an
SCXML document, in their order. How our own classes and fields are called plays no part, nor do
places in files; a text in quotes is another value than the same text without.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from typing import Protocol

from fsm.language.spec import MissionSpec
from vencejo import nodes

FORM = 2
"""The form of what is hashed; one more whenever the same words get another digest."""


class Element(Protocol):
    """An XML element as a document gives it."""

    @property
    def tag(self) -> str: ...
    @property
    def attributes(self) -> Mapping[str, str]: ...
    @property
    def text(self) -> str: ...
    @property
    def children(self) -> Sequence[Element]: ...


def digest_of(source: MissionSpec | Element | None) -> str:
    """SHA-256, in hexadecimal, of all that a mission with its included graphs, or a document, says.

    Where an attribute stands in its element does not count. None says nothing.
    """
    hashed = sha256(f"{FORM}\n".encode())
    for word in _words(source):
        # With its length, so that no two different rows of words are the same bytes.
        data = word.encode("utf-8", "surrogatepass")
        hashed.update(b"%d:" % len(data))
        hashed.update(data)
    return hashed.hexdigest()


def _words(source: MissionSpec | Element | None) -> Iterator[str]:
    if isinstance(source, MissionSpec):
        yield from _mission(source)
    elif source is not None:
        yield from _element(source)


def _mission(mission: MissionSpec) -> Iterator[str]:
    """Each graph once, with its name and which graph every word after `include` stands for."""
    graphs = mission.closure()
    number = {id(graph): str(place) for place, graph in enumerate(graphs)}
    for graph in graphs:
        yield from ("graph", graph.name)
        if graph.node is not None:
            yield from _node(graph.node)
        for word, included in graph.included.items():
            yield from ("include", word, number[id(included)])


def _node(node: nodes.YamlNode) -> Iterator[str]:
    match node:
        case nodes.Scalar():
            yield from ("plain" if node.plain else "quoted", node.text)
        case nodes.Sequence():
            yield from ("list", str(len(node.items)))
            for item in node.items:
                yield from _node(item)
        case nodes.Mapping():
            yield from ("map", str(len(node.entries)))
            for key, value in node:
                yield key.text
                yield from _node(value)


def _element(element: Element) -> Iterator[str]:
    yield from ("element", element.tag, str(len(element.attributes)))
    for name, value in sorted(element.attributes.items()):
        yield from (name, value)
    yield from ("text", element.text, "children", str(len(element.children)))
    for child in element.children:
        yield from _element(child)
