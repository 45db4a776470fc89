"""The centre line of a road on a map of the ground: found, and traced node by node.

A node is traced from the one before it by prediction and correction: the line is expected to go on
with its heading and curvature; there the road is cut at right angles, and what its middle differs
from the expected place corrects place, heading and curvature (a fading-memory filter of second
degree: P. Zarchan, H. Musoff, "Fundamentals of Kalman Filtering", 2009, §7). Where the road is
wider or narrower than it was, its middle is not the line: there a branch leaves it, or a thing of
like colour lies beside it. Then only an edge that is where it was expected counts.

Where the road ends ahead, the line is at a corner, at a gap, or at its end: of the ways that leave
the place half a width before that end the straightest one is taken; else the road goes on beyond a
gap, where it is about as wide and as expected; else that was its end, if the ground as far as the
longest gap has been seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, ceil, cos, exp, floor, hypot, pi, sin, tan
from typing import Literal, NamedTuple

import cv2
import numpy as np

from behaviors.perception.ground_map import GroundMap
from hal.scene.arrays import Bools, Float32s, Float64s
from vencejo.geometry import wrap
from vencejo.polylines import XY

Ending = Literal["open", "end", "none"]
"""How a traced line ends: where nothing was seen yet; where the road does; or there is no road."""

_MEMORY = 0.42
"""Of the width: the way after which the filter remembers 1/e of what it knew."""
_STEP = 0.25
"""Of the width: from node to node."""
_SHORTEST_STEP, _LONGEST_STEP = 0.1, 0.5
"""Metres."""
_SHARPEST = 1.5
"""Times the width: the sharpest curvature that is no corner."""
_ASIDE = 0.6
"""Of the width: a road that is farther from where it was expected is not this one."""
_UNEVEN = 0.15
"""Of the width: what may be wider or narrower and is still the road alone."""
_HOLE = 0.25
"""Of the width: what interrupts a cut less than this is on the road."""
_SPARE = 1.5
"""Of the width: the longest part of a line that is taken back before a corner or an end."""
_RAYS = (-0.2, -0.1, 0.0, 0.1, 0.2)
"""Of the width: beside the line, along which its end is looked for."""
_FAN = 0.45
"""Angle within which the road may go on beyond a gap, radians to each side."""
_RINGS = (0.95, 1.8, 3.0)
"""Of the width: the distances from a corner at which the ways out are looked for."""
_DIRECTIONS = 72
"""On such a ring."""
_AHEAD = 0.35
"""Angle from straight ahead within which a way out is no turn, radians."""
_BEHIND = 0.9
"""Angle from the way back within which no way leads out, radians, at the nearest ring."""


class Node(NamedTuple):
    """A place of a centre line; metres and radians."""

    x: float
    y: float
    heading: float
    """Of the line there, counter-clockwise from the map's x."""
    curvature: float
    """1/m, positive to the left."""
    is_road: bool = True
    """Not in a gap."""


class Run(NamedTuple):
    """A part of a cut through the ground that is road, metres from the middle, left positive."""

    right: float
    left: float
    right_known: bool
    """Not where it ends because no more of the ground was seen."""
    left_known: bool

    @property
    def width(self) -> float:
        return self.left - self.right


@dataclass(frozen=True)
class CentreLine:
    """A line that was traced."""

    nodes: tuple[Node, ...]
    """From the last known one on."""
    ending: Ending
    width: float
    """Of the road, metres."""
    has_edges: bool
    """Whether the road had an edge where it was expected."""


@dataclass(frozen=True)
class Widths:
    """The widths that a road may have, metres."""

    least: float
    most: float

    def kept(self, width: float) -> float:
        return min(self.most, max(self.least, width))


def along(node: Node, way: float) -> XY:
    """The place where a line goes on to after ``way`` metres."""
    middle = node.heading + node.curvature * way / 2
    return node.x + way * cos(middle), node.y + way * sin(middle)


