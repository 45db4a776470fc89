"""In which order solids are painted so that the nearer ones cover the farther ones.

If a plane separates two convex solids, the one on the camera's side of it cannot be hidden by the
other. Solids that no plane separates, or that hide each other in a circle, come as a *knot*: they
are to be drawn with depth per pixel. (Sorting by distance alone is wrong for many arrangements.)
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_TOUCH = 1e-6
"""Solids that reach this far into each other still count as separate, metres."""


def paint_order(
    screen: Floats, depths: Floats, boxes: Floats, eye: Floats, side: Callable[[int, int], int]
) -> list[list[int]]:
    """Groups of solids from far to near; a group of several is a knot.

    Per solid: ``screen`` (n, 4) left, top, right, bottom in pixels; ``depths`` (n, 2) nearest and
    farthest; ``boxes`` (n, 6) lowest and highest x, y, z in the world. ``side(a, b)`` answers for
    the pairs that these do not decide: 1 when a is in front of b, −1 when behind, 0 when knotted.
    """
    count = len(screen)
    left, top, right, bottom = screen.T
    meets = (left[:, None] <= right) & (top[:, None] <= bottom)
    a, b = np.nonzero(meets & meets.T)
    once = a < b
    a, b = a[once], b[once]
    front = (depths[a, 1] <= depths[b, 0] + _TOUCH) * 1 - (depths[b, 1] <= depths[a, 0] + _TOUCH)
    low, high = boxes[:, :3], boxes[:, 3:]
    open_ = np.flatnonzero(front == 0)
    for p, q, sign in ((a, b, 1), (b, a, -1)):
        if not len(open_):
            break
        ends, begins = high[p[open_]], low[q[open_]]
        # 1 where a plane across an axis has p on the camera's side of it, −1 where q.
        sides = np.where(ends <= begins + _TOUCH, np.where(2 * eye <= ends + begins, 1, -1), 0)
        nearer = np.where((sides > 0).any(1), sign, -sign * (sides < 0).any(1))
        front[open_] = nearer
        open_ = open_[nearer == 0]
    for pair in np.flatnonzero(front == 0).tolist():
        front[pair] = side(int(a[pair]), int(b[pair]))
    before = np.where(front > 0, b, a)
    after = np.where(front > 0, a, b)
    order = np.argsort(-depths.sum(1), kind="stable")
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    if front.all() and (rank[before] < rank[after]).all():
        return [[solid] for solid in order.tolist()]
    hidden_by: list[list[int]] = [[] for _ in range(count)]
    for far, near, knotted in zip(before.tolist(), after.tolist(), front == 0, strict=True):
        hidden_by[near].append(far)
        if knotted:
            hidden_by[far].append(near)
    return _components(hidden_by, order.tolist())


def _components(behind: list[list[int]], order: list[int]) -> list[list[int]]:
    """Strongly connected components, each after all behind it (Tarjan, without recursion)."""
    found: list[list[int]] = []
    index = [-1] * len(behind)
    low = [0] * len(behind)
    open_: list[int] = []
    is_open = [False] * len(behind)
    count = 0
    for root in order:
        if index[root] >= 0:
            continue
        path = [(root, iter(behind[root]))]
        index[root] = low[root] = count
        count += 1
        open_.append(root)
        is_open[root] = True
        while path:
            node, rest = path[-1]
            for other in rest:
                if index[other] < 0:
                    index[other] = low[other] = count
                    count += 1
                    open_.append(other)
                    is_open[other] = True
                    path.append((other, iter(behind[other])))
                    break
                if is_open[other]:
                    low[node] = min(low[node], index[other])
            else:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[node])
                if low[node] == index[node]:
                    first = open_.index(node)
                    found.append(sorted(open_[first:]))
                    for member in open_[first:]:
                        is_open[member] = False
                    del open_[first:]
    return found


def separating_plane(
    a: Floats, b: Floats, axes: Floats, radius_a: float = 0.0, radius_b: float = 0.0
) -> tuple[Floats, float] | None:
    """A plane with ``a`` behind it and ``b`` before it: normal and offset; None when there is none.

    ``a`` and ``b`` are corners (n, 3), swollen by the radii. ``axes`` (m, 3) are tried in both
    directions: for two polyhedra their face normals and the products of their edges suffice
    (separating axis theorem).
    """
    lengths = np.sqrt((axes * axes).sum(1))
    axes = axes[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    on_a, on_b = axes @ a.T, axes @ b.T
    low_a, high_a = on_a.min(1) - radius_a, on_a.max(1) + radius_a
    low_b, high_b = on_b.min(1) - radius_b, on_b.max(1) + radius_b
    gaps = np.concatenate([low_b - high_a, low_a - high_b])
    best = int(gaps.argmax())
    if gaps[best] < -_TOUCH:
        return None
    if best < len(axes):
        return axes[best], float(high_a[best] + low_b[best]) / 2
    best -= len(axes)
    return -axes[best], -float(high_b[best] + low_a[best]) / 2
