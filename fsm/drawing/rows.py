"""The inside of one state as rows of items and the lines between them.

Row 0 holds the state's heading and the ports where lines come in through its upper border, row 1
labels, row 2 the first layer of states, row 3 labels, …, the last row the ports of its lower
border. A line that passes a row has a dummy item there. Lines leave states downwards and enter them
from above; a line to a state further up turns below its source and rises beside it. Lines to the
same target are bundled. Layered drawing after Sugiyama, Tagawa and Toda (1981).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field
from typing import Literal

from fsm.chart.graph import Node

ItemKind = Literal["head", "dot", "box", "label", "dummy", "port"]
ItemKey = Hashable
MARGINS: dict[ItemKind, float] = {
    "head": 10.0, "dot": 10.0, "box": 14.0, "label": 7.0, "dummy": 3.0, "port": 4.0,
}  # fmt: skip
LINE_WIDTH = 14.0
"""The width that a line needs."""


@dataclass(eq=False, slots=True)
class Item:
    """An item in a row. ``x`` is that of its line, which is ``anchor`` right of its left edge."""

    kind: ItemKind
    row: int
    width: float = LINE_WIDTH
    height: float = 0.0
    anchor: float = LINE_WIDTH / 2
    node: Node | None = None
    text: tuple[str, ...] = ()
    stop: bool = False
    """For a port: the line begins or ends at the border instead of crossing it."""
    x: float = 0.0
    y: float = 0.0
    place: float = 0.0
    above: dict[ItemKey, float] = field(default_factory=dict)
    """For a state: the x of the ports in its upper border, from its middle."""
    below: dict[ItemKey, float] = field(default_factory=dict)

    @property
    def left(self) -> float:
        return self.x - self.anchor


def gap(one: Item, two: Item) -> float:
    """The least distance between the x of two neighbours."""
    return one.width - one.anchor + MARGINS[one.kind] + MARGINS[two.kind] + two.anchor


Terminal = tuple[Item, bool]
"""An item, and whether its upper side is meant."""


@dataclass(eq=False, slots=True)
class Bundle:
    """Lines to the same target that are joined in one channel; all of them lead to ``sink``."""

    channel: int
    key: ItemKey
    terminals: list[Terminal] = field(default_factory=list)
    sink: Terminal | None = None


class Rows:
    """The items of a state in rows, and the lines between them."""

    def __init__(self, layers: int) -> None:
        self.rows: list[list[Item]] = [[] for _ in range(2 * layers + 3)]
        self.bundles: dict[tuple[int, ItemKey], Bundle] = {}
        self.leaving: dict[tuple[Item, bool, ItemKey], Bundle] = {}
        """The bundle of a line that leaves a terminal; its key tells the lines of a state apart."""
        self._found: dict[tuple[int, ItemKey], Item] = {}

    @property
    def last(self) -> int:
        return len(self.rows) - 1

    def add(self, item: Item) -> Item:
        self.rows[item.row].append(item)
        return item

    def port(self, row: int, key: ItemKey, stop: bool) -> Item:
        found = self._found.get((row, key))
        if found is None:
            found = self._found[row, key] = self.add(Item("port", row))
        found.stop = found.stop or stop
        return found

    def _dummy(self, row: int, key: ItemKey) -> Item:
        found = self._found.get((row, key))
        if found is None:
            found = self._found[row, key] = self.add(Item("dummy", row))
        return found

    def _join(
        self, channel: int, key: ItemKey, source: Terminal, sink: Terminal, name: ItemKey
    ) -> None:
        """Join two terminals in a channel; ``name`` is the line's key at its source."""
        bundle = self.bundles.get((channel, key))
        if bundle is None:
            bundle = self.bundles[channel, key] = Bundle(channel, key)
        for terminal in (source, sink):
            if terminal not in bundle.terminals:
                bundle.terminals.append(terminal)
        bundle.sink = sink
        self.leaving[source[0], source[1], name] = bundle

    def connect(
        self, source: Item, out: ItemKey, sink: Item, key: ItemKey, label: Item | None
    ) -> None:
        """Lead a line from a source, where its key is ``out``, to a sink, where it is ``key``."""
        if source.row < sink.row:
            self._down(source, out, sink, key, label)
        else:
            self._up(source, out, sink, key, label)

    def _down(
        self, source: Item, out: ItemKey, sink: Item, key: ItemKey, label: Item | None
    ) -> None:
        place, name = source, out
        for row in range(source.row + 1, sink.row):
            if label is not None and row == source.row + 1:
                label.row = row
                self._join(row, out, (place, False), (self.add(label), True), name)
                place = label
            else:
                dummy = self._dummy(row, key)
                self._join(row, key, (place, False), (dummy, True), name)
                place = dummy
            name = key
        self._join(sink.row, key, (place, False), (sink, True), name)

    def _up(self, source: Item, out: ItemKey, sink: Item, key: ItemKey, label: Item | None) -> None:
        row = source.row
        if label is not None:
            label.row = row
            place = self.add(label)
            self._join(row + 1, out, (source, False), (place, False), out)
        else:
            place = self._dummy(row, key)
            self._join(row + 1, key, (source, False), (place, False), out)
        for above in range(row - 1, sink.row - 1, -1):
            dummy = self._dummy(above, key)
            self._join(above + 1, key, (place, True), (dummy, False), key)
            place = dummy
        self._join(sink.row, key, (place, True), (sink, True), key)


def layers_of(
    children: list[Node], initial: Iterable[Node], pairs: set[tuple[int, int]]
) -> list[int]:
    """The layer of each child: the longest path from the initial one, back edges left out.

    ``pairs`` are the transitions, as indices into ``children``.
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
    """Reverse postorder of a depth-first search; edges that lead backwards in it close a cycle."""
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
