"""Lanes over areas of all shapes: all is seen, nothing else is flown over, the way is short."""

from __future__ import annotations

from itertools import pairwise
from math import cos, degrees, dist, hypot, pi, sin

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import LineString, Polygon

from behaviors.coverage import Lanes, lanes_over
from behaviors.plan import Unflyable
from behaviors.polygons import area_of
from behaviors.strips import Footprint
from vencejo.geometry import rotate_xy
from vencejo.polylines import XY

SQUARE = [(0.0, 0.0), (20.0, 0.0), (20.0, 12.0), (0.0, 12.0)]
SHAPES: dict[str, tuple[list[XY], list[list[XY]]]] = {
    "square": (SQUARE, []),
    "L": ([(0, 0), (40, 0), (40, 15), (15, 15), (15, 40), (0, 40)], []),
    "U": ([(0, 0), (60, 0), (60, 40), (40, 40), (40, 15), (20, 15), (20, 40), (0, 40)], []),
    "hole": ([(0, 0), (50, 0), (50, 40), (0, 40)], [[(20, 15), (30, 15), (30, 25), (20, 25)]]),
    "two holes": (
        [(0, 0), (60, -5), (70, 30), (30, 50), (-5, 40)],
        [[(15, 10), (25, 8), (22, 20)], [(40, 15), (50, 18), (45, 30), (38, 25)]],
    ),
    "triangle": ([(0, 0), (50, 5), (20, 40)], []),
    "clockwise": (SQUARE[::-1], []),
}


def seen(lanes: Lanes, area: Polygon, across: float, ahead: float) -> float:
    """The share of an area that a footprint along the lanes sees, on the way between them too."""
    places = [rotate_xy(x, y, -lanes.axis) for x, y in lanes.places]
    legs = [*pairwise(places)] or [(places[0], places[0])]
    offsets = [(dx, dy) for dx in (-ahead, ahead) for dy in (-across / 2, across / 2)]
    swept = [
        shapely.MultiPoint([(x + dx, y + dy) for x, y in leg for dx, dy in offsets]).convex_hull
        for leg in legs
    ]
    turned = shapely.transform(
        area, lambda points: np.array([rotate_xy(x, y, -lanes.axis) for x, y in points])
    )
    return float(shapely.union_all(swept).intersection(turned).area / area.area)


def outside(lanes: Lanes, area: Polygon) -> float:
    """The length of the way that is not over the area, metres."""
    return float(LineString(lanes.places).difference(area.buffer(1e-3)).length)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("across", [2.0, 5.0])
def test_all_is_seen_from_inside_on_a_short_way(name: str, across: float) -> None:
    corners, holes = SHAPES[name]
    area = Polygon(corners, holes)
    lanes = lanes_over(corners, holes, Footprint(across, across / 2), 2.0)
    assert seen(lanes, area, across, across / 2) > 0.999
    assert outside(lanes, area) < 1e-6
    assert lanes.length < 1.35 * area.area / across


def test_the_lanes_of_a_rectangle_lie_along_it() -> None:
    lanes = lanes_over(SQUARE, [], Footprint(4.0, 2.0), 2.0, (0.0, 0.0))
    assert all(type(number) is float for place in lanes.places for number in place)
    assert [lane.line for lane in lanes.lanes] == [
        ((2.0, 2.0), (18.0, 2.0)),
        ((18.0, 6.0), (2.0, 6.0)),
        ((2.0, 10.0), (18.0, 10.0)),
    ]
    assert lanes.length == pytest.approx(56.0)
    # From the other side it begins there.
    far = lanes_over(SQUARE, [], Footprint(4.0, 2.0), 2.0, (30.0, 12.0))
    assert far.places[0] == pytest.approx((18.0, 10.0))


def test_the_direction_is_the_fastest_or_as_given() -> None:
    turned = [rotate_xy(x, y, 0.4) for x, y in SQUARE]
    assert lanes_over(turned, [], Footprint(4.0, 2.0), 2.0).axis == pytest.approx(0.4, abs=1e-5)
    upright = lanes_over(SQUARE, [], Footprint(4.0, 2.0), 2.0, None, pi / 2)
    assert len(upright.lanes) == 5
    assert {round(x, 6) for x, _ in upright.places} == {2.0, 6.0, 10.0, 14.0, 18.0}


