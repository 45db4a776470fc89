"""Sections of a road on rows of a picture: the rules of the published follower."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from behaviors.perception.road_sections import Runs, Section, road_sections, sections_on
from hal.scene.arrays import Pixels

RUNS = Runs(5, 5)


def row(*spans: tuple[int, int], width: int = 100) -> np.ndarray:
    mask = np.zeros(width, bool)
    for begin, end in spans:
        mask[begin : end + 1] = True
    return mask


def picture(**spans: list[tuple[int, int]]) -> Pixels:
    """A mask of 160 × 120 whose thirds have these spans of road."""
    mask = np.zeros((120, 160), np.uint8)
    for part, rows in (("upper", np.s_[:45]), ("middle", np.s_[45:75]), ("lower", np.s_[75:])):
        for begin, end in spans.get(part, ()):
            mask[rows, begin : end + 1] = 255
    return mask


@pytest.mark.parametrize(
    ("spans", "sections"),
    [
        ([(10, 30)], [(10, 30)]),
        ([(0, 99)], [(0, 99)]),
        ([(95, 99)], [(95, 99)]),
        ([(10, 13)], []),  # too few to begin
        ([(10, 30), (34, 40)], [(10, 40)]),  # too few to end
        ([(10, 30), (36, 40)], [(10, 30), (36, 40)]),
        ([(10, 30), (34, 36)], [(10, 36)]),
    ],
)
def test_sections_begin_and_end_after_some_pixels(
    spans: list[tuple[int, int]], sections: list[tuple[int, int]]
) -> None:
    found = sections_on(row(*spans), 7, RUNS)
    assert found == [Section(7, begin, end) for begin, end in sections]


def test_the_reference_is_the_centre_of_a_section_above() -> None:
    found = road_sections(picture(upper=[(100, 120)], lower=[(70, 90)]), 0.0, 5, RUNS)
    assert (found.upper, found.lower, found.middle_at_edge) == (1, 1, False)
    assert (found.x, found.y) == (110 - 79.5, 59.5 - 25)
    assert 0 < found.angle < pi / 2


def test_of_several_above_the_nearest_to_the_last_one_counts() -> None:
    mask = picture(upper=[(10, 30), (100, 120)])
    assert road_sections(mask, -60.0, 5, RUNS).x == 20 - 79.5
    assert road_sections(mask, 40.0, 5, RUNS).x == 110 - 79.5


def test_of_several_below_the_farthest_counts() -> None:
    mask = picture(lower=[(10, 30), (100, 120)])
    found = road_sections(mask, 40.0, 5, RUNS)
    assert (found.x, found.lower, found.upper) == (20 - 79.5, 2, 0)
    assert found.y < 0 and abs(found.angle) > pi / 2


def test_a_road_that_leaves_by_the_side_gives_that_edge() -> None:
    found = road_sections(picture(middle=[(80, 159)], lower=[(70, 90)]), 0.0, 5, RUNS)
    assert (found.x, found.y, found.middle_at_edge) == (159 - 79.5, 0.0, True)
    assert found.angle == pytest.approx(pi / 2)
    left = road_sections(picture(middle=[(0, 90)], lower=[(70, 90)]), 0.0, 5, RUNS)
    assert (left.x, left.y) == (-79.5, 0.0)


def test_a_single_one_below_is_the_way_back() -> None:
    found = road_sections(picture(lower=[(70, 90)]), 0.0, 5, RUNS)
    assert (found.x, found.y) == (0.5, 59.5 - 85)


def test_a_whole_row_gives_its_left_end() -> None:
    found = road_sections(np.full((120, 160), 255, np.uint8), 0.0, 5, RUNS)
    assert (found.x, found.upper, found.middle_at_edge) == (-79.5, 1, True)


@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_any_mask_gives_something(height: int, width: int, seed: int) -> None:
    mask = (np.random.default_rng(seed).random((height, width)) < 0.5).astype(np.uint8)
    found = road_sections(mask, 0.0, 10, Runs(2, 2))
    assert abs(found.x) <= width / 2 and abs(found.y) <= height / 2
    assert (found.section is None) == (found.x == found.y == found.angle == 0 and not found.section)