def cut(ground: GroundMap, at: XY, heading: float, half: float, hole: float = 0.0) -> list[Run]:
    """The runs of road across a heading, up to ``half`` metres to each side, from right to left.

    What is between two of them and narrower than ``hole`` belongs to the road.
    """
    count = max(3, ceil(2 * half / (0.75 * ground.cell)))
    offsets = np.linspace(-half, half, count)
    left = np.array([-sin(heading), cos(heading)])
    share, seen = ground.sample(np.asarray(at) + offsets[:, None] * left)
    runs: list[Run] = []
    for begin, end in _spans((share > 0.5) & seen):
        run = Run(
            _edge(offsets, share, begin, begin - 1) if begin > 0 else -half,
            _edge(offsets, share, end, end + 1) if end < count - 1 else half,
            begin > 0 and bool(seen[begin - 1]),
            end < count - 1 and bool(seen[end + 1]),
        )
        if runs and run.right - runs[-1].left < hole:
            last = runs.pop()
            run = Run(last.right, run.left, last.right_known, run.left_known)
        runs.append(run)
    return runs


def _spans(inside: Bools) -> list[tuple[int, int]]:
    """The first and the last number of each row of true values."""
    padded = np.zeros(len(inside) + 2, np.int8)
    padded[1:-1] = inside
    changes = np.flatnonzero(np.diff(padded))
    return [(int(a), int(b) - 1) for a, b in zip(changes[::2], changes[1::2], strict=True)]


def _edge(offsets: Float64s, share: Float32s, inner: int, outer: int) -> float:
    """Where the share is one half, between two neighbours."""
    a, b = float(share[inner]), float(share[outer])
    part = (a - 0.5) / (a - b) if a > 0.5 >= b else 0.5
    return float(offsets[inner] + part * (offsets[outer] - offsets[inner]))


def trace(
    ground: GroundMap,
    known: Sequence[Node],
    width: float,
    widths: Widths,
    gap: float,
    *,
    reach: float,
    into_gap: bool = False,
) -> CentreLine:
    """Trace a line on from the last of the nodes that are known, for ``reach`` metres at most.

    ``width``: of the road there; ``gap``: the longest that is crossed; metres. ``into_gap``: where
    the road ends and too little of the ground beyond was seen, as far as that was.
    """
    return _Tracer(ground, known, width, widths, gap).trace(reach, into_gap)


