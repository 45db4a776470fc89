"""Random nested graphs with transitions of every kind, as mission files."""

from __future__ import annotations

from random import Random
from typing import Any

from fsm import Graph, Vocabulary, compile_mission, read_mission_text

EVENTS = ("a.x", "b.long_name_of_an_event", "c.y")
VOCABULARY = Vocabulary(behaviors={}, events={event: {} for event in EVENTS})


def random_graph(seed: int, states: int) -> Graph:
    """A graph of about this many states that compiles."""
    return compile_mission(read_mission_text(random_mission(seed, states), "m.yaml"), VOCABULARY)


def random_mission(seed: int, states: int) -> str:
    random = Random(seed)
    paths: list[str] = []
    root = _state(random, "", states, paths, 0)
    lines = ["mission: random", *_lines(root, paths, random, "")]
    return "\n".join(lines) + "\n"


def _state(random: Random, path: str, states: int, paths: list[str], depth: int) -> dict[str, Any]:
    node: dict[str, Any] = {"path": path, "children": [], "type": ""}
    if states <= 1 or depth > 5:
        node["type"] = "final" if path and random.random() < 0.1 else ""
        if depth <= 5 or states <= 1:
            return node
    parallel = depth > 0 and states >= 3 and random.random() < 0.2
    node["type"] = "parallel" if parallel else ""
    left, index = states, 0
    while left > 0:
        size = min(left, 1 if random.random() < 0.6 else random.randint(1, max(1, left // 2)))
        name = f"{random.choice('stuvwxyz')}{len(paths)}{'_longer' * random.randint(0, 1)}"
        inner = f"{path}.{name}" if path else name
        paths.append(inner)
        node["children"].append(_state(random, inner, size if index else 1, paths, depth + 1))
        left -= size + 1 if size > 1 else 1
        index += 1
    if parallel and len(node["children"]) < 2:
        node["type"] = ""
    for region in node["children"] if node["type"] else ():
        region["type"] = "" if region["type"] == "final" else region["type"]
    first = node["children"][0]
    first["type"] = "" if first["type"] == "final" else first["type"]
    node["history"] = not node["type"] and path and random.random() < 0.3
    return node


def _lines(node: dict[str, Any], paths: list[str], random: Random, indent: str) -> list[str]:
    lines = []
    if node["type"]:
        lines.append(f"{indent}type: {node['type']}")
    if node["type"] != "final":
        lines += _transitions(node, paths, random, indent)
    if node["children"]:
        lines.append(f"{indent}states:")
        for child in node["children"]:
            name = child["path"].rpartition(".")[2]
            body = _lines(child, paths, random, indent + "    ")
            lines += [f"{indent}  {name}:", *body] if body else [f"{indent}  {name}: {{}}"]
        if node.get("history"):
            target = node["children"][0]["path"].rpartition(".")[2]
            lines.append(
                f"{indent}  back{node['path'].count('.')}{len(paths)}: "
                f"{{type: history, target: {target}}}"
            )
    return lines


def _transitions(node: dict[str, Any], paths: list[str], random: Random, indent: str) -> list[str]:
    lines = []
    # A state that nothing leaves is refused.
    events = [event for event in EVENTS if random.random() < 0.5] or ["a.x"]
    if node["path"] and any(child["type"] == "final" for child in node["children"]):
        events.append("done")
    for kind, keys in (("on", events), ("after", ["5 s"] if random.random() < 0.2 else [])):
        body = []
        for index, key in enumerate(keys):
            others = [path for path in paths if not path.startswith(node["path"])]
            target = random.choice((not index and others) or paths)
            reenter = ", reenter: true"
            guard = (
                ", guard: time_in_state > 3 s" if random.random() < 0.3 and key != "done" else ""
            )
            body.append(f"{indent}  {key}: {{target: {target}{reenter}{guard}}}")
        if body:
            lines += [f"{indent}{kind}:", *body]
    return lines
