"""The states of a flight over time, in lanes: what is active together lies side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from hal import PERIOD
from runner.telemetry import Sample


@dataclass(frozen=True)
class Bar:
    """A leaf state that was active without a break."""

    state: str
    begin: float
    """Seconds of the vehicle's clock, as ``end``."""
    end: float


Lane = list[Bar]
"""Bars that follow one another."""


def lanes_of(samples: Sequence[Sample]) -> list[Lane]:
    """The bars of a flight, in as many lanes as there were states active at once.

    There must be a sample. A bar lies in the free lane whose last state is nearest to it in the
    graph, so that each region of a parallel state has a lane of its own.
    """
    lanes: list[Lane] = []
    for bar in _bars(samples):
        free = [lane for lane in lanes if lane[-1].end <= bar.begin]
        if free:
            max(free, key=lambda lane: _in_common(bar.state, lane[-1].state)).append(bar)
        else:
            lanes.append([bar])
    return lanes


def _bars(samples: Sequence[Sample]) -> list[Bar]:
    """All bars in the order of their begin; of those that begin together, in document order."""
    begun: dict[str, tuple[float, int]] = {}
    ended: list[tuple[tuple[float, int], Bar]] = []

    def end(state: str, time: float) -> None:
        ended.append((begun[state], Bar(state, begun[state][0], time)))

    for sample in samples:
        if sample.states != tuple(begun):
            for state in begun:
                if state not in sample.states:
                    end(state, sample.time)
            ranks = {state: (sample.time, n) for n, state in enumerate(sample.states)}
            begun = {state: begun.get(state, rank) for state, rank in ranks.items()}
    for state in begun:
        end(state, samples[-1].time + PERIOD)
    return [bar for _, bar in sorted(ended, key=lambda each: each[0])]


def _in_common(state: str, other: str) -> int:
    """The number of ancestors that two states share."""
    names = zip(state.split("."), other.split("."), strict=False)
    return next((n for n, (a, b) in enumerate(names) if a != b), 0)


def states_of(lanes: Iterable[Lane]) -> list[str]:
    """The states of some lanes, each once."""
    return list(dict.fromkeys(bar.state for lane in lanes for bar in lane))
