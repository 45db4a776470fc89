"""Orders the items of each row and gives them x coordinates: few crossings, straight lines.

The second and third step of layered drawing after Sugiyama, Tagawa and Toda (1981): crossings are
reduced by barycentres, coordinates found by isotonic regression (:mod:`fsm.drawing.columns`).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise

from fsm.drawing.columns import settle, slots
from fsm.drawing.rows import Bundle, Item, Rows, gap
from fsm.drawing.tightening import tighten

SWEEPS, FEWER_SWEEPS = 6, 2
MANY = 8000
"""With more items than this in one state, fewer sweeps are made."""
PORT_GAP = 14.0
BORDER = 12.0
"""Pixels from the corner of a state to its first port."""
_STRAIGHT = {("dummy", "dummy"): 8.0, ("box", "box"): 2.0}
"""The weight of a straight line between two kinds of item; between all others it is 4."""

Links = dict[Item, list[tuple[Item, float, float]]]
"""For each item its neighbours in the next row: the neighbour, the difference in x for which the
line between them is straight, and the weight of that difference."""


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
    for row, gaps in order:
        x = 0.0
        for item, step in zip(row, [0.0, *gaps], strict=False):
            x = item.x = x + step
    for _ in range(sweeps // 2):
        for row, gaps in order:
            _settle(row, gaps, upper)
        for row, gaps in reversed(order):
            _settle(row, gaps, lower)
    for row, gaps in order:
        _settle(row, gaps, upper, lower)
    for row, gaps in order:
        _settle(row, gaps, upper)


def _shift_to_origin(rows: Rows) -> None:
    """Shift all items so that the leftmost begins at 0, in whole pixels; headings stay left."""
    left = min((item.left for row in rows.rows for item in row), default=0.0)
    for row in rows.rows:
        for item in row:
            item.x = item.anchor if item.kind == "head" else float(round(item.x - left))


def _links(rows: Rows) -> tuple[Links, Links]:
    upper: Links = {item: [] for row in rows.rows for item in row}
    lower: Links = {item: [] for row in rows.rows for item in row}
    for bundle in rows.bundles.values():
        assert bundle.sink is not None
        sink, sink_top = bundle.sink
        for item, top in bundle.terminals:
            if item is sink or top == sink_top:
                continue
            high, low = (sink, item) if top else (item, sink)
            shift = _offset(high, bundle, False) - _offset(low, bundle, True)
            weight = _STRAIGHT.get((high.kind, low.kind), 4.0)
            upper[low].append((high, shift, weight))
            lower[high].append((low, -shift, weight))
    return upper, lower


def _offset(item: Item, bundle: Bundle, top: bool) -> float:
    return (item.above if top else item.below).get(bundle.key, 0.0)


def _gaps(row: Sequence[Item]) -> list[float]:
    return [gap(one, two) for one, two in pairwise(row)]


def _settle(row: list[Item], gaps: list[float], *links: Links) -> None:
    wished, weights = [], []
    for item in row:
        mass = moment = 0.0
        for table in links:
            for other, shift, weight in table[item]:
                mass += weight
                moment += weight * (other.x + shift)
        wished.append(moment / mass if mass else item.x)
        weights.append(mass or 0.01)
    for item, x in zip(row, settle(wished, weights, gaps), strict=True):
        item.x = x


def _order(rows: Rows, upper: Links, lower: Links, fixed: bool, sweeps: int) -> None:
    """Sort the rows by barycentres, downwards and upwards in turn; the best order found is kept."""
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
            found = [other.place + shift * 1e-6 for other, shift, _ in lower[item]]
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
    """Place the ports of the states' own lines, each opposite to the line's other end."""
    wanted: dict[tuple[Item, bool], list[Bundle]] = {}
    for bundle in rows.bundles.values():
        for item, top in bundle.terminals:
            if item.kind == "box" and bundle.key not in (item.above if top else item.below):
                wanted.setdefault((item, top), []).append(bundle)
    for (item, top), found in wanted.items():
        ports = item.above if top else item.below
        wished = [_opposite(bundle, item) - item.x for bundle in found]
        half = item.width / 2 - BORDER
        if item.node is not None and item.node.type == "history":
            # Too small for ports: its lines part further on.
            places = [0.0] * len(found)
        else:
            places = slots(wished, list(ports.values()), -half, half, PORT_GAP)
        for bundle, at in zip(found, places, strict=True):
            ports[bundle.key] = float(round(at))


def _opposite(bundle: Bundle, item: Item) -> float:
    others = sorted(other.x for other, _ in bundle.terminals if other is not item)
    return min(others, key=lambda x: (abs(x - item.x), x), default=item.x)
