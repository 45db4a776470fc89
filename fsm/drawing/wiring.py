"""The lines of a graph's diagram, each divided into sections: one for every state it crosses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fsm.chart.graph import Edge, Node
from fsm.drawing.labels import stays
from fsm.drawing.rows import ItemKey


@dataclass(frozen=True, slots=True)
class LineSection:
    """The piece of a line inside one state."""

    inside: Node
    source: Node | None
    """A child; None when it comes from the upper border, or from the initial dot."""
    out: ItemKey
    """The line's key at its source."""
    sink: Node | None
    """A child; None when it leads to the lower border."""
    key: ItemKey
    """The line's key elsewhere: the same for all lines that may be bundled."""
    stop: bool = False
    """True when it begins or ends at the border instead of crossing it."""


@dataclass(frozen=True, slots=True)
class Wire:
    """A line: all transitions from one state to another, or (without any) an initial state's."""

    source: Node
    target: Node
    edges: tuple[Edge, ...]
    sections: tuple[LineSection, ...]
    initial: bool = False


def wires_of(nodes: tuple[Node, ...]) -> tuple[Wire, ...]:
    """All lines of a graph, in document order of their sources."""
    found: list[Wire] = []
    for node in nodes:
        if node.type == "compound":
            found.extend(_initial(node, target) for target in node.initial)
        elif node.type == "history":
            for target in node.initial:
                found.append(Wire(node, target, (), tuple(_sections(node, target, False)), True))
        ways: dict[tuple[Node, bool], list[Edge]] = {}
        for edge in node.edges():
            if not stays(edge):
                for target in edge.targets:
                    ways.setdefault((target, edge.domain is node), []).append(edge)
        for (target, inner), edges in ways.items():
            found.append(Wire(node, target, tuple(edges), tuple(_sections(node, target, inner))))
    return tuple(found)


def toward(place: Node, target: Node) -> Node:
    """The child of ``place`` that is the target or contains it."""
    return next(n for n in (target, *target.ancestors) if n.parent is place)


def _initial(node: Node, target: Node) -> Wire:
    key: ItemKey = target.index if target.type == "history" else ("initial", target.index)
    child = toward(node, target)
    sections = (LineSection(node, None, ("dot", key), child, key), *_inwards(child, target, key))
    return Wire(node, target, (), sections, True)


def _sections(source: Node, target: Node, inner: bool) -> Iterator[LineSection]:
    key, out = target.index, ("out", source.index, target.index, inner)
    if inner:
        child = toward(source, target)
        yield LineSection(source, None, out, child, key, stop=True)
        yield from _inwards(child, target, key)
        return
    name: ItemKey = out
    common = source.parent
    while common is not target and not (common is None or common.contains(target)):
        common = common.parent
    place, inside = source, source.parent
    while inside is not None and inside is not common:
        yield LineSection(inside, place, name, None, key)
        place, inside, name = inside, inside.parent, key
    assert common is not None
    if common is target:
        yield LineSection(common, place, name, None, key, stop=True)
        return
    child = toward(common, target)
    yield LineSection(common, place, name, child, key)
    yield from _inwards(child, target, key)


def _inwards(place: Node, target: Node, key: ItemKey) -> Iterator[LineSection]:
    while place is not target:
        child = toward(place, target)
        yield LineSection(place, None, key, child, key)
        place = child
