"""Coordinates along one axis: as near as possible to the wished ones, in order and with gaps."""

from __future__ import annotations

from collections.abc import Sequence


def settle(wished: Sequence[float], weights: Sequence[float], gaps: Sequence[float]) -> list[float]:
    """Coordinates with ``x[i + 1] - x[i] >= gaps[i]``, at the least weighted square distance.

    Isotonic regression by pooling adjacent violators (Ayer et al. 1955): exact, in linear time.
    """
    pools: list[tuple[float, float, int]] = []
    offset, offsets = 0.0, []
    for index, (wish, weight) in enumerate(zip(wished, weights, strict=True)):
        offset += gaps[index - 1] if index else 0.0
        offsets.append(offset)
        mean, mass, count = wish - offset, weight, 1
        while pools and pools[-1][0] > mean:
            other, other_mass, other_count = pools.pop()
            mean = (mean * mass + other * other_mass) / (mass + other_mass)
            mass, count = mass + other_mass, count + other_count
        pools.append((mean, mass, count))
    places = [mean for mean, _, count in pools for _ in range(count)]
    return [place + offset for place, offset in zip(places, offsets, strict=True)]


def slots(
    wished: Sequence[float], taken: Sequence[float], low: float, high: float, gap: float
) -> list[float]:
    """Coordinates between ``low`` and ``high``, each ``gap`` from the others and from those taken.

    There is always room when ``high - low`` is at least twice the gap for each of them.
    """
    if not wished:
        return []
    order = sorted(range(len(wished)), key=lambda index: (wished[index], index))
    spread = min(gap, (high - low) / max(1, len(wished) - 1))
    near = settle([wished[i] for i in order], [1.0] * len(order), [spread] * (len(order) - 1))
    steps = int((high - low) / gap)
    grid = [low + gap * step for step in range(steps + 1)]
    used = list(taken)
    found = [0.0] * len(wished)
    for place, index in enumerate(order):
        least, most = low + spread * place, high - spread * (len(order) - 1 - place)
        wish = min(max(near[place], least), most)
        free = [x for x in (wish, *grid) if all(abs(x - other) >= gap - 1e-6 for other in used)]
        found[index] = min(free, key=lambda x: (abs(x - wish), x))
        used.append(found[index])
    return found
