"""Roads: their lines and what is painted of them."""

from __future__ import annotations

from math import dist, hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from worlds import World, curves
from worlds.loader import read_world
from worlds.things import Stripe

ASPHALT, WHITE = (70, 70, 75), (255, 255, 255)


def world(text: str) -> World:
    return read_world(f"world: w\n{text}", "w.yaml")


def test_a_road_is_a_stripe() -> None:
    roads = world("roads: {r: {through: [[0, 0], [9, 0], [9, 5]], width: 2 m}}")
    assert roads.ground.stripes == (Stripe(((0, 0), (9, 0), (9, 5)), 2.0, ASPHALT),)
    (road,) = roads.roads
    assert (road.name, road.points, road.width) == ("r", ((0, 0), (9, 0), (9, 5)), 2.0)


def test_edge_lines_lie_below_all_surfaces() -> None:
    stripes = world(
        "roads:\n  main: {through: [[0, 0], [9, 0]], edges: white, edge_width: 20 cm}\n"
        "  branch: {through: [[4, 0], [4, 9]], edges: white, width: 2}\n"
    ).ground.stripes
    assert [(stripe.color, stripe.width) for stripe in stripes] == [
        (WHITE, 3.0),
        (WHITE, 2.0),
        (ASPHALT, pytest.approx(2.6)),
        (ASPHALT, pytest.approx(1.7)),
    ]


def test_gaps_are_left_out() -> None:
    stripes = world(
        "roads: {r: {through: [[0, 0], [10, 0], [10, 10]], gaps: [[15, 17], [2, 4 m], [0, 1]]}}"
    ).ground.stripes
    assert [stripe.points for stripe in stripes] == [
        ((1, 0), (2, 0)),
        ((4, 0), (10, 0), (10, 5)),
        ((10, 7), (10, 10)),
    ]


def test_a_smooth_road_bends_and_a_loop_closes() -> None:
    (road,) = world(
        "roads: {r: {through: [[0, 0], [20, 0], [20, 20]], smooth: true, loop: true}}"
    ).roads
    assert road.points[0] == road.points[-1]
    for a, b, c in zip(road.points, road.points[1:], road.points[2:], strict=False):
        (p, q), (u, v) = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
        assert (p * u + q * v) / (hypot(p, q) * hypot(u, v)) > 0.9
        assert dist(a, b) < 1.5


def test_a_crossing_can_be_wanted() -> None:
    text = "roads: {r: {through: [[0, 0], [9, 0], [9, 9], [5, -5]], crossing: true}}"
    assert len(world(text).roads) == 1


points = st.lists(
    st.tuples(*[st.integers(-20, 20).map(float)] * 2), min_size=3, max_size=12, unique=True
)


@given(points)
def test_a_curve_passes_all_points_densely(line: list[tuple[float, float]]) -> None:
    curve = curves.smooth(line)
    assert set(line) <= set(curve)
    assert (curve[0], curve[-1]) == (line[0], line[-1])
    around = max(map(abs, (v for point in line for v in point))) * 2 + 20
    assert all(abs(x) < around and abs(y) < around for x, y in curve)
    assert curves.length(curve) >= curves.length([line[0], line[-1]]) - 1e-9


@given(points, st.floats(0, 1), st.floats(0, 1))
def test_a_piece_has_the_length_asked_for(
    line: list[tuple[float, float]], one: float, other: float
) -> None:
    long = curves.length(line)
    begin, end = sorted((one * long, other * long))
    if end - begin > 1e-6:
        assert curves.length(curves.piece(line, begin, end)) == pytest.approx(end - begin, abs=1e-6)
