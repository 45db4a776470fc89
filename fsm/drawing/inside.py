"""Lays out one state: its own text, the states in it, and the lines between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil

from fsm.chart.graph import Node
from fsm.drawing.arrangement import BORDER, PORT_GAP, arrange
from fsm.drawing.channels import Net, route
from fsm.drawing.diagram import XY
from fsm.drawing.labels import edges_label, node_lines
from fsm.drawing.rows import Bundle, Item, ItemKey, Rows, Terminal, layers_of
from fsm.drawing.widths import text_width
from fsm.drawing.wiring import LineSection, Wire, toward

NAME_SIZE, LINE_SIZE, LABEL_SIZE = 13.0, 11.0, 11.0
NAME_HEIGHT, LINE_HEIGHT = 18.0, 15.0
PAD = 14.0
TRACK = 8.0
ARROW = 16.0
"""Height below the last track, for a corner and an arrowhead."""
DOT = 10.0
HISTORY = 26.0
BESIDE = 6.0
"""Pixels from a line to its label."""


@dataclass(eq=False)
class Inside:
    """The size of a state and the coordinates of all in it, from its upper left corner."""

    node: Node
    name: str
    lines: tuple[str, ...]
    width: float
    height: float
    rows: Rows
    items: dict[Node, Item]
    """The boxes of its children."""
    starts: dict[ItemKey, Item]
    """The items where lines begin: ports of the upper border, initial dots."""
    ends: dict[ItemKey, Item]
    """The ports of the lower border, where lines end."""
    labels: dict[Wire, Item]
    nets: dict[Bundle, tuple[Net, float]]
    """The tracks of each bundle, and the y of the first track of its channel."""
    tops: list[float]
    bottoms: list[float]
    """The upper and lower y of each row."""

    def at(self, terminal: Terminal, key: ItemKey) -> XY:
        """The point where a line meets an item."""
        item, top = terminal
        x = _x(item, top, key)
        if item.kind == "box":
            return x, item.y if top else item.y + item.height
        if item.kind == "dot":
            return x, item.y + item.height
        return x, self.tops[item.row] if top else self.bottoms[item.row]

    def follow(self, item: Item, name: ItemKey, key: ItemKey) -> Iterator[XY]:
        """The points of a line from an item to the child or port it leads to.

        ``name`` is the line's key at that item, ``key`` its key at all others.
        """
        top = False
        if item.kind == "port":
            yield _x(item, top, name), 0.0
        while True:
            bundle = self.rows.leaving[item, top, name]
            assert bundle.sink is not None
            net, first = self.nets[bundle]
            x, y = self.at((item, top), bundle.key)
            end_x, end_y = self.at(bundle.sink, bundle.key)
            yield x, y
            leave = first + TRACK * (net.lower_track if top else net.upper_track)
            arrive = first + TRACK * (net.lower_track if bundle.sink[1] else net.upper_track)
            if not net.straight:
                yield x, leave
                if net.spine is not None and leave != arrive:
                    yield net.spine, leave
                    yield net.spine, arrive
                yield end_x, arrive
            yield end_x, end_y
            item, top, name = bundle.sink[0], not bundle.sink[1], key
            if item.kind == "port":
                yield end_x, self.height
            if item.kind in ("box", "port"):
                return


def lay_out(
    node: Node,
    name: str,
    children: dict[Node, Inside],
    sections: Sequence[tuple[LineSection, Wire]],
    ports: tuple[int, int],
) -> Inside:
    """Lay out a state whose children are laid out already.

    ``ports`` are the numbers of ports that its own lines need in its upper and lower border.
    """
    lines = node_lines(node)
    width, height = _head_size(node, name, lines)
    inner = [child for child in node.children if child in children]
    pairs = {
        (inner.index(section.source), inner.index(section.sink))
        for section, _ in sections
        if section.source and section.sink and section.source is not section.sink
    }
    parallel = node.type == "parallel"
    first = [toward(node, target) for target in node.initial] if inner else []
    layers = [0] * len(inner) if parallel else layers_of(inner, first, pairs)
    rows = Rows(max(layers, default=-1) + 1)
    made = Inside(node, name, lines, width, height, rows, {}, {}, {}, {}, {}, [], [])
    if not inner:
        need = BORDER * 2 + 2 * PORT_GAP * max(ports)
        made.width = made.width if node.type == "history" else _even(max(width, need))
        return made
    rows.add(Item("head", 0, width - 2 * PAD, height - 8, (width - 2 * PAD) / 2))
    for child, layer in zip(inner, layers, strict=True):
        box = children[child]
        made.items[child] = rows.add(_box(box, 2 * layer + 2))
    _connect(made, sections)
    arrange(rows, parallel)
    _finish(made, children, ports)
    return made


def _x(item: Item, top: bool, key: ItemKey) -> float:
    return PAD + item.x + (item.above if top else item.below).get(key, 0.0)


def _even(width: float) -> float:
    return 2.0 * ceil(width / 2)


def _head_size(node: Node, name: str, lines: tuple[str, ...]) -> tuple[float, float]:
    if node.type == "history":
        return HISTORY, HISTORY
    texts = [text_width(name, NAME_SIZE, bold=True)]
    texts += [text_width(line, LINE_SIZE) for line in lines]
    height = 8 + NAME_HEIGHT + LINE_HEIGHT * len(lines) + 8
    return _even(max(36.0, *texts) + 2 * PAD), height


def _box(inside: Inside, row: int) -> Item:
    half = inside.width / 2
    box = Item("box", row, inside.width, inside.height, half, inside.node)
    for key, port in inside.starts.items():
        if port.kind == "port" and not port.stop:
            box.above[key] = PAD + port.x - half
    for key, port in inside.ends.items():
        if not port.stop:
            box.below[key] = PAD + port.x - half
    return box


def _connect(made: Inside, sections: Sequence[tuple[LineSection, Wire]]) -> None:
    rows, known = made.rows, set()
    for section, wire in sections:
        if section in known:
            continue
        known.add(section)
        source = made.items[section.source] if section.source else made.starts.get(section.out)
        if source is None and isinstance(section.out, tuple) and section.out[0] == "dot":
            source = rows.add(Item("dot", 1, DOT, DOT, DOT / 2))
            made.starts[section.out] = source
        elif source is None:
            source = made.starts[section.out] = rows.port(0, section.out, section.stop)
        if section.sink:
            sink = made.items[section.sink]
        else:
            sink = made.ends[section.key] = rows.port(rows.last, section.key, section.stop)
        label = None
        if wire.edges and section is wire.sections[0]:
            label = made.labels[wire] = _label(edges_label(wire.edges))
        rows.connect(source, section.out, sink, section.key, label)


def _label(text: tuple[str, ...]) -> Item:
    width = max(text_width(line, LABEL_SIZE) for line in text)
    half = 7.0
    return Item(
        "label", 0, half + BESIDE + ceil(width) + 2, LINE_HEIGHT * len(text), half, text=text
    )


def _finish(made: Inside, children: dict[Node, Inside], ports: tuple[int, int]) -> None:
    """Find the tracks, the heights and the state's own size, once all items have their x."""
    rows = made.rows
    items = [item for row in rows.rows for item in row]
    right = max(item.left + item.width for item in items)
    up = ports[0] + sum(item.kind == "port" for item in rows.rows[0])
    down = ports[1] + len(made.ends)
    made.width = _even(max(right + 2 * PAD, BORDER * 2 + 2 * PORT_GAP * max(up, down)))
    channels: list[list[Bundle]] = [[] for _ in rows.rows]
    for bundle in rows.bundles.values():
        channels[bundle.channel].append(bundle)
    y = 0.0
    for index, row in enumerate(rows.rows):
        y = _channel(made, channels[index], y)
        last = index == rows.last
        # Ports cross the head's row from the border on, and the last one down to the border.
        made.tops.append(0.0 if index == 0 else y)
        top = 8.0 if index == 0 else y
        height = PAD if last else max((item.height for item in row), default=0.0)
        for item in row:
            spare = height - item.height
            item.y = top + {"label": spare / 2, "dot": spare}.get(item.kind, 0.0)
            region = made.node.type == "parallel" and item.node
            if region and region.type != "history":
                item.height = children[region].height = height  # as high as the highest
        y = top + height
        made.bottoms.append(y)
    made.height = y


def _net(bundle: Bundle) -> Net:
    net = Net([], [])
    for item, top in bundle.terminals:
        (net.lower if top else net.upper).append(_x(item, top, bundle.key))
    net.upper.sort()
    net.lower.sort()
    return net


def _channel(made: Inside, channel: list[Bundle], y: float) -> float:
    """Give the lines of a channel their tracks, and return the y of its lower end."""
    if not channel:
        return y + 4
    nets = [_net(bundle) for bundle in channel]
    tracks = route(nets, 4.0, made.width - 4)
    for bundle, net in zip(channel, nets, strict=True):
        made.nets[bundle] = net, y + TRACK
    return y + TRACK + TRACK * max(tracks - 1, 0) + (ARROW if tracks else TRACK)
