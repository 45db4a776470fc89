"""Upright lines that were pushed far out come back beside what they pass."""

from __future__ import annotations

from itertools import pairwise

from fsm.drawing.rows import Item, Rows, Wires, gap

_NEAR = 0.5
"""What is no further apart makes one upright line."""


def tighten(rows: Rows) -> None:
    """Move upright runs of lines and labels towards what they join, as far as there is room."""
    touching: dict[Item, list[Wires]] = {}
    for wires in rows.wires.values():
        for item, _ in wires.terminals:
            touching.setdefault(item, []).append(wires)
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


def _ends(run: list[Item], touching: dict[Item, list[Wires]]) -> list[float]:
    """Where the things are that a run leads to and from."""
    inside = set(run)
    return [
        other.x
        for item in run
        for wires in touching.get(item, ())
        for other, _ in wires.terminals
        if other not in inside
    ]


def _runs(rows: Rows, touching: dict[Item, list[Wires]]) -> list[list[Item]]:
    """Ways and labels that make one upright line, from above."""
    found: list[list[Item]] = []
    run_of: dict[Item, list[Item]] = {}
    for row in rows.rows:
        for item in row:
            if item.kind not in ("way", "label"):
                continue
            above = next(
                (
                    other
                    for wires in touching.get(item, ())
                    for other, _ in wires.terminals
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
