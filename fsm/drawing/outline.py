"""A graph as an indented text."""

from __future__ import annotations

from collections.abc import Iterator

from fsm.chart.graph import Graph, Node
from fsm.drawing.labels import action_text, blocks, doing, edge_text
from fsm.language.keys import AT


def write_text(graph: Graph) -> str:
    """The tree of states with what each does and where it leads; ``>`` marks initial states."""
    head = f"{graph.name}: {graph.description}" if graph.description else graph.name
    return "\n".join([head, *_node(graph.root, 0)]) + "\n"


def _node(node: Node, depth: int) -> Iterator[str]:
    indent = "  " * depth
    if node.parent is not None:
        initial = node.parent.type == "compound" and node in node.parent.initial
        type_ = "" if node.type in ("atomic", "compound") else f" ({_type(node)})"
        yield f"{indent}{'> ' if initial else ''}{node.local_name}{type_}"
    indent += "    "
    if node.invocation:
        given = {**node.invocation.with_, **node.invocation.live}
        names = f" ({', '.join(given)})" if given else ""
        yield f"{indent}{doing(node)}{names}"
    for word, actions in blocks(node):
        for action in actions:
            yield f"{indent}{word}: {action_text(action)}"
    for edge in node.edges():
        targets = ", ".join(_name(node, target) for target in edge.targets)
        yield f"{indent}{edge_text(edge)}{f' -> {targets}' if targets else ''}"
    if node.type == "history":
        yield f"{indent}the first time -> {', '.join(_name(node, t) for t in node.initial)}"
    for child in node.children:
        yield from _node(child, depth + 1)


def _type(node: Node) -> str:
    if node.type == "history":
        return "deep history" if node.deep else "history"
    if node.type == "final" and node.outcome != "done":
        return f"final, {AT['final']['outcome'].label} {node.outcome}"
    return node.type


def _name(source: Node, target: Node) -> str:
    """The name of a target: short for a sibling, else its path."""
    return target.local_name if target.parent is source.parent else target.path or "the mission"
