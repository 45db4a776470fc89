"""A conformance case in a neutral form, from which other engines' charts are made.

Imports nothing of ours: it is run in an environment that has the other engines only. It reads the
part of SCXML that the cases use, and translates their ECMAScript expressions to Python.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

PYTHON = {"!In(": "not In(", "Math.pow(": "pow(", "!==": "!=", "===": "==", "&&": "and"}
STATES = ("state", "parallel", "final", "history")


class CannotError(Exception):
    """An engine cannot express a case."""


@dataclass
class Move:
    """A transition."""

    events: list[str]
    """None: taken without an event."""
    targets: list[str]
    guard: str
    action: list[str]
    """Lines of Python."""
    internal: bool


@dataclass
class State:
    id: str
    kind: str
    deep: bool
    path: tuple[str, ...]
    """From the root, this state included."""
    children: list[State] = field(default_factory=list)
    initial: list[str] = field(default_factory=list)
    moves: list[Move] = field(default_factory=list)
    entry: list[str] = field(default_factory=list)
    exit: list[str] = field(default_factory=list)

    def all(self) -> Iterator[State]:
        yield self
        for child in self.children:
            yield from child.all()


@dataclass
class Case:
    root: State
    data: list[str]
    """Lines that give the variables their first values."""
    initial: list[str]
    events: list[dict[str, Any]]

    @property
    def states(self) -> dict[str, State]:
        return {state.id: state for state in self.root.all()}

    @property
    def by_prefix(self) -> bool:
        """Whether some transition matches an event of the case by a prefix of its name."""
        heard = {name for state in self.root.all() for move in state.moves for name in move.events}
        said = {step["event"]["name"] for step in self.events}
        return any("*" in name or any(e.startswith(name + ".") for e in said) for name in heard)


def read_case(path: Path) -> Case:
    expected = json.loads(path.with_suffix(".json").read_text())
    element = ElementTree.parse(path).getroot()
    data = [
        f"{each.get('id')} = {python(each.get('expr') or 'None')}"
        for each in element.iter()
        if _tag(each) == "data"
    ]
    root = _state(element, ())
    return Case(root, data, expected["initialConfiguration"], expected["events"])


def python(expression: str | None) -> str:
    text = expression or ""
    for word, instead in PYTHON.items():
        text = text.replace(word, instead)
    return {"true": "True", "false": "False"}.get(text.strip(), text.strip())


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _state(element: ElementTree.Element, around: tuple[str, ...]) -> State:
    name = element.get("id") or f"_{'_'.join((*around, 'root'))}"
    kind = _tag(element) if _tag(element) in STATES else "state"
    state = State(name, kind, element.get("type") == "deep", (*around, name))
    state.initial = (element.get("initial") or "").split()
    for child in element:
        match _tag(child):
            case "transition":
                state.moves.append(_move(child))
            case "onentry":
                state.entry += _lines(child)
            case "onexit":
                state.exit += _lines(child)
            case "initial":
                state.initial = (child[0].get("target") or "").split()
            case tag if tag in STATES:
                state.children.append(_state(child, state.path))
    if not state.initial and state.children and kind == "state":
        state.initial = [next(c.id for c in state.children if c.kind != "history")]
    return state


def _move(element: ElementTree.Element) -> Move:
    return Move(
        (element.get("event") or "").split(),
        (element.get("target") or "").split(),
        python(element.get("cond")),
        _lines(element),
        element.get("type") == "internal",
    )


def _lines(block: ElementTree.Element, pad: str = "") -> list[str]:
    found: list[str] = []
    for each in block:
        match _tag(each):
            case "assign":
                found.append(f"{pad}{each.get('location')} = {python(each.get('expr'))}")
            case "raise":
                found.append(f"{pad}Raise({each.get('event')!r})")
            case "send":
                delay = (each.get("delay") or "0ms").removesuffix("ms")
                found.append(f"{pad}Send({each.get('event')!r}, {delay})")
            case "if":
                found += _branches(each, pad)
            case "foreach":
                index = each.get("index") or "_index"
                values = f"enumerate({each.get('array')})"
                found.append(f"{pad}for {index}, {each.get('item')} in {values}:")
                found += [*_lines(each, pad + " "), f"{pad} pass"]
            case "script":
                found += [pad + line.strip().rstrip(";") for line in (each.text or "").splitlines()]
    return [line for line in found if line.strip()]


def _branches(block: ElementTree.Element, pad: str) -> list[str]:
    """The lines of an ``if``, whose branches are separated by empty elements."""
    found = [f"{pad}if {python(block.get('cond'))}:"]
    for each in block:
        if _tag(each) == "elseif":
            found += [f"{pad} pass", f"{pad}elif {python(each.get('cond'))}:"]
        elif _tag(each) == "else":
            found += [f"{pad} pass", f"{pad}else:"]
        else:
            holder = ElementTree.Element("block")
            holder.append(each)
            found += _lines(holder, pad + " ")
    return [*found, f"{pad} pass"]


class Data:
    """The variables of a running case, with what its lines may call."""

    def __init__(
        self,
        case: Case,
        is_active: Callable[[str], bool],
        say: Callable[[str, float], None],
    ) -> None:
        """``say`` raises an event, after a delay in milliseconds."""
        self.names: dict[str, Any] = {"In": is_active, "Send": say, "_sessionid": "s"}
        self.names["Raise"] = lambda event: say(event, 0)
        self.run(case.data)

    def run(self, lines: list[str]) -> None:
        exec("\n".join(lines), self.names)

    def test(self, guard: str) -> bool:
        return not guard or eval(guard, self.names) is True
