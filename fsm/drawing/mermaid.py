"""A graph in Mermaid's language, ``stateDiagram-v2``."""

from __future__ import annotations

from collections.abc import Iterator

from fsm.chart.graph import Graph, Node
from fsm.drawing.labels import edge_label, node_lines, stays

_OTHERS = str.maketrans('";#:{}<>\\', "',＃∶()＜＞＼")


def write_mermaid(graph: Graph) -> str:
    """The graph as a state diagram; internal transitions stand in the box of their state."""
    lines = ["---", f'title: "{_plain(graph.name)}"', "---", "stateDiagram-v2"]
    for child in graph.root.children:
        lines.extend(_state(child, "  "))
    lines.extend(_start(graph.root, "  "))
    for node in graph.nodes:
        lines.extend(_edges(node))
    return "\n".join(lines) + "\n"


def _id(node: Node) -> str:
    return f"s{node.index}"


def _state(node: Node, indent: str) -> Iterator[str]:
    name = ("H*" if node.deep else "H") if node.type == "history" else node.local_name
    text = "\\n".join(map(_plain, [name, *node_lines(node)]))
    yield f'{indent}state "{text}" as {_id(node)}'
    if not node.children:
        return
    yield f"{indent}state {_id(node)} {{"
    for index, child in enumerate(node.children):
        if index and node.type == "parallel" and child.type != "history":
            yield f"{indent}  --"
        yield from _state(child, indent + "  ")
    yield from _start(node, indent + "  ")
    yield f"{indent}}}"


def _start(node: Node, indent: str) -> Iterator[str]:
    if node.type == "compound":
        yield from (f"{indent}[*] --> {_id(target)}" for target in node.initial)
    for child in node.children:
        if child.type == "final":
            yield f"{indent}{_id(child)} --> [*]"


def _edges(node: Node) -> Iterator[str]:
    if node.type == "history":
        yield from (f"  {_id(node)} --> {_id(target)}" for target in node.initial)
    for edge in node.edges():
        if not stays(edge) and node.parent is not None:
            text = _plain(edge_label(edge))
            for target in edge.targets:
                yield f"  {_id(node)} --> {_id(target)}{f': {text}' if text else ''}"
        elif not stays(edge):
            # The whole diagram is no state there, so its transitions are told in a note.
            targets = ", ".join(target.path for target in edge.targets)
            first = node.children[0]
            yield f"  note right of {_id(first)}: anywhere, {_plain(edge_label(edge))} → {targets}"


def _plain(text: str) -> str:
    """The text in one line, with look-alikes for the letters that have a meaning in Mermaid."""
    return " ".join(text.split()).translate(_OTHERS)