@pytest.mark.parametrize("number", range(6))
def test_a_convex_area_takes_hardly_more_than_the_best_way_of_all_headings(number: int) -> None:
    count = 3 + number
    corners = [
        ((20 + 3 * (k % 2)) * cos(2 * pi * k / count + 0.3), 16 * sin(2 * pi * k / count + 0.3))
        for k in range(count)
    ]
    assert Polygon(corners).convex_hull.area == pytest.approx(Polygon(corners).area)
    lanes = lanes_over(corners, [], Footprint(4.0, 1.7, 0.5), 2.0)
    best = min(_to_and_fro(corners, 4.0, 1.7, pi * k / 180) for k in range(180))
    assert lanes.length <= 1.15 * best


def _to_and_fro(corners: list[XY], across: float, ahead: float, axis: float) -> float:
    """The way of straight lanes along one direction, each as long as the area in its middle."""
    area = Polygon([rotate_xy(x, y, -axis) for x, y in corners])
    west, low, east, high = area.bounds
    count = -int(-(high - low) // across)
    ends: list[XY] = []
    for k in range(count):
        y = low + (k + 0.5) * (high - low) / count
        begin, _, end, _ = area.intersection(LineString([(west, y), (east, y)])).bounds
        line = [
            (min(begin + ahead, (begin + end) / 2), y),
            (max(end - ahead, (begin + end) / 2), y),
        ]
        ends += line if k % 2 == 0 else line[::-1]
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(ends))


@st.composite
def fields(draw: st.DrawFn) -> tuple[list[XY], list[list[XY]]]:
    """A star-shaped polygon, and perhaps holes inside it."""
    radii = draw(st.lists(st.floats(6, 30), min_size=3, max_size=9))
    turn = draw(st.floats(0, 6))
    corners = [
        (r * cos(turn + 2 * pi * k / len(radii)), r * sin(turn + 2 * pi * k / len(radii)))
        for k, r in enumerate(radii)
    ]
    outer, holes = Polygon(corners), list[list[XY]]()
    for x, y, size, count in draw(
        st.lists(
            st.tuples(st.floats(-12, 12), st.floats(-12, 12), st.floats(1, 4), st.integers(3, 6)),
            max_size=3,
        )
    ):
        hole = [
            (x + size * cos(2 * pi * k / count), y + size * sin(2 * pi * k / count))
            for k in range(count)
        ]
        apart = all(Polygon(hole).distance(Polygon(other)) > 1 for other in holes)
        if apart and outer.buffer(-1.0).covers(Polygon(hole)):
            holes.append(hole)
    return corners, holes


@settings(max_examples=12, deadline=None, derandomize=True)
@given(fields(), st.floats(1.5, 6.0))
def test_any_field_is_seen_whole_from_inside(
    field: tuple[list[XY], list[list[XY]]], across: float
) -> None:
    corners, holes = field
    area = Polygon(corners, holes)
    assume(area.is_valid and area.area > 50)
    ahead = 0.4 * across
    lanes = lanes_over(corners, holes, Footprint(across, ahead), 2.0, (0.0, 0.0))
    assert seen(lanes, area, across, ahead) > 0.99
    assert outside(lanes, area) < 1e-6
    # A footprint that is wider than the lanes are apart may leave out ends that it sees anyway.
    wider = lanes_over(corners, holes, Footprint(across, ahead, 0.12 * across), 2.0, (0.0, 0.0))
    assert seen(wider, area, 1.24 * across, ahead) > 0.99
    assert outside(wider, area) < 1e-6


def test_an_area_that_its_hole_parts_is_flown_in_both_parts() -> None:
    corners, holes = SHAPES["hole"][0], [[(20.0, -5.0), (30.0, -5.0), (30.0, 45.0), (20.0, 45.0)]]
    area = area_of(corners, holes)
    lanes = lanes_over(corners, holes, Footprint(4.0, 2.0), 2.0)
    assert seen(lanes, area, 4.0, 2.0) > 0.999
    # It leaves the area only to come from one part to the other.
    assert 9.9 < outside(lanes, area) < 15


@pytest.mark.parametrize(
    ("corners", "holes", "across", "message"),
    [
        (SQUARE, [[(-1.0, -1.0), (21.0, -1.0), (21.0, 13.0), (-1.0, 13.0)]], 2.0, "leave nothing"),
        ([(0.0, 0.0), (1e6, 0.0), (1e6, 1e6), (0.0, 1e6)], [], 2.0, "in 500000 lanes"),
    ],
)
def test_what_cannot_be_flown_says_so(
    corners: list[XY], holes: list[list[XY]], across: float, message: str
) -> None:
    with pytest.raises(Unflyable, match=message):
        lanes_over(corners, holes, Footprint(across, across / 2), 2.0)


def test_a_speck_is_one_place() -> None:
    lanes = lanes_over([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], [], Footprint(5.0, 2.5), 2.0)
    assert len(lanes.places) == 1 and degrees(lanes.axis) < 180
    assert lanes.length == 0.0


