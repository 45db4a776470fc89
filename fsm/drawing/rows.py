"""The inside of one state as rows of things and the lines between them.

Row 0 holds the state's heading and the ports where lines come in through its upper border, row 1
labels, row 2 the first states, row 3 labels, …, the last one the ports of its lower border. Lines
run from row to row: they leave states downwards and enter them from above. A line that must go up
again turns below its source and rises beside it. Lines to the same target join on their way.
After Sugiyama, Tagawa and Toda (1981).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field
from typing import Literal

from fsm.chart.graph import Node

Kind = Literal["head", "dot", "box", "label", "way", "port"]
Key = Hashable
MARGINS: dict[Kind, float] = {
    "head": 10.0, "dot": 10.0, "box": 14.0, "label": 7.0, "way": 3.0, "port": 4.0,
}  # fmt: skip
WAY = 14.0
"""Width that a line needs."""


@dataclass(eq=False, slots=True)
class Item:
    """A thing in a row. ``x`` is where its line runs, ``anchor`` to the right of its left edge."""

    kind: Kind
    row: int
    width: float = WAY
    height: float = 0.0
    anchor: float = WAY / 2
    node: Node | None = None
    text: tuple[str, ...] = ()
    stop: bool = False
    """Of ports: the line begins or ends here, at the border."""
    x: float = 0.0
    y: float = 0.0
    place: float = 0.0
    above: dict[Key, float] = field(default_factory=dict)
    """Of states: where lines enter, from the middle."""
    below: dict[Key, float] = field(default_factory=dict)

    @property
    def left(self) -> float:
        return self.x - self.anchor


def gap(one: Item, two: Item) -> float:
    """How far apart the lines of neighbours are at least."""
    return one.width - one.anchor + MARGINS[one.kind] + MARGINS[two.kind] + two.anchor


Terminal = tuple[Item, bool]
"""An item and whether its upper side is meant."""


@dataclass(eq=False, slots=True)
class Wires:
    """What is joined in one channel; all lines in it leave through ``sink``."""

    channel: int
    key: Key
    terminals: list[Terminal] = field(default_factory=list)
    sink: Terminal | None = None


class Rows:
    """Items in rows, and what joins them."""

    def __init__(self, layers: int) -> None:
        self.rows: list[list[Item]] = [[] for _ in range(2 * layers + 3)]
        self.wires: dict[tuple[int, Key], Wires] = {}
        self.leaving: dict[tuple[Item, bool, Key], Wires] = {}
        """The way on from a terminal; the key tells the lines of a state apart."""
        self._ways: dict[tuple[int, Key], Item] = {}

    @property
    def last(self) -> int:
        return len(self.rows) - 1

    def add(self, item: Item) -> Item:
        self.rows[item.row].append(item)
        return item

    def port(self, row: int, key: Key, stop: bool) -> Item:
        found = self._ways.get((row, key))
        if found is None:
            found = self._ways[row, key] = self.add(Item("port", row))
        found.stop = found.stop or stop
        return found

    def _way(self, row: int, key: Key) -> Item:
        found = self._ways.get((row, key))
        if found is None:
            found = self._ways[row, key] = self.add(Item("way", row))
        return found

    def _join(self, channel: int, key: Key, source: Terminal, sink: Terminal, name: Key) -> None:
        """``name`` is what the source calls this line, where several leave it."""
        wires = self.wires.get((channel, key))
        if wires is None:
            wires = self.wires[channel, key] = Wires(channel, key)
        for terminal in (source, sink):
            if terminal not in wires.terminals:
                wires.terminals.append(terminal)
        wires.sink = sink
        self.leaving[source[0], source[1], name] = wires

    def connect(self, source: Item, out: Key, sink: Item, key: Key, label: Item | None) -> None:
        """Lead a line called ``out`` from a source to a sink, where it is called ``key``."""
        if source.row < sink.row:
            self._down(source, out, sink, key, label)
        else:
            self._up(source, out, sink, key, label)

    def _down(self, source: Item, out: Key, sink: Item, key: Key, label: Item | None) -> None:
        place, name = source, out
        for row in range(source.row + 1, sink.row):
            if label is not None and row == source.row + 1:
                label.row = row
                self._join(row, out, (place, False), (self.add(label), True), name)
                place = label
            else:
                way = self._way(row, key)
                self._join(row, key, (place, False), (way, True), name)
                place = way
            name = key
        self._join(sink.row, key, (place, False), (sink, True), name)

    def _up(self, source: Item, out: Key, sink: Item, key: Key, label: Item | None) -> None:
        row = source.row
        if label is not None:
            label.row = row
            place = self.add(label)
            self._join(row + 1, out, (source, False), (place, False), out)
        else:
            place = self._way(row, key)
            self._join(row + 1, key, (source, False), (place, False), out)
        for above in range(row - 1, sink.row - 1, -1):
            way = self._way(above, key)
            self._join(above + 1, key, (place, True), (way, False), key)
            place = way
        self._join(sink.row, key, (place, True), (sink, True), key)


def layers_of(
    children: list[Node], initial: Iterable[Node], pairs: set[tuple[int, int]]
) -> list[int]:
    """The layer of each child: the longest way from where it begins, ways back apart.

    ``pairs`` are indices into ``children``.
    """
    following: list[list[int]] = [[] for _ in children]
    for source, target in sorted(pairs):
        following[source].append(target)
    first = [children.index(node) for node in initial if node in children]
    order = _finished([*first, *range(len(children))], following)
    rank = {child: index for index, child in enumerate(order)}
    layers = [0] * len(children)
    for child in order:
        for target in following[child]:
            if rank[target] > rank[child]:
                layers[target] = max(layers[target], layers[child] + 1)
    return layers


def _finished(starts: list[int], following: list[list[int]]) -> list[int]:
    """Depth first, the last finished first: whatever leads backwards in it closes a circle."""
    seen: set[int] = set()
    done: list[int] = []
    for start in starts:
        if start in seen:
            continue
        seen.add(start)
        stack = [(start, iter(following[start]))]
        while stack:
            child, rest = stack[-1]
            target = next((other for other in rest if other not in seen), None)
            if target is None:
                stack.pop()
                done.append(child)
            else:
                seen.add(target)
                stack.append((target, iter(following[target])))
    return done[::-1]