class _Tracer:
    def __init__(
        self, ground: GroundMap, known: Sequence[Node], width: float, widths: Widths, gap: float
    ) -> None:
        self._ground, self._widths, self._gap = ground, widths, gap
        self._width = width
        self._into_gap = False
        *self._before, begin = known
        self._nodes = [begin]
        self._length = 0.0
        self._has_edges = False
        """Whether the road had any edge where it was expected."""
        self._even = 1
        """The number of nodes up to the last one where the road was as wide as it is."""

    @property
    def _step(self) -> float:
        return min(_LONGEST_STEP, max(_SHORTEST_STEP, _STEP * self._width))

    def trace(self, reach: float, into_gap: bool) -> CentreLine:
        self._into_gap = into_gap
        ending: Ending | None = None
        for _ in range(ceil(reach / self._step)):
            ending = None if self._go_on() else self._beyond()
            if ending is not None or self._length >= reach:
                break
        return CentreLine(tuple(self._nodes), ending or "open", self._width, self._has_edges)

    def _go_on(self) -> bool:
        """Trace the next node; False where there is no road."""
        last, step, width = self._nodes[-1], self._step, self._width
        at = along(last, step)
        heading = last.heading + last.curvature * step
        runs = cut(self._ground, at, heading, 1.6 * width, _HOLE * width)
        run = min(runs, key=_away, default=None)
        if run is None:
            return False
        aside, is_even = self._middle(run)
        if abs(aside) > _ASIDE * width or _away(run) > 0.35 * width:
            return False
        self._learn_width(run)
        self._add(corrected(last, step, aside, width))
        if is_even:
            self._even = len(self._nodes)
        return True

    def _middle(self, run: Run) -> tuple[float, bool]:
        """How far the line is from where it was expected, left positive, by the run of road there;
        and whether that is as wide as the road.
        """
        half, sharp = self._width / 2, self._ground.cell
        left, right = run.left - half, run.right + half
        known = run.left_known and run.right_known
        if known and abs(left - right) <= _UNEVEN * self._width + sharp:
            self._has_edges = True
            return (left + right) / 2, True
        edges = [(left, run.left_known), (right, run.right_known)]
        trusted = [
            middle
            for middle, is_known in edges
            if is_known and abs(middle) <= _UNEVEN / 2 * self._width + sharp
        ]
        self._has_edges = self._has_edges or bool(trusted)
        return sum(trusted) / len(trusted) if trusted else 0.0, False

    def _learn_width(self, run: Run) -> None:
        known = run.left_known and run.right_known
        if known and abs(run.width - self._width) < 0.35 * self._width:
            self._width = self._widths.kept(self._width + 0.05 * (run.width - self._width))

    def _add(self, node: Node) -> None:
        last = self._nodes[-1]
        self._length += hypot(node.x - last.x, node.y - last.y)
        self._nodes.append(node)

    def _beyond(self) -> Ending | None:
        """Go on round a corner or over a gap; None when that went well, else how the line ends."""
        self._drop_uneven()
        last = self._nodes[-1]
        if not last.is_road:
            return self._cross(self._edge())
        far, seen = self._road_ahead(last)
        x, y = along(last._replace(curvature=0.0), far)
        end = last._replace(x=x, y=y)
        if not seen or not (self._into_gap or self._is_seen_about(end)):
            return "open"
        if not self._is_on_road(end):
            return "none"
        if self._turn(end, _RINGS[0]):
            return None
        if far > 0.02:
            self._add(end)
        ending = self._cross(end)
        # Only the end of a road may be the tip of a hairpin: a way back may be another road's.
        if ending == "end" and any(self._turn(end, ring) for ring in _RINGS[1:]):
            return None
        return ending

    def _drop_uneven(self) -> None:
        """Take back the nodes of a corner or a road's end, whose edges are not the line's."""
        spare = self._nodes[self._even - 1 :]
        if length_of(spare) < _SPARE * self._width:
            while len(self._nodes) > self._even:
                self._drop()

    def _drop(self) -> None:
        last = self._nodes.pop()
        self._length -= length_of([self._nodes[-1], last])

    def _road_ahead(self, last: Node) -> tuple[float, bool]:
        """How far the road goes on straight ahead, metres, and whether it is seen to end there."""
        most = (_SPARE + 2) * self._width
        ways = np.linspace(0, most, ceil(most / (0.5 * self._ground.cell)))
        ahead = np.array([cos(last.heading), sin(last.heading)])
        left = np.array([-ahead[1], ahead[0]])
        asides = np.array(_RAYS)[:, None, None] * self._width * left
        share, seen = self._ground.sample(
            (np.array(last[:2]) + asides + ways[:, None] * ahead).reshape(-1, 2)
        )
        inside = ((share > 0.5) & seen).reshape(len(_RAYS), -1).mean(0) > 0.5
        # A hole is no end.
        hole = max(1, round(_HOLE * self._width / (ways[1] - ways[0])))
        spans = _spans(~inside)
        first = next((a for a, b in spans if b - a >= hole or b == len(ways) - 1), None)
        if first is None:
            return 0.0, False
        return float(ways[max(0, first - 1)]), bool(seen.reshape(len(_RAYS), -1)[:, first].all())

    def _is_on_road(self, end: Node) -> bool:
        """Whether there is road before an end."""
        back = np.linspace(0.15, 0.8, 6)[:, None] * self._width
        behind = np.array(end[:2]) - back * [cos(end.heading), sin(end.heading)]
        share, seen = self._ground.sample(behind)
        return bool(((share > 0.5) & seen).mean() > 0.5)

    def _is_seen_about(self, end: Node) -> bool:
        """Whether the ground ahead of a corner and beside it was seen, where ways may lead out."""
        back, far = self._width / 2, _RINGS[0] * self._width
        angles = end.heading + np.linspace(-pi / 2, pi / 2, 13)
        corner = np.array(end[:2]) - back * np.array([cos(end.heading), sin(end.heading)])
        ring = corner + far * np.stack([np.cos(angles), np.sin(angles)], 1)
        return bool(self._ground.sample(ring)[1].all())

    def _turn(self, end: Node, ring: float) -> bool:
        """Go on by a way that leaves the road half a width before its end, where it is so many
        widths away from there.
        """
        back = self._width / 2
        corner = Node(
            end.x - back * cos(end.heading), end.y - back * sin(end.heading), end.heading, 0.0
        )
        outs = exits(self._ground, corner[:2], ring * self._width, self._width)
        turn_back = end.heading + pi
        ways = [
            out
            for out in outs
            if abs(wrap(out - turn_back)) > _BEHIND / (ring / _RINGS[0])
            and abs(wrap(out - end.heading)) > _AHEAD
            and self._is_new(corner, out, ring * self._width)
        ]
        if not ways:
            return False
        out = min(ways, key=lambda way: abs(wrap(way - end.heading)))
        self._drop_beyond(corner)
        self._add(corner._replace(heading=wrap(out)))
        self._even = len(self._nodes)
        return True

    def _is_new(self, corner: Node, out: float, far: float) -> bool:
        """Whether a way out leads over road, away from the line so far."""
        ways = np.linspace(0.0, 1.0, 8)[1:, None] * far
        places = np.array(corner[:2]) + ways * [cos(out), sin(out)]
        share, seen = self._ground.sample(places)
        if not bool(((share > 0.5) & seen).all()):
            return False
        x, y = places[-1]
        passed = (*self._before, *self._nodes)
        return all(hypot(node.x - x, node.y - y) > 0.7 * self._width for node in passed)

    def _drop_beyond(self, corner: Node) -> None:
        """Take back the nodes that were traced past a corner, but not the first one."""
        ahead = cos(corner.heading), sin(corner.heading)
        while len(self._nodes) > 1:
            x, y = self._nodes[-1].x - corner.x, self._nodes[-1].y - corner.y
            if x * ahead[0] + y * ahead[1] < -0.5 * self._step:
                return
            self._drop()

    def _edge(self) -> Node:
        """The last node of the road before the gap in which the line begins."""
        return next((node for node in reversed(self._before) if node.is_road), self._nodes[-1])

    def _cross(self, edge: Node) -> Ending | None:
        """Go on beyond a gap that begins at an edge, or in it as far as it was seen."""
        step, last = self._step / 2, self._nodes[-1]
        passed = hypot(last.x - edge.x, last.y - edge.y)
        before: Node | None = None
        seen_ways: list[float] = []
        all_seen = True
        for k in range(floor(passed / step) + 1, ceil((self._gap + 2 * step) / step) + 1):
            way = k * step
            at, heading = along(edge, way), edge.heading + edge.curvature * way
            found = self._after_gap(at, heading, 0.9 * self._width + way * tan(_FAN), way)
            if found is not None and before is not None:
                self._join(before, found)
                return None
            before = found
            if way <= self._gap:
                all_seen = all_seen and bool(self._ground.sample([at])[1][0])
                seen_ways += [way] if all_seen else []
        if all_seen:
            if not last.is_road:
                self._add(edge)
            return "end"
        for way in seen_ways[1::2] if self._into_gap or not last.is_road else ():
            x, y = along(edge, way)
            self._add(Node(x, y, edge.heading + edge.curvature * way, edge.curvature, False))
        return "open"

    def _after_gap(self, at: XY, heading: float, half: float, way: float) -> Node | None:
        """The road at a place beyond a gap, if it is there."""
        runs = cut(self._ground, at, heading, half, _HOLE * self._width)
        fitting = [
            run
            for run in runs
            if run.left_known
            and run.right_known
            and abs(run.width - self._width) < 0.35 * self._width
            and abs(run.left + run.right) / 2 < 0.4 * self._width + way * tan(_FAN)
        ]
        if not fitting:
            return None
        run = min(fitting, key=_away)
        aside = (run.left + run.right) / 2
        return Node(at[0] - aside * sin(heading), at[1] + aside * cos(heading), heading, 0.0)

    def _join(self, first: Node, second: Node) -> None:
        """Add the nodes of a gap, and those of the road beyond it."""
        end = self._nodes[-1]
        across = hypot(first.x - end.x, first.y - end.y)
        heading = atan2(first.y - end.y, first.x - end.x)
        count = max(1, ceil(across / self._step))
        for k in range(1, count + 1):
            share = k / count
            x, y = end.x + share * (first.x - end.x), end.y + share * (first.y - end.y)
            self._add(Node(x, y, heading, 0.0, False))
        self._add(second._replace(heading=_mean(heading, second.heading)))
        self._even = len(self._nodes)


