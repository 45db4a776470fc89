"""The rules that every diagram must fulfil, whatever its graph."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise

from fsm import Graph
from fsm.drawing import Box, Diagram, Label, Line
from fsm.drawing.inside import LABEL_SIZE, LINE_SIZE, NAME_SIZE
from fsm.drawing.labels import stays
from fsm.drawing.widths import text_width

Rectangle = Box | Label
Segment = tuple[tuple[float, float], tuple[float, float]]


def broken_rules(graph: Graph, diagram: Diagram) -> list[str]:
    """Everything that is wrong with a diagram; nothing, one hopes."""
    boxes = {box.path: box for box in diagram.boxes}
    return [
        *_nesting(graph, boxes, diagram),
        *_words(diagram),
        *_labels(graph, boxes, diagram),
        *_crossed_labels(diagram),
        *_missing(graph, diagram),
        *_ends(boxes, diagram),
        *_crossed_boxes(graph, boxes, diagram),
        *_upon_each_other(diagram),
    ]


def _overlap(one: Rectangle, two: Rectangle) -> bool:
    return (
        one.x < two.x + two.width
        and two.x < one.x + one.width
        and one.y < two.y + two.height
        and two.y < one.y + one.height
    )


def _within(inner: Rectangle, outer: Rectangle) -> bool:
    return (
        outer.x <= inner.x
        and outer.y <= inner.y
        and inner.x + inner.width <= outer.x + outer.width
        and inner.y + inner.height <= outer.y + outer.height
    )


def _nesting(graph: Graph, boxes: dict[str, Box], diagram: Diagram) -> Iterator[str]:
    if list(boxes) != [node.path for node in graph.nodes]:
        yield "not every state has its box"
    for node in graph.nodes:
        for child in node.children:
            if not _within(boxes[child.path], boxes[node.path]):
                yield f"{child.path} is not inside {node.path}"
        for one, two in combinations(node.children, 2):
            if _overlap(boxes[one.path], boxes[two.path]):
                yield f"{one.path} and {two.path} overlap"
    root = boxes[""]
    if root.x < 0 or root.y < 0 or root.right > diagram.width or root.bottom > diagram.height:
        yield "the diagram is too small"


def _words(diagram: Diagram) -> Iterator[str]:
    for box in diagram.boxes:
        if box.kind == "history":
            continue
        room = box.width - 14
        texts = [(box.name, NAME_SIZE, True), *((line, LINE_SIZE, False) for line in box.lines)]
        if any(text_width(text, size, bold) > room for text, size, bold in texts):
            yield f"the words of {box.path} do not fit"


def _labels(graph: Graph, boxes: dict[str, Box], diagram: Diagram) -> Iterator[str]:
    labels = [line.label for line in diagram.lines if line.label]
    for label in labels:
        if any(text_width(line, LABEL_SIZE) > label.width for line in label.lines):
            yield f"{label.lines} is wider than thought"
        for node in graph.nodes:
            box = boxes[node.path]
            if _overlap(label, box) and not (node.children and _within(label, box)):
                yield f"{label.lines} overlaps {node.path}"
            if node.children and _overlap(label, _heading(box)):
                yield f"{label.lines} overlaps the heading of {node.path}"
    for one, two in combinations(labels, 2):
        if _overlap(one, two):
            yield f"{one.lines} overlaps {two.lines}"


def _crossed_labels(diagram: Diagram) -> Iterator[str]:
    labels = [line.label for line in diagram.lines if line.label]
    for line in diagram.lines:
        for label in labels:
            if any(_touches(segment, label) for segment in pairwise(line.points)):
                yield f"{line.source} -> {line.target} crosses {label.lines}"


def _heading(box: Box) -> Label:
    height = 22 + 15 * len(box.lines)
    width = max(
        text_width(box.name, NAME_SIZE, bold=True),
        *(text_width(line, LINE_SIZE) for line in box.lines),
        0,
    )
    return Label(box.x + 14, box.y + 4, width, height, ())


def _touches(segment: Segment, area: Rectangle) -> bool:
    """Whether a vertical or horizontal piece runs through an area; touching its edge is not."""
    (x1, y1), (x2, y2) = segment
    return (
        min(x1, x2) < area.x + area.width
        and max(x1, x2) > area.x
        and min(y1, y2) < area.y + area.height
        and max(y1, y2) > area.y
    )


def _missing(graph: Graph, diagram: Diagram) -> Iterator[str]:
    drawn = {(line.source, line.target) for line in diagram.lines if line.label}
    for node in graph.nodes:
        for edge in node.edges():
            for target in () if stays(edge) else edge.targets:
                if (node.path, target.path) not in drawn:
                    yield f"{node.path} -> {target.path} is missing"


def _ends(boxes: dict[str, Box], diagram: Diagram) -> Iterator[str]:
    for line in diagram.lines:
        name = f"{line.source} -> {line.target}"
        if not line.dot and not _on_border(line.points[0], boxes[line.source]):
            yield f"{name} does not begin at its source"
        if not _on_border(line.points[-1], boxes[line.target]):
            yield f"{name} does not end at its target"
        if any((x1 != x2) == (y1 != y2) for (x1, y1), (x2, y2) in pairwise(line.points)):
            yield f"{name} is askew"
        (x1, y1), (x2, y2) = line.points[-2:]
        if x1 != x2 or abs(y1 - y2) < 8:
            yield f"{name} has no room for its head"


def _on_border(point: tuple[float, float], box: Box) -> bool:
    x, y = point
    if box.kind == "history":
        return x == box.x + box.width / 2 and y in (box.y, box.bottom)
    return box.x + 8 <= x <= box.right - 8 and y in (box.y, box.bottom)


def _crossed_boxes(graph: Graph, boxes: dict[str, Box], diagram: Diagram) -> Iterator[str]:
    """Lines run only through states around their ends, and through no heading but of their own."""
    by_path = graph.by_path
    for line in diagram.lines:
        ends = [by_path[line.source], by_path[line.target]]
        for node in graph.nodes:
            box = boxes[node.path]
            around = any(node is end or node.contains(end) for end in ends) and node.children
            area: Rectangle = _heading(box) if around else box
            if any(_touches(segment, area) for segment in pairwise(line.points)):
                yield f"{line.source} -> {line.target} runs through {node.path}"


def _upon_each_other(diagram: Diagram) -> Iterator[str]:
    """Only lines to the same target may share a way."""
    pieces: dict[tuple[bool, float], list[tuple[float, float, Line]]] = {}
    for line in diagram.lines:
        for (x1, y1), (x2, y2) in pairwise(line.points):
            upright = x1 == x2
            ends = sorted((y1, y2) if upright else (x1, x2))
            at = x1 if upright else y1
            pieces.setdefault((upright, at), []).append((ends[0], ends[1], line))
    for found in pieces.values():
        for (low, high, one), (low2, high2, two) in combinations(found, 2):
            same = one.target == two.target
            if not same and low < high2 and low2 < high:
                yield f"{_name(one)} runs upon {_name(two)}"


def _name(line: Line) -> str:
    return f"{line.source} -> {line.target}"
