"""Channel routing: horizontal tracks for the lines between two rows, so that none overlap.

A net joins terminals of the row above (``upper``) and of the row below (``lower``); a terminal is
the x of a vertical piece. Where a terminal of one net stands under a terminal of another, the one
from above must turn off first; a circle of such wishes is cut by giving one net two tracks and a
spine between them (the "dogleg" of channel routing, Deutsch 1976).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush
from itertools import pairwise

NEAR = 4.0
"""Vertical pieces nearer than this, in pixels, would overlap."""


@dataclass(eq=False, slots=True)
class Net:
    """Terminals that are joined in one channel, and the tracks found for them."""

    upper: list[float]
    lower: list[float]
    upper_track: int = 0
    lower_track: int = 0
    spine: float | None = None
    """The x at which it changes from its upper to its lower track, if those are two."""

    @property
    def straight(self) -> bool:
        return self.upper == self.lower and len(self.upper) == 1


@dataclass(eq=False, slots=True)
class _Part:
    net: Net
    upper: list[float]
    lower: list[float]
    left: float
    right: float
    below: set[int] = field(default_factory=set)
    """The indices of the parts that must lie further down."""


def route(nets: Sequence[Net], low: float, high: float) -> int:
    """Give every net its tracks, counted from above, and return the number of tracks.

    Spines are placed between the x ``low`` and ``high``.
    """
    parts = [
        _Part(net, net.upper, net.lower, *_extent([*net.upper, *net.lower]))
        for net in nets
        if not net.straight
    ]
    taken = [x for net in nets for x in (*net.upper, *net.lower)]
    while True:
        _constrain(parts)
        order, stuck = _sorted(parts)
        if not stuck:
            break
        net = min(stuck, key=parts.index).net
        parts = [part for part in parts if part.net is not net]
        spine = net.spine = _free((min(net.upper) + min(net.lower)) / 2, taken, low, high)
        taken.append(spine)
        parts.append(_Part(net, net.upper, [], *_extent([*net.upper, spine])))
        parts.append(_Part(net, [], net.lower, *_extent([*net.lower, spine])))
    return _pack(order, parts)


def _extent(xs: list[float]) -> tuple[float, float]:
    return min(xs), max(xs)


def _constrain(parts: list[_Part]) -> None:
    arriving = sorted((x, index) for index, part in enumerate(parts) for x in part.lower)
    for part in parts:
        part.below = {
            index
            for x in part.upper
            for other, index in arriving
            if abs(other - x) < NEAR and parts[index].net is not part.net
        }
    for part in parts:
        if part.net.spine is not None and part.upper:
            part.below |= {i for i, p in enumerate(parts) if p.net is part.net and p is not part}


def _sorted(parts: list[_Part]) -> tuple[list[int], list[_Part]]:
    """Topological order of the parts, upper ones first, and the parts in or behind a cycle.

    Of the parts that may come next, the one that crosses fewest others does.
    """
    above = [0] * len(parts)
    for part in parts:
        for index in part.below:
            above[index] += 1
    ranks = [_rank(part) for part in parts]
    ready = [(ranks[index], index, index) for index, count in enumerate(above) if not count]
    heapify(ready)
    order: list[int] = []
    while ready:
        index = heappop(ready)[-1]
        order.append(index)
        for other in parts[index].below:
            above[other] -= 1
            if not above[other]:
                # Of equals, the one that was ready sooner comes first.
                heappush(ready, (ranks[other], len(parts) + len(order), other))
    placed = set(order)
    return order, [part for index, part in enumerate(parts) if index not in placed]


def _rank(part: _Part) -> tuple[float, float]:
    if not part.lower:
        return 0.0, part.right - part.left  # turns back up: the narrow ones inside
    if not part.upper:
        return 2.0, part.left - part.right
    start, end = sum(part.upper) / len(part.upper), sum(part.lower) / len(part.lower)
    return 1.0, -start if end >= start else start


def _pack(order: list[int], parts: list[_Part]) -> int:
    """Give each part the highest track that is free along its extent and below all that must be
    above it; return the number of tracks.
    """
    least = [0] * len(parts)
    tracks: list[list[_Part]] = []
    for index in order:
        part = parts[index]
        track = least[index]
        while track < len(tracks) and any(
            part.left < other.right + 3 * NEAR and other.left < part.right + 3 * NEAR
            for other in tracks[track]
        ):
            track += 1
        while len(tracks) <= track:
            tracks.append([])
        tracks[track].append(part)
        for other in part.below:
            least[other] = max(least[other], track + 1)
        if part.upper or part.net.spine is None:
            part.net.upper_track = track
        if part.lower or part.net.spine is None:
            part.net.lower_track = track
    return len(tracks)


def _free(wish: float, taken: list[float], low: float, high: float) -> float:
    """The x nearest to the wished one that keeps clear of all others; in the widest gap if none."""
    steps = range(int(high - low) + 1)
    for x in sorted((low + step for step in steps), key=lambda x: (abs(x - wish), x)):
        if all(abs(x - other) >= NEAR for other in taken):
            return x
    gaps = sorted({low, *taken, high})
    left, right = max(pairwise(gaps), key=lambda gap: gap[1] - gap[0])
    return (left + right) / 2
