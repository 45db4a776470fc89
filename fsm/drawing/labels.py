"""The texts of a diagram: states, transitions and actions, in full and shortened."""

from __future__ import annotations

from fsm.chart.executable import Action
from fsm.chart.graph import Edge, Node
from fsm.language.keys import AT
from vencejo import nodes

SHORT = 34
"""The most letters in one line of a diagram."""


def shortened(text: str, limit: int = SHORT) -> str:
    """The text in one line, cut with an ellipsis where it is too long."""
    line = " ".join(text.split())
    return line if len(line) <= limit else line[: limit - 1].rstrip() + "…"


def flow(node: nodes.YamlNode | None) -> str:
    """A YAML value in one line, as it would stand in flow style."""
    match node:
        case nodes.Mapping():
            return "{" + ", ".join(f"{key.text}: {flow(value)}" for key, value in node) + "}"
        case nodes.Sequence():
            return "[" + ", ".join(flow(item) for item in node.items) + "]"
        case nodes.Scalar():
            return node.text
        case _:
            return ""


def action_text(action: Action) -> str:
    """An action in full: ``set {seen: true}``."""
    return f"{action.kind} {flow(action.node)}".strip()


def action_word(action: Action) -> str:
    """An action in brief: what it does and to what, without values."""
    match action.node:
        case nodes.Mapping() as body if action.kind == "send":
            return f"send {flow(body.get('event'))}"
        case nodes.Mapping() as body:
            return f"{action.kind} {', '.join(key.text for key, _ in body)}"
        case nodes.Scalar(text=text) if action.kind != "log":
            return f"{action.kind} {text}"
        case _:
            return action.kind


def blocks(node: Node) -> tuple[tuple[str, tuple[Action, ...]], ...]:
    """The action blocks of a state with the words for them, in the order in which they run."""
    key = AT["state"]
    return (
        (key["entry"].label, node.entry),
        (key["throughout"].label, node.throughout),
        (key["exit"].label, node.exit_actions),
    )


def doing(node: Node) -> str:
    """The behaviour that runs while a state is active; empty where there is none."""
    return f"{AT['state']['do'].label} {node.invocation.behavior.name}" if node.invocation else ""


def cause(edge: Edge) -> str:
    """The event, outcome, condition or duration of a transition, after the word of its key."""
    if edge.kind == "always" and edge.guard:
        return ""
    trigger = "" if edge.kind == "always" else edge.trigger
    hold = f"{AT['transition']['for'].label} {edge.hold.source}" if edge.hold else ""
    return " ".join(part for part in (AT["state"][edge.kind].label, trigger, hold) if part)


def edge_text(edge: Edge) -> str:
    """A transition in full, without its target."""
    guard = f"[{edge.guard.source}]" if edge.guard else ""
    actions = "; ".join(action_text(action) for action in edge.actions)
    parts = (cause(edge), guard, f"/ {actions}" if actions else "")
    return " ".join(part for part in parts if part)


def edge_label(edge: Edge) -> str:
    """A transition in one line of a diagram: its parts are shortened before the whole is."""
    guard = f"[{shortened(edge.guard.source, 22)}]" if edge.guard else ""
    actions = ", ".join(action_word(action) for action in edge.actions)
    parts = (
        shortened(edge.label or cause(edge), 28),
        guard,
        f"/ {shortened(actions, 20)}" if actions else "",
    )
    return shortened(" ".join(part for part in parts if part), 44)


def edges_label(edges: tuple[Edge, ...]) -> tuple[str, ...]:
    """The label of transitions with the same source and target, as lines of text.

    Transitions without guard, actions and name share a line, the others have one each.
    """
    lines: list[str] = []
    plain = False
    for edge in edges:
        text = edge_label(edge)
        bare = edge.kind == "on" and not edge.guard and not edge.actions and not edge.label
        if bare and plain and len(lines[-1]) + len(text) + 2 <= SHORT:
            lines[-1] += f", {text}"
        else:
            lines.append(text)
        plain = bare
    return tuple(lines)


def node_lines(node: Node) -> tuple[str, ...]:
    """The lines in the box of a state: behaviour, actions, outcome and internal transitions."""
    lines = [doing(node)] if node.invocation else []
    for word, actions in blocks(node):
        if actions:
            lines.append(shortened(f"{word} / " + ", ".join(map(action_word, actions))))
    if node.type == "final" and node.outcome != "done":
        lines.append(f"{AT['final']['outcome'].label} {node.outcome}")
    lines.extend(edge_label(edge) for edge in node.edges() if stays(edge))
    return tuple(lines)


def stays(edge: Edge) -> bool:
    """Whether a transition stands in the box of its state: it leaves no state, or is the root's."""
    root = edge.node.parent is None
    return not edge.targets or (root and edge.targets == (edge.node,))


def node_title(node: Node) -> str:
    """The full text of a state, which viewers show where the pointer is."""
    lines = [node.path or node.local_name, node.description, doing(node)]
    for word, actions in blocks(node):
        lines.extend(f"{word}: {action_text(action)}" for action in actions)
    lines.extend(edge_text(edge) for edge in node.edges() if stays(edge))
    return "\n".join(line for line in lines if line)
