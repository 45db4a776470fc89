"""Lines of straight legs, and where they meet."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vencejo.polylines import crossing_of, legs_meet


@pytest.mark.parametrize(
    ("line", "crosses"),
    [
        ([(0, 0), (9, 0), (9, 9), (5, -5)], True),
        ([(0, 0), (9, 0), (9, 9), (0, 9), (0, 0)], False),
        ([(0, 0), (9, 0), (9, 9), (4, 0)], True),  # ends on itself
        ([(0, 0), (1, 0), (2, 0), (3, 0)], False),
        ([(0, 0), (1, 1), (2, 2), (3, 3)], False),
        ([(0, 0), (5, 0), (5, 1), (3, 1), (3, 0), (9, 0)], True),  # runs along itself
        ([(0, 0), (9, 9), (4, 4)], True),  # turns back
        ([(0, 0), (9, 0), (0, 0)], True),
        ([(0, 0), (9, 0), (9, 9), (-5, 0), (0, 0)], False),
        ([(0, 0), (9, 0), (9, 9), (5, 0), (0, 0)], True),  # turns back where it closes
    ],
)
def test_crossings(line: list[tuple[float, float]], crosses: bool) -> None:
    assert (crossing_of(line) is not None) == crosses


def _turns_back(line: list[tuple[float, float]]) -> bool:
    return any(crossing_of(list(three)) for three in zip(line, line[1:], line[2:], strict=False))


@given(st.lists(st.tuples(*[st.integers(-9, 9).map(float)] * 2), min_size=2, max_size=12))
def test_skipping_far_legs_misses_nothing(line: list[tuple[float, float]]) -> None:
    line = [line[0], *(b for a, b in pairwise(line) if a != b)]
    legs = list(pairwise(line))
    crosses = any(legs_meet(*one, *other) for k, one in enumerate(legs) for other in legs[k + 2 :])
    if len(line) > 1 and line[0] != line[-1] and not _turns_back(line):
        assert (crossing_of(line) is not None) == crosses
