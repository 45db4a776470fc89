"""Paths: lines with arcs, splines, and what they say of themselves."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from behaviors.path import Corner, Path, angle_between, blended, spline, turns_back
from vencejo.geometry import Point, distance

coordinate = st.floats(-20, 20)
points = st.builds(Point, coordinate, coordinate, coordinate)


def sampled(path: Path, step: float = 0.01) -> list[Point]:
    return [path.place(k * step) for k in range(int(path.length / step) + 2)]


def corners(places: list[Point], deviation: float = 0.25) -> list[Corner]:
    return [Corner(place, deviation) for place in places]


SQUARE = [Point(0, 0, 2), Point(6, 0, 2), Point(6, 6, 2), Point(0, 6, 2)]


def test_a_right_angle_is_passed_in_an_arc_within_its_deviation() -> None:
    path, ways = blended(corners(SQUARE))
    # The arc of radius r passes its corner at r·(√2 − 1).
    r = 0.25 / (2**0.5 - 1)
    assert path.length == pytest.approx(18 - 2 * (2 * r - r * pi / 2))
    for corner, way in zip(SQUARE[1:3], ways[1:3], strict=True):
        assert distance(path.place(way), corner) == pytest.approx(0.25, abs=1e-4)
    assert max(path.bends()) == pytest.approx(1 / r, rel=0.01)
    assert (path.place(0), path.place(99)) == (SQUARE[0], SQUARE[3])


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(points, min_size=2, max_size=6), st.floats(0.01, 3))
def test_it_passes_every_corner_within_the_deviation_and_has_no_kink(
    places: list[Point], deviation: float
) -> None:
    for a, b in pairwise(places):
        assume(distance(a, b) > 0.05)
    for a, b, c in zip(places, places[1:], places[2:], strict=False):
        assume(not turns_back(a, b, c))
    path, ways = blended(corners(places, deviation))
    for corner, way in zip(places, ways, strict=True):
        assert distance(path.place(way), corner) <= deviation + 1e-3
    # Its ways are the lengths flown, and its places follow its directions.
    for way in np.linspace(0.0, path.length - 1e-3, 40):
        moved = path.place(way + 1e-3).minus(path.place(way))
        assert moved.norm() == pytest.approx(1e-3, rel=0.02)
        ahead = Point(*(part / moved.norm() for part in moved))
        assert angle_between(ahead, path.direction(way)) < 0.12


def test_points_that_are_one_and_points_in_line_make_no_arc() -> None:
    line = [Point(0, 0, 2), Point(2, 0, 2), Point(2, 0, 2), Point(5, 0, 2)]
    path, ways = blended(corners(line))
    assert ways == pytest.approx([0, 2, 2, 5]) and path.bends() == pytest.approx([0, 0])
    alone, ways = blended(corners([line[0], line[0]]))
    assert (alone.length, alone.place(1.0), ways) == (0.0, line[0], [0.0, 0.0])


def test_what_turns_back() -> None:
    there, here = Point(4, 0, 2), Point(0, 0, 2)
    assert turns_back(here, there, here) and not turns_back(here, there, Point(4, 4, 2))
    assert not turns_back(here, here, there)


def test_a_natural_spline_is_that_of_the_textbook() -> None:
    # Chords of length 5 each; the moments of z solve 2·(5 + 5)·m = 6·((0 − 3)/5 − (3 − 0)/5).
    path, ways = spline([Point(0, 0, 0), Point(4, 0, 3), Point(8, 0, 0)])
    moment = 6 * (-6 / 5) / 20
    middle = (3 + 0) / 2 - (0 + moment) * 5**2 / 16
    place = min(sampled(path, 1e-3), key=lambda p: abs(p.x - 2))
    assert place.z == pytest.approx(middle, abs=2e-3)
    assert path.place(ways[1]) == pytest.approx((4, 0, 3), abs=1e-6)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(st.floats(0.5, 10), st.floats(-1.5, 1.5), st.floats(-2, 2)),
        min_size=2,
        max_size=7,
    )
)
def test_a_spline_passes_its_points_with_one_bend_on_both_sides(
    steps: list[tuple[float, float, float]],
) -> None:
    places, heading = [Point(0, 0, 0)], 0.0
    for length, turn, rise in steps:
        heading += turn
        places.append(places[-1].plus((length * cos(heading), length * sin(heading), rise)))
    path, ways = spline(places)
    for place, way in zip(places, ways, strict=True):
        assert distance(path.place(way), place) < 1e-6
    bends = path.bends()
    for way in ways[1:-1]:
        k = path.node_before(way)
        assert path.ways[k] == way
        assert bends[k - 1] == pytest.approx(bends[k], rel=0.3, abs=0.05)


def test_a_closed_spline_through_a_circle_is_one() -> None:
    places = [Point(3 * cos(k * pi / 6), 3 * sin(k * pi / 6), 2) for k in range(12)]
    path, _ = spline(places, closed=True)
    assert path.length == pytest.approx(6 * pi, rel=1e-3)
    assert all(distance(p, (0, 0, 2)) == pytest.approx(3, abs=2e-3) for p in sampled(path))
    assert max(path.bends()) == pytest.approx(1 / 3, rel=0.03)
    # And it closes without a kink.
    assert angle_between(path.directions[0], path.directions[-1]) < 1e-6
