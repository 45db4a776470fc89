"""Compaction: vertical lines that were pushed far out move back beside the states they pass."""

from __future__ import annotations

from itertools import pairwise

from fsm.drawing.rows import Bundle, Item, Rows, gap

_NEAR = 0.5
"""Items whose x differ by less than this, in pixels, make one vertical line."""


def tighten(rows: Rows) -> None:
    """Move vertical runs of lines and labels towards what they join, as far as there is room."""
    touching: dict[Item, list[Bundle]] = {}
    for bundle in rows.bundles.values():
        for item, _ in bundle.terminals:
            touching.setdefault(item, []).append(bundle)
    pairs = [pair for row in rows.rows for pair in pairwise(row)]
    left = {two: one for one, two in pairs}
    right = dict(pairs)
    runs = _runs(rows, touching)
    runs.sort(key=lambda run: run[0].x)
    for run in runs:
        ends = _ends(run, touching)
        room = max((o.x + gap(o, i) for i in run if (o := left.get(i))), default=-1e9)
        _shift(run, min(run[0].x, max(room, *ends)) if ends else run[0].x)
    for run in reversed(runs):
        ends = _ends(run, touching)
        room = min((o.x - gap(i, o) for i in run if (o := right.get(i))), default=1e9)
        _shift(run, max(run[0].x, min(room, *ends)) if ends else run[0].x)


def _shift(run: list[Item], x: float) -> None:
    for item in run:
        item.x = x


def _ends(run: list[Item], touching: dict[Item, list[Bundle]]) -> list[float]:
    """The x of the items that a run joins."""
    inside = set(run)
    return [
        other.x
        for item in run
        for bundle in touching.get(item, ())
        for other, _ in bundle.terminals
        if other not in inside
    ]


def _runs(rows: Rows, touching: dict[Item, list[Bundle]]) -> list[list[Item]]:
    """The runs: dummy items and labels that make one vertical line, from above."""
    found: list[list[Item]] = []
    run_of: dict[Item, list[Item]] = {}
    for row in rows.rows:
        for item in row:
            if item.kind not in ("dummy", "label"):
                continue
            above = next(
                (
                    other
                    for bundle in touching.get(item, ())
                    for other, _ in bundle.terminals
                    if other in run_of and other.row == item.row - 1
                    if abs(other.x - item.x) < _NEAR and run_of[other][-1] is other
                ),
                None,
            )
            run = run_of[above] if above is not None else []
            if not run:
                found.append(run)
            run.append(item)
            run_of[item] = run
    return found
