"""A graph in Graphviz' language, states inside states as clusters."""

from __future__ import annotations

from collections.abc import Iterator

from fsm.chart.graph import Graph, Node
from fsm.drawing.labels import edge_label, node_lines, stays


def write_dot(graph: Graph) -> str:
    """The graph for the program ``dot``."""
    lines = [
        f"digraph {_quoted(graph.name)} {{",
        '  compound=true; fontname="Helvetica"; node [shape=box, style=rounded, '
        'fontname="Helvetica"]; edge [fontname="Helvetica", fontsize=10];',
        *_state(graph.root, "  "),
    ]
    for node in graph.nodes:
        if node.type == "history":
            lines.extend(_edge(node, target, "") for target in node.initial)
        for edge in node.edges():
            if not stays(edge):
                lines.extend(_edge(node, target, edge_label(edge)) for target in edge.targets)
    return "\n".join([*lines, "}"]) + "\n"


def _id(node: Node) -> str:
    return f"s{node.index}"


def _text(node: Node) -> str:
    return _quoted("\n".join([node.local_name, *node_lines(node)]))


def _state(node: Node, indent: str) -> Iterator[str]:
    if node.type == "history":
        yield f'{indent}{_id(node)} [shape=circle, label="{"H*" if node.deep else "H"}"];'
    elif not node.children:
        double = ", peripheries=2" if node.type == "final" else ""
        yield f"{indent}{_id(node)} [label={_text(node)}{double}];"
    else:
        yield f"{indent}subgraph cluster_{_id(node)} {{"
        inside = indent + "  "
        style = "dashed" if node.parent and node.parent.type == "parallel" else "rounded"
        yield f"{inside}label={_text(node)}; style={style};"
        # Lines to and from a cluster need a node in it: this one is also where it begins.
        yield f'{inside}{_id(node)} [shape=point, label=""];'
        for child in node.children:
            yield from _state(child, inside)
        if node.type == "compound":
            yield from (f"{inside}{_id(node)} -> {_id(target)};" for target in node.initial)
        yield f"{indent}}}"


def _edge(source: Node, target: Node, label: str) -> str:
    options = [f"label={_quoted(label)}"] if label else []
    # Graphviz cannot clip at a cluster that holds the other end.
    if source.children and not (source is target or source.contains(target)):
        options.append(f"ltail=cluster_{_id(source)}")
    if target.children and not (source is target or target.contains(source)):
        options.append(f"lhead=cluster_{_id(target)}")
    told = f" [{', '.join(options)}]" if options else ""
    return f"  {_id(source)} -> {_id(target)}{told};"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
