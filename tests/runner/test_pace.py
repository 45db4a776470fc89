"""Pacing, with a clock that only sleeping moves."""

from __future__ import annotations

import pytest

from runner.pace import Pace


class Wall:
    """A clock that only sleeping moves."""

    def __init__(self) -> None:
        self.now = 100.0
        self.naps: list[float] = []

    def sleep(self, seconds: float) -> None:
        self.naps.append(seconds)
        self.now += seconds


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
def test_pace_keeps_the_factor(factor: float) -> None:
    wall = Wall()
    pace = Pace(factor, lambda: wall.now, wall.sleep)
    for period in range(1, 201):
        pace.wait(period * 0.025)
    assert wall.now - 100.0 == pytest.approx((5.0 - 0.025) / factor)


def test_max_never_sleeps() -> None:
    wall = Wall()
    pace = Pace(None, lambda: wall.now, wall.sleep)
    pace.wait(0.0)
    pace.wait(1000.0)
    assert wall.naps == []


def test_an_interrupt_ends_a_long_wait() -> None:
    wall = Wall()
    pace = Pace(0.001, lambda: wall.now, wall.sleep)
    pace.wait(0.0)
    pace.wait(1.0, lambda: len(wall.naps) >= 3)
    assert len(wall.naps) == 3