def corrected(last: Node, step: float, aside: float, width: float) -> Node:
    """The node after another, when the road lies ``aside`` metres left of where it was expected."""
    x, y = along(last, step)
    heading = last.heading + last.curvature * step
    kept = exp(-step / (_MEMORY * width))
    shift = (1 - kept**3) * aside
    turn = 1.5 * (1 - kept**2) * (1 - kept) * aside / step
    bend = (1 - kept) ** 3 * aside / step**2
    most = _SHARPEST / width
    return Node(
        x - shift * sin(heading),
        y + shift * cos(heading),
        wrap(heading + _within(turn, most * step)),
        _within(last.curvature + bend, most),
    )


def _within(number: float, most: float) -> float:
    return max(-most, min(most, number))


def _away(run: Run) -> float:
    """How far a run is from the middle; 0 when that is in it."""
    return max(run.right, -run.left, 0.0)


def _mean(a: float, b: float) -> float:
    return wrap(a + wrap(b - a) / 2)


def exits(ground: GroundMap, at: Sequence[float], radius: float, width: float) -> list[float]:
    """The directions in which a road about ``width`` metres wide leaves a circle."""
    angles = np.arange(_DIRECTIONS) * (2 * pi / _DIRECTIONS)
    ring = np.asarray(at[:2]) + radius * np.stack([np.cos(angles), np.sin(angles)], 1)
    share, seen = ground.sample(ring)
    inside = (share > 0.5) & seen
    if inside.all() or not inside.any():
        return []
    # Begin the circle where there is no road, so that no run lies across its begin.
    first = int(np.flatnonzero(~inside)[0])
    found = []
    for begin, end in _spans(np.roll(inside, -first)):
        wide = (end - begin + 1) * 2 * pi / _DIRECTIONS
        across = 2 * radius * sin(min(wide, pi) / 2)
        if 0.4 * width < across < 1.7 * width:
            found.append(float(angles[0] + (first + (begin + end) / 2) * 2 * pi / _DIRECTIONS))
    return found


