"""Depth order for the painter's algorithm: surfaces that cover others are painted after them.

If a plane separates two convex solids, the one on the camera's side of it cannot be hidden by the
other. Surfaces that no plane separates, or that hide each other in a cycle, come as one group, to
be drawn with a depth buffer. (Sorting by distance alone is wrong for many arrangements.) After
M. E. Newell, R. G. Newell, T. L. Sancha, *A solution to the hidden surface problem*, 1972.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hal.scene.arrays import Float64s

_OVERLAP = 1e-6
"""Solids that reach this far into each other still count as separate, metres."""


def depth_order(
    screen: Float64s,
    depths: Float64s,
    boxes: Float64s,
    eye: Float64s,
    side: Callable[[int, int], int],
) -> list[list[int]]:
    """Groups of surfaces from far to near; a group of several needs a depth buffer.

    Of each surface: ``screen`` (n, 4) left, top, right, bottom in pixels; ``depths`` (n, 2)
    nearest and farthest, metres; ``boxes`` (n, 6) lowest and highest x, y, z, world frame.
    ``side(a, b)`` is asked about pairs that these do not decide: 1 when a is in front of b, −1
    when it is behind, 0 when neither.
    """
    count = len(screen)
    left, top, right, bottom = screen.T
    # Only pairs whose boxes on the screen overlap matter, each pair once.
    overlaps = (left[:, None] <= right) & (top[:, None] <= bottom)
    a, b = np.nonzero(overlaps & overlaps.T)
    once = a < b
    a, b = a[once], b[once]
    # 1 where a is in front of b, −1 where it is behind, 0 where that is not known yet.
    front = (depths[a, 1] <= depths[b, 0] + _OVERLAP) * 1 - (
        depths[b, 1] <= depths[a, 0] + _OVERLAP
    )
    low, high = boxes[:, :3], boxes[:, 3:]
    undecided = np.flatnonzero(front == 0)
    for p, q, sign in ((a, b, 1), (b, a, -1)):
        if not len(undecided):
            break
        ends, begins = high[p[undecided]], low[q[undecided]]
        # 1 where a plane across an axis has p on the camera's side of it, −1 where q.
        sides = np.where(ends <= begins + _OVERLAP, np.where(2 * eye <= ends + begins, 1, -1), 0)
        nearer = np.where((sides > 0).any(1), sign, -sign * (sides < 0).any(1))
        front[undecided] = nearer
        undecided = undecided[nearer == 0]
    for pair in np.flatnonzero(front == 0).tolist():
        front[pair] = side(int(a[pair]), int(b[pair]))
    before = np.where(front > 0, b, a)
    after = np.where(front > 0, a, b)
    order = np.argsort(-depths.sum(1), kind="stable")
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    if front.all() and (rank[before] < rank[after]).all():
        return [[surface] for surface in order.tolist()]
    hidden_by: list[list[int]] = [[] for _ in range(count)]
    for far, near, unordered in zip(before.tolist(), after.tolist(), front == 0, strict=True):
        hidden_by[near].append(far)
        if unordered:
            hidden_by[far].append(near)
    return _components(hidden_by, order.tolist())


def _components(behind: list[list[int]], order: list[int]) -> list[list[int]]:
    """Strongly connected components of a graph, each after all those behind it.

    ``behind``: the neighbours of each node; ``order``: the nodes as they are to be visited.
    R. Tarjan, *Depth-first search and linear graph algorithms*, 1972, without recursion.
    """
    found: list[list[int]] = []
    index = [-1] * len(behind)
    low = [0] * len(behind)
    stack: list[int] = []
    on_stack = [False] * len(behind)
    count = 0
    for root in order:
        if index[root] >= 0:
            continue
        path = [(root, iter(behind[root]))]
        index[root] = low[root] = count
        count += 1
        stack.append(root)
        on_stack[root] = True
        while path:
            node, rest = path[-1]
            for other in rest:
                if index[other] < 0:
                    index[other] = low[other] = count
                    count += 1
                    stack.append(other)
                    on_stack[other] = True
                    path.append((other, iter(behind[other])))
                    break
                if on_stack[other]:
                    low[node] = min(low[node], index[other])
            else:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[node])
                if low[node] == index[node]:
                    first = stack.index(node)
                    found.append(sorted(stack[first:]))
                    for member in stack[first:]:
                        on_stack[member] = False
                    del stack[first:]
    return found


def separating_plane(
    a: Float64s, b: Float64s, axes: Float64s, radius_a: float = 0.0, radius_b: float = 0.0
) -> tuple[Float64s, float] | None:
    """The unit normal and offset of a plane between two convex solids; None when there is none.

    The normal points from ``a`` to ``b``. Each solid is the hull of its corners (n, 3), grown by
    its radius, metres. ``axes`` (m, 3) are tried as normals, in both directions: for two polyhedra
    the normals of their faces and the cross products of their edges suffice (separating axis
    theorem; S. Gottschalk et al., *OBBTree*, SIGGRAPH 1996).
    """
    lengths = np.sqrt((axes * axes).sum(1))
    axes = axes[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    on_a, on_b = axes @ a.T, axes @ b.T
    low_a, high_a = on_a.min(1) - radius_a, on_a.max(1) + radius_a
    low_b, high_b = on_b.min(1) - radius_b, on_b.max(1) + radius_b
    gaps = np.concatenate([low_b - high_a, low_a - high_b])
    best = int(gaps.argmax())
    if gaps[best] < -_OVERLAP:
        return None
    if best < len(axes):
        return axes[best], float(high_a[best] + low_b[best]) / 2
    best -= len(axes)
    return -axes[best], -float(high_b[best] + low_a[best]) / 2
