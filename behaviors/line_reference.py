"""A reference that moves along a line which becomes known while it is flown.

It is at rest at the begin. A carrot moves along the nodes of the line, at the speed that was asked
for, or slower: so that the vehicle keeps to the bends (v² ≤ a/κ), slows down before them and before
the end of what is known of the line (v² ≤ u² + 2·b·s), and is not left behind. The reference is the
mean of the carrot's places over the last SMOOTHING periods, as in :mod:`behaviors.guidance`.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from math import hypot, inf, pi, sqrt

from behaviors.guidance import (
    CATCH_UP,
    MAX_LEAD,
    SMOOTHING,
    acceleration_at,
)
from behaviors.moving_average import MovingAverage
from behaviors.perception.centre_line import Node
from hal.vehicle import PERIOD, Observation, Position
from vencejo.geometry import Point, distance, wrap
from vencejo.polylines import XY

BRAKING = 2.0
"""Deceleration with which it slows down before bends and the end of what is known, m/s²."""
HARDEST = 2.5
"""The largest deceleration, for what comes into sight late, m/s²."""
CORNERING = 2.0
"""Largest acceleration in a bend, m/s²."""
SETTLED = 0.2
"""What is this near before the carrot stays as it is, metres: it moves no more sideways."""
_CORNER = 0.25
"""Turns from node to node above this are corners, radians."""
_ROUNDING = 0.3
"""Way over which the reference turns in a corner, metres."""
_UNKNOWN = sqrt(CORNERING * _ROUNDING / (pi / 2))
"""Speed where the line is not known any further, m/s: there may be a corner."""
_KEPT = 40
"""Nodes behind the carrot that are kept at least."""
_ENDED = 0.01
"""Metres before the end at which it is there."""


class LineReference:
    """Where the vehicle is to be on its line: each period ``step``, then ``setpoint``."""

    def __init__(self, begin: Point) -> None:
        self._z = begin.z
        self._x, self._y = (MovingAverage([at] * SMOOTHING) for at in (begin.x, begin.y))
        self._periods = MovingAverage([PERIOD] * SMOOTHING)
        self._places: list[XY] = [(begin.x, begin.y)] * 3
        """Where it is in this period and in the next two."""
        self.nodes: list[Node] = []
        """Of the line, from some behind the carrot on."""
        self._ways: list[float] = []
        """Of each node from the begin of the line, metres."""
        self._limits: list[float] = []
        """Speed at each node at most, m/s."""
        self.way = 0.0
        """The carrot's along the line, metres."""
        self.speed = 0.0
        """The carrot's, m/s."""

    @property
    def position(self) -> Point:
        """Where the vehicle is to be now."""
        return Point(*self._places[0], self._z)

    @property
    def velocity(self) -> Point:
        """The mean velocity until the next period, m/s."""
        (x, y), (u, v), _ = self._places
        rate = 1 / self._periods.mean
        return Point((u - x) * rate, (v - y) * rate, 0.0)

    @property
    def left(self) -> float:
        """From the carrot to the end of what is known of the line, metres."""
        return self._ways[-1] - self.way

    @property
    def has_ended(self) -> bool:
        """Whether it is at rest at the end of what is known."""
        return self.left < _ENDED and self.velocity.norm() < 0.02

    @property
    def settled(self) -> Sequence[Node]:
        """The nodes that do not change any more; from the last one the line is traced on."""
        return self.nodes[: self._settled_number() + 1]

    def _settled_number(self) -> int:
        return min(bisect_right(self._ways, self.way + SETTLED), len(self.nodes) - 1)

    def go_on(self, nodes: Sequence[Node], is_end: bool) -> None:
        """Know the line from the last settled node on, which is the first of these; ``is_end``:
        up to its end.
        """
        if self.nodes:
            keep = self._settled_number() + 1
            self.nodes[keep:] = nodes[1:]
            del self._ways[keep:]
        else:
            self.nodes, self._ways = list(nodes), [0.0]
        for before, node in pairwise(self.nodes[len(self._ways) - 1 :]):
            self._ways.append(self._ways[-1] + hypot(node.x - before.x, node.y - before.y))
        self._forget()
        self._limits = self._speeds(0.0 if is_end else _UNKNOWN)

    def _forget(self) -> None:
        spare = bisect_right(self._ways, self.way) - 2 * _KEPT
        if spare > 0:
            drop = spare + _KEPT
            del self.nodes[:drop], self._ways[:drop]

    def _speeds(self, end: float) -> list[float]:
        """The speed at each node at most; ``end``: that at the last one."""
        most = [inf] * len(self.nodes)
        for k, (before, node) in enumerate(pairwise(self.nodes), start=1):
            turn = abs(wrap(node.heading - before.heading))
            bend = turn / _ROUNDING if turn > _CORNER else abs(node.curvature)
            if bend > 0:
                most[k] = sqrt(CORNERING / bend)
        most[-1] = end
        for k in reversed(range(len(most) - 1)):
            way = self._ways[k + 1] - self._ways[k]
            most[k] = min(most[k], sqrt(most[k + 1] ** 2 + 2 * BRAKING * way))
        return most

    def step(self, vehicle: Observation, speed: float, dt: float) -> None:
        """Move on for ``dt`` seconds, at ``speed`` m/s at most."""
        self._periods.push(dt)
        wanted = min(speed, self._limit(dt), self._leash(vehicle))
        faster = acceleration_at(speed) * dt
        self.speed += max(-HARDEST * dt, min(faster, wanted - self.speed))
        self.way = min(self._ways[-1], self.way + self.speed * dt)
        x, y = self.place(self.way)
        self._places = [*self._places[1:], (self._x.push(x), self._y.push(y))]

    def _limit(self, dt: float) -> float:
        """The carrot's speed at most."""
        k = min(bisect_right(self._ways, self.way), len(self._ways) - 1)
        way = self._ways[k] - self.way
        lost = BRAKING * dt / 2
        speed = sqrt(lost * lost + self._limits[k] ** 2 + 2 * BRAKING * way) - lost
        return min(speed, max(0.0, self.left) / dt)

    def _leash(self, vehicle: Observation) -> float:
        """The speed at most, so that a vehicle which cannot follow is waited for."""
        velocity, flown = self.velocity, vehicle.velocity
        speed = velocity.norm()
        lead = distance(self.position, vehicle.position)
        along = (flown.x * velocity.x + flown.y * velocity.y) / speed if speed > 0.01 else 0.0
        return max(0.0, along + (MAX_LEAD - lead) * CATCH_UP)

    def place(self, way: float) -> XY:
        """The place of the line at a way along it."""
        k = max(1, min(bisect_right(self._ways, way), len(self._ways) - 1))
        if len(self._ways) == 1:
            return self.nodes[0].x, self.nodes[0].y
        a, b = self.nodes[k - 1], self.nodes[k]
        length = self._ways[k] - self._ways[k - 1]
        share = (way - self._ways[k - 1]) / length if length > 0 else 1.0
        return a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)

    def nearest(self, x: float, y: float) -> Node:
        """The node of the road that is nearest to a place, among those about the carrot."""
        k = bisect_right(self._ways, self.way)
        about = self.nodes[max(0, k - _KEPT // 2) : k + _KEPT // 2]
        road = [node for node in about if node.is_road] or about
        return min(road, key=lambda node: hypot(node.x - x, node.y - y))

    def heading(self) -> float:
        """That of the line where the carrot is, radians."""
        return self.nodes[min(bisect_right(self._ways, self.way), len(self._ways) - 1)].heading

    def setpoint(self, yaw: float) -> Position:
        (x, y), (u, v), (s, t) = self._places
        rate = 1 / self._periods.mean**2
        acceleration = Point((s - 2 * u + x) * rate, (t - 2 * v + y) * rate, 0.0)
        return Position(self.position, self.velocity, yaw, acceleration=acceleration)
