"""Order and places of the items of rows: few crossings, straight lines."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise

from fsm.drawing.columns import settle, slots
from fsm.drawing.rows import Item, Rows, Wires, gap
from fsm.drawing.tightening import tighten

SWEEPS, FEWER_SWEEPS = 6, 2
MANY = 8000
"""Items of one state from which on fewer sweeps must do."""
PORT_GAP = 14.0
BORDER = 12.0
"""From the corner of a state to its first port."""
_STRAIGHT = {("way", "way"): 8.0, ("box", "box"): 2.0}

Links = dict[Item, list[tuple[Item, float, float]]]
"""Per item those it is joined with in the next row: the item, how far apart their middles would be
with a straight line, and the weight of that."""


def arrange(rows: Rows, fixed_order: bool) -> None:
    """Order the items of each row, give each its ``x``, and states the ports that are free."""
    upper, lower = _links(rows)
    sweeps = SWEEPS if len(upper) < MANY else FEWER_SWEEPS
    _order(rows, upper, lower, fixed_order, sweeps)
    _align(rows, upper, lower, sweeps)
    tighten(rows)
    _shift_to_origin(rows)
    _free_ports(rows)


def _align(rows: Rows, upper: Links, lower: Links, sweeps: int) -> None:
    """Give each item its ``x``, sweeping over the rows downwards and upwards in turn."""
    order = [(row, _gaps(row)) for row in rows.rows]
    for row, apart in order:
        x = 0.0
        for item, step in zip(row, [0.0, *apart], strict=False):
            x = item.x = x + step
    for _ in range(sweeps // 2):
        for row, apart in order:
            _settle(row, apart, upper)
        for row, apart in reversed(order):
            _settle(row, apart, lower)
    for row, apart in order:
        _settle(row, apart, upper, lower)
    for row, apart in order:
        _settle(row, apart, upper)


def _shift_to_origin(rows: Rows) -> None:
    """Shift all items so that the leftmost begins at 0, in whole pixels; headings stay left."""
    left = min((item.left for row in rows.rows for item in row), default=0.0)
    for row in rows.rows:
        for item in row:
            item.x = item.anchor if item.kind == "head" else float(round(item.x - left))


def _links(rows: Rows) -> tuple[Links, Links]:
    upper: Links = {item: [] for row in rows.rows for item in row}
    lower: Links = {item: [] for row in rows.rows for item in row}
    for wires in rows.wires.values():
        assert wires.sink is not None
        sink, sink_top = wires.sink
        for item, top in wires.terminals:
            if item is sink or top == sink_top:
                continue
            high, low = (sink, item) if top else (item, sink)
            apart = _offset(high, wires, False) - _offset(low, wires, True)
            weight = _STRAIGHT.get((high.kind, low.kind), 4.0)
            upper[low].append((high, apart, weight))
            lower[high].append((low, -apart, weight))
    return upper, lower


def _offset(item: Item, wires: Wires, top: bool) -> float:
    return (item.above if top else item.below).get(wires.key, 0.0)


def _gaps(row: Sequence[Item]) -> list[float]:
    return [gap(one, two) for one, two in pairwise(row)]


def _settle(row: list[Item], gaps: list[float], *links: Links) -> None:
    wished, weights = [], []
    for item in row:
        mass = moment = 0.0
        for table in links:
            for other, apart, weight in table[item]:
                mass += weight
                moment += weight * (other.x + apart)
        wished.append(moment / mass if mass else item.x)
        weights.append(mass or 0.01)
    for item, x in zip(row, settle(wished, weights, gaps), strict=True):
        item.x = x


def _order(rows: Rows, upper: Links, lower: Links, fixed: bool, sweeps: int) -> None:
    """Barycentres, downwards and upwards in turn; the order with the fewest crossings is kept."""
    for row in rows.rows:
        row.sort(key=lambda item: item.kind != "head")
        _number(row)
    best, least = [list(row) for row in rows.rows], _crossings(rows, lower)
    for sweep in range(sweeps):
        if least == 0:
            break
        links = lower if sweep % 2 else upper
        for row in reversed(rows.rows) if sweep % 2 else rows.rows:
            boxes = [item for item in row if item.kind == "box"]
            row.sort(key=lambda item: _barycentre(item, links))
            if fixed and len(boxes) > 1:
                kept = iter(boxes)
                row[:] = [next(kept) if item.kind == "box" else item for item in row]
            _number(row)
        crossings = _crossings(rows, lower)
        if crossings < least:
            best, least = [list(row) for row in rows.rows], crossings
    rows.rows[:] = best


def _number(row: list[Item]) -> None:
    for index, item in enumerate(row):
        item.place = (index + 0.5) / len(row)


def _barycentre(item: Item, links: Links) -> tuple[bool, float]:
    found = links[item]
    if not found:
        return item.kind != "head", item.place
    if len(found) == 1:
        return True, found[0][0].place
    return True, sum(other.place for other, _, _ in found) / len(found)


def _crossings(rows: Rows, lower: Links) -> int:
    total = 0
    for row in rows.rows:
        ends: list[float] = []
        for item in row:
            found = [other.place + apart * 1e-6 for other, apart, _ in lower[item]]
            if len(found) > 1:
                found.sort()
            before = len(ends)
            for past, end in enumerate(found):
                # Its own lines, which end in order, do not cross each other.
                place = bisect_right(ends, end)
                total += before + past - place
                ends.insert(place, end)
    return total


def _free_ports(rows: Rows) -> None:
    """Ports of a state's own lines, opposite to where each comes from or goes to."""
    wanted: dict[tuple[Item, bool], list[Wires]] = {}
    for wires in rows.wires.values():
        for item, top in wires.terminals:
            if item.kind == "box" and wires.key not in (item.above if top else item.below):
                wanted.setdefault((item, top), []).append(wires)
    for (item, top), found in wanted.items():
        ports = item.above if top else item.below
        wished = [_opposite(wires, item) - item.x for wires in found]
        half = item.width / 2 - BORDER
        if item.node is not None and item.node.type == "history":
            # Too small for ports: its lines part further on.
            places = [0.0] * len(found)
        else:
            places = slots(wished, list(ports.values()), -half, half, PORT_GAP)
        for wires, at in zip(found, places, strict=True):
            ports[wires.key] = float(round(at))


def _opposite(wires: Wires, item: Item) -> float:
    others = sorted(other.x for other, _ in wires.terminals if other is not item)
    return min(others, key=lambda x: (abs(x - item.x), x), default=item.x)
