"""The fence of a world."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.cli.run_cli import run_cli
from vencejo.geometry import Point
from worlds.fence import leaves, surrounds
from worlds.loader import read_world
from worlds.world import Fence

L_SHAPE = Fence(((0, 0), (10, 0), (10, 4), (4, 4), (4, 10), (0, 10)))
coordinate = st.floats(-2, 12)


def test_it_is_read_with_floor_and_ceiling_and_closed_by_itself() -> None:
    world = read_world(
        "world: w\nfence: {through: [[-5, -5], [5, -5], [0, 5], [-5, -5]], floor: 50 cm}\n", "w"
    )
    assert world.fence == Fence(((-5, -5), (5, -5), (0, 5)), 0.5, inf)
    assert read_world("world: w\n", "w").fence is None


def test_the_list_of_worlds_shows_it(tmp_path) -> None:  # type: ignore[no-untyped-def]
    file = tmp_path / "w.yaml"
    file.write_text("world: w\nfence: {through: [[-5, -5], [5, -5], [0, 5]], ceiling: 9}\n")
    assert "fence    [-5, -5], [5, -5], [0, 5]; ceiling 9 m" in run_cli("worlds", str(file)).out


@settings(max_examples=200, deadline=None)
@given(coordinate, coordinate)
def test_a_place_is_inside_where_a_rectangle_of_the_two_holds_it(x: float, y: float) -> None:
    inside = (0 <= x <= 10 and 0 <= y <= 4) or (0 <= x <= 4 and 0 <= y <= 10)
    edge = min(abs(v - c) for v in (x, y) for c in (0, 4, 10)) < 1e-5
    assert edge or surrounds(L_SHAPE, x, y) == inside


@settings(max_examples=200, deadline=None)
@given(coordinate, coordinate, coordinate, coordinate)
def test_a_way_leads_out_where_one_of_its_samples_is_outside(
    x: float, y: float, u: float, v: float
) -> None:
    way = np.linspace((x, y), (u, v), 400)
    outside = [not surrounds(L_SHAPE, float(p), float(q)) for p, q in way]
    if leaves(L_SHAPE, Point(x, y, 1), Point(u, v, 1)):
        assert any(outside) or _corner_cut((x, y), (u, v))
    else:
        assert not any(outside)


def _corner_cut(a: tuple[float, float], b: tuple[float, float]) -> bool:
    """Whether a way passes so near a corner that samples may miss what it cuts off."""
    way = np.linspace(a, b, 4000)
    return any(np.hypot(*(way - corner).T).min() < 0.1 for corner in L_SHAPE.corners)


def test_both_ends_inside_are_not_enough_round_a_corner() -> None:
    assert leaves(L_SHAPE, Point(9, 2, 1), Point(2, 9, 1))
    assert not leaves(L_SHAPE, Point(9, 2, 1), Point(2, 2, 1))
    assert not leaves(L_SHAPE, Point(0, 0, 1), Point(10, 0, 1)), "its line is inside"


@pytest.mark.parametrize(
    ("fence", "told"),
    [
        ("{through: [[0, 0], [9, 9], [9, 0], [0, 9]]}", "crosses itself near"),
        ("{through: [[0, 0], [9, 0], [9, 0], [0, 9]]}", "twice in a row"),
        ("{through: [[0, 0], [9, 0], [0, 0]]}", "fence"),
        ("{through: [[0, 0], [9, 0], [0, 9]], floor: 9, ceiling: 3}", "below its ceiling"),
        ("{through: [[5, 5], [9, 5], [9, 9]]}", "outside the fence"),
    ],
)
def test_a_fence_that_is_none_is_told(fence: str, told: str) -> None:
    with pytest.raises(Exception, match=told):
        read_world(f"world: w\nfence: {fence}\n", "w.yaml")