class Begin(NamedTuple):
    """A road that was found: a node on it for each way along it."""

    ways: tuple[Node, ...]
    width: float


def find(ground: GroundMap, here: XY, widths: Widths, gap: float) -> Begin | None:
    """The road that is nearest to a place, among those that lead somewhere; None for none."""
    road, origin = ground.whole()
    deep = np.asarray(cv2.distanceTransform(road, cv2.DIST_L2, 3), np.float32) * ground.cell
    _, parts = cv2.connectedComponents(road, connectivity=4)
    rows, columns = np.nonzero(deep > 0.35 * widths.least)
    if not len(rows):
        return None
    places = np.stack([columns, rows], 1) * ground.cell + origin
    order = np.argsort(np.hypot(*(places - here).T), kind="stable")
    tried: set[int] = set()
    for k in order:
        row, column = int(rows[k]), int(columns[k])
        part = int(parts[row, column])
        if part in tried:
            continue
        tried.add(part)
        found = _begin_at(ground, deep, (row, column), origin, widths, gap)
        if found is not None:
            return found
    return None


def _begin_at(
    ground: GroundMap,
    deep: Float32s,
    cell: tuple[int, int],
    origin: Float64s,
    widths: Widths,
    gap: float,
) -> Begin | None:
    """The road at a cell, if it is one: as wide as may be, and leading somewhere."""
    row, column = cell
    size = ceil(widths.most / ground.cell)
    top, left = max(0, row - size), max(0, column - size)
    near = deep[top : row + size + 1, left : column + size + 1]
    # The nearest place that is as deep inside the road as any about it.
    deepest = np.asarray(cv2.dilate(near, np.ones((5, 5), np.uint8)), np.float32)
    rows, columns = np.nonzero((near >= deepest) & (near > 0.35 * widths.least))
    if not len(rows):
        return None
    far = np.hypot(rows + top - row, columns + left - column)
    nearest = int(np.argmin(far))
    r, c = int(rows[nearest]) + top, int(columns[nearest]) + left
    width = 2 * float(deep[r, c])
    x, y = float(c * ground.cell + origin[0]), float(r * ground.cell + origin[1])
    if not 0.7 * widths.least <= width <= 1.2 * widths.most:
        return None
    width = widths.kept(width)
    ways = []
    for out in exits(ground, (x, y), 0.95 * width, width):
        line = trace(ground, [Node(x, y, wrap(out), 0.0)], width, widths, gap, reach=3 * width)
        if sum(node.is_road for node in line.nodes) > 4 and line.ending != "none":
            ways.append(line.nodes[0])
    return Begin(tuple(ways), width) if ways else None


def length_of(nodes: Sequence[Node]) -> float:
    """The way along some nodes, metres."""
    return sum(hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(nodes))