RAGGED = [
    (-20.4, 17.9), (-8, 6), (-22, -2), (-9, -4), (-18, -21), (-1, -9), (6, -22), (8, -3), (21, -9),
    (12, 4), (23, 17), (4, 9), (-2, 22), (-4, 8),
]  # fmt: skip


@pytest.mark.parametrize("axis", [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0])
def test_a_strip_that_is_forked_or_hollow_is_seen_whole(axis: float) -> None:
    area = Polygon(RAGGED)
    assert area.is_valid
    lanes = lanes_over(RAGGED, [], Footprint(5.0, 2.0), 2.0, None, axis)
    assert seen(lanes, area, 5.0, 2.0) > 0.995
    assert outside(lanes, area) < 1e-6


def test_of_two_arms_in_one_strip_both_are_seen() -> None:
    fork = [(0, 0), (20, 0), (20, 1), (2, 1), (2, 4), (20, 4), (20, 5), (0, 5)]
    lanes = lanes_over(fork, [], Footprint(5.0, 2.0), 2.0, None, 0.0)
    assert seen(lanes, Polygon(fork), 5.0, 2.0) > 0.999
    assert outside(lanes, Polygon(fork)) < 1e-6


def test_what_is_seen_beside_another_lane_is_not_flown_for() -> None:
    # 40 cm of a bump reach into the upper strip, which is there for the tower.
    tower = [
        (0, 0), (20, 0), (20, 4), (14, 4), (14, 4.4), (10, 4.4), (10, 4), (4, 4), (4, 8), (0, 8),
    ]  # fmt: skip
    plain = lanes_over(tower, [], Footprint(4.0, 1.0), 2.0, None, 0.0)
    wider = lanes_over(tower, [], Footprint(4.0, 1.0, 0.5), 2.0, None, 0.0)
    assert (len(plain.lanes), len(wider.lanes)) == (3, 2)
    assert seen(wider, Polygon(tower), 5.0, 1.0) > 0.999
    # Nor does a lane go into a corner that the next one sees.
    slanted = [(0.0, 0.0), (20.0, 0.0), (28.0, 8.0), (8.0, 8.0)]
    plain = lanes_over(slanted, [], Footprint(4.0, 1.0), 2.0, None, 0.0)
    wider = lanes_over(slanted, [], Footprint(4.0, 1.0, 0.5), 2.0, None, 0.0)
    assert wider.length < plain.length - 0.5
    assert seen(wider, Polygon(slanted), 5.0, 1.0) > 0.999


@pytest.mark.parametrize("turn", [0.0, pi / 2, 1.1, 2.3])
def test_however_an_area_is_turned_it_takes_as_many_lanes(turn: float) -> None:
    turned = [rotate_xy(x, y, turn) for x, y in SQUARE]
    lanes = lanes_over(turned, [], Footprint(4.0, 2.0), 2.0)
    assert len(lanes.lanes) == 3 and lanes.length == pytest.approx(56.0)


def test_turns_count_the_more_the_faster_it_flies() -> None:
    band = [(0.0, 0.0), (40.0, 0.0), (40.0, 6.0), (0.0, 6.0)]
    across, along = (lanes_over(band, [], Footprint(4.0, 2.5), speed) for speed in (2.0, 6.0))
    assert (across.axis, len(across.lanes)) == (pytest.approx(pi / 2), 10)
    assert (along.axis % pi, len(along.lanes)) == (pytest.approx(0.0), 2)
    assert across.length < along.length


def test_a_way_passes_corners_with_some_room() -> None:
    corners, holes = SHAPES["U"]
    lanes = lanes_over(corners, holes, Footprint(5.0, 2.5), 2.0, (0.0, 40.0), pi / 2)
    passed = [place for lane in lanes.lanes for place in lane.approach]
    assert passed
    for place in passed:
        assert min(dist(place, corner) for corner in corners) == pytest.approx(0.3)


STAR = [
    (21.6, 0.0), (19.5, 10.2), (5.3, 7.7), (2.6, 21.6), (-3.3, 8.7), (-12.3, 10.9), (-11.5, 2.8),
    (-7.3, -1.8), (-15.8, -14.0), (-8.6, -22.6), (1.3, -10.8), (13.3, -19.2), (10.3, -5.4),
]  # fmt: skip


def test_parts_are_flown_in_a_short_order() -> None:
    lanes = lanes_over(STAR, [], Footprint(5.0, 2.0), 2.0, (0.0, 0.0), 0.3)
    assert lanes.length < 240  # always to the nearest part next it is 256 m
