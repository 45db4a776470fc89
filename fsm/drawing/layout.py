"""Draws the diagram of a graph: lays out every state, inner ones first, then joins them."""

from __future__ import annotations

from itertools import pairwise

from fsm.chart.graph import Graph, Node
from fsm.drawing.diagram import XY, Box, Diagram, Label, Line
from fsm.drawing.inside import BESIDE, LABEL_SIZE, LINE_HEIGHT, PAD, Inside, lay_out
from fsm.drawing.labels import edge_text, node_title
from fsm.drawing.widths import text_width
from fsm.drawing.wiring import LineSection, Wire, wires_of

MARGIN = 12.0


def draw(graph: Graph) -> Diagram:
    """The diagram of a graph: the same one each time."""
    wires = wires_of(tuple(graph.nodes))
    sections: dict[Node, list[tuple[LineSection, Wire]]] = {node: [] for node in graph.nodes}
    up, down = dict.fromkeys(graph.nodes, 0), dict.fromkeys(graph.nodes, 0)
    for wire in wires:
        for section in wire.sections:
            sections[section.inside].append((section, wire))
        if not wire.initial or wire.source.type == "history":
            down[wire.source] += 1
    for target, _ in {(w.target, w.initial) for w in wires}:
        up[target] += 1
    insides: dict[Node, Inside] = {}
    for node in reversed(graph.nodes):
        inner = {child: insides[child] for child in node.children}
        insides[node] = lay_out(
            node, _name(graph, node), inner, sections[node], (up[node], down[node])
        )
    return _Assembly(graph, insides).diagram(wires)


class _Assembly:
    """Joins the layouts of the states into one diagram."""

    def __init__(self, graph: Graph, insides: dict[Node, Inside]) -> None:
        self.graph = graph
        self.insides = insides
        self.origins: dict[Node, XY] = {graph.root: (MARGIN, MARGIN)}
        for node in graph.nodes:
            x, y = self.origins[node]
            for child, item in insides[node].items.items():
                self.origins[child] = (x + PAD + item.left, y + item.y)

    def diagram(self, wires: tuple[Wire, ...]) -> Diagram:
        root = self.insides[self.graph.root]
        return Diagram(
            self.graph.name,
            self.graph.description,
            root.width + 2 * MARGIN,
            root.height + 2 * MARGIN,
            tuple(self.box(node) for node in self.graph.nodes),
            tuple(self.line(wire) for wire in wires),
            tuple(part for node in self.graph.nodes for part in self.separators(node)),
        )

    def box(self, node: Node) -> Box:
        inside, (x, y) = self.insides[node], self.origins[node]
        return Box(
            node.path,
            node.type,
            len(node.ancestors),
            x,
            y,
            inside.width,
            inside.height,
            inside.name,
            inside.lines,
            node_title(node),
        )

    def line(self, wire: Wire) -> Line:
        points: list[XY] = []
        for section in wire.sections:
            inside = self.insides[section.inside]
            start = inside.items[section.source] if section.source else inside.starts[section.out]
            dx, dy = self.origins[section.inside]
            points.extend(
                (x + dx, y + dy) for x, y in inside.follow(start, section.out, section.key)
            )
        told = "\n".join(edge_text(edge) for edge in wire.edges)
        return Line(
            wire.source.path,
            wire.target.path,
            _simple(points),
            self.label(wire),
            wire.initial and wire.source.type != "history",
            f"{wire.source.path or self.graph.name} → {wire.target.path}\n{told}".strip(),
        )

    def label(self, wire: Wire) -> Label | None:
        if not wire.edges:
            return None
        inside = self.insides[wire.sections[0].inside]
        item, (dx, dy) = inside.labels[wire], self.origins[wire.sections[0].inside]
        width = max(text_width(line, LABEL_SIZE) for line in item.text)
        x, y = dx + PAD + item.x + BESIDE, dy + item.y
        return Label(x, y, width, LINE_HEIGHT * len(item.text), item.text)

    def separators(self, node: Node) -> list[tuple[XY, XY]]:
        if node.type != "parallel":
            return []
        regions = [child for child in node.children if child.type != "history"]
        regions.sort(key=lambda child: self.origins[child])
        found = []
        for one, two in pairwise(regions):
            x = (self.origins[one][0] + self.insides[one].width + self.origins[two][0]) / 2
            top = self.origins[one][1]
            found.append(((x, top), (x, top + self.insides[one].height)))
        return found


def _name(graph: Graph, node: Node) -> str:
    if node.type == "history":
        return "H*" if node.deep else "H"
    return node.local_name if node.parent else graph.name


def _simple(points: list[XY]) -> tuple[XY, ...]:
    """The points where a line turns, and its ends."""
    found: list[XY] = []
    for point in points:
        if found and point == found[-1]:
            continue
        if len(found) > 1 and (
            found[-2][0] == found[-1][0] == point[0] or found[-2][1] == found[-1][1] == point[1]
        ):
            found[-1] = point
        else:
            found.append(point)
    return tuple(found)
