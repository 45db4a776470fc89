"""The states of a mission as the lines of a tree, the active ones always in sight."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from itertools import pairwise

from rich.text import Text

from cli.narrator import behavior_of
from fsm import Node
from fsm.engine.instance import Instance

_ROWS_FOR_GAPS = 6
"""With fewer rows, no row says how many states are left out."""


def draw_tree(instance: Instance, last: str, columns: int, rows: int) -> list[Text]:
    """At most so many rows, each as wide as ``columns``.

    Where the states need more, those stay that are active and what stands around them. ``last`` is
    the path of the state entered last, which takes their part when the mission has ended.
    """
    nodes = [node for node in instance.graph.nodes[1:] if node.type != "history"]
    if len(nodes) <= rows:
        return [_branch(instance, last, node, columns) for node in nodes]
    active = instance.active or [
        n for n in nodes if n.path == last or last.startswith(f"{n.path}.")
    ]
    wanted = _by_nearness(nodes, active)
    for count in range(rows, 0, -1):
        chosen = sorted(wanted[:count])
        gaps = _gaps(chosen, len(nodes)) if rows >= _ROWS_FOR_GAPS else {}
        if len(chosen) + len(gaps) <= rows:
            break
    lines: list[Text] = []
    for number, k in enumerate([*chosen, len(nodes)]):
        if number in gaps:
            lines.append(_cut(Text(f"⋮ {gaps[number]} more", "dim"), columns))
        if k < len(nodes):
            lines.append(_branch(instance, last, nodes[k], columns))
    return lines


def time_in_state(instance: Instance, node: Node) -> float:
    """Seconds since an active state was entered."""
    entered: float = instance.slots[node.entered_slot]
    return instance.now - entered


def _by_nearness(nodes: Sequence[Node], active: Sequence[Node]) -> list[int]:
    """The numbers of these states: active ones, inner ones first, then by the distance from them
    in the order of the file.
    """
    indices = {node.index for node in active}
    leaves = [k for k, node in enumerate(nodes) if node.index in indices and not node.children]

    def rank(k: int) -> tuple[int, int]:
        node = nodes[k]
        if node.index in indices:
            return (0, 0) if not node.children else (1, -len(node.ancestors))
        after = bisect(leaves, k)
        near = [abs(k - leaf) for leaf in leaves[max(0, after - 1) : after + 1]]
        return 2, min(near, default=k)

    return sorted(range(len(nodes)), key=rank)


def _gaps(chosen: Sequence[int], count: int) -> dict[int, int]:
    """Index in ``chosen`` → the number of states left out before it; at its end, behind it."""
    ends = [-1, *chosen, count]
    left_out = (after - before - 1 for before, after in pairwise(ends))
    return {k: number for k, number in enumerate(left_out) if number}


def _branch(instance: Instance, last: str, node: Node, columns: int) -> Text:
    # A deep state keeps two thirds of the row for its name.
    indent = " " * min(2 * (len(node.ancestors) - 1), columns // 3)
    active = instance.is_active(node.path)
    leaf = active and not node.children
    mark, style = ("▶", "bold green") if leaf else ("▾", "green") if active else ("·", "dim")
    if instance.ended and node.path == last:
        mark, style = "■", "bold"
    behavior = behavior_of(instance.graph, node.path)
    parts = [(f"{indent}{mark} {node.local_name}", style)]
    if behavior:
        parts.append((f"  {behavior}", "dim italic"))
    if leaf:
        parts.append((f"  {time_in_state(instance, node):.1f} s", "green"))
    return _cut(Text.assemble(*parts), columns)


def _cut(text: Text, columns: int) -> Text:
    text.truncate(columns, overflow="ellipsis", pad=True)
    return text
