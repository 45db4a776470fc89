"""Centre lines on maps of the ground: every kind of road, and what is no road."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import atan2, cos, dist, hypot, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors.perception.centre_line import CentreLine, Node, Widths, find, trace
from behaviors.perception.ground_map import GroundMap
from tests.behaviors.perception.roads import XY, drawn, frame_at, mapped

WIDTHS = Widths(0.3, 3.0)


def traced(
    ground: GroundMap, begin: XY = (-5.0, 0.0), heading: float = 0.0, width: float = 0.8
) -> CentreLine:
    return trace(ground, [Node(*begin, heading, 0.0)], width, WIDTHS, 1.0, reach=30.0)


def away(line: CentreLine, truth: Sequence[XY]) -> float:
    """The greatest distance of the line's road from a polyline, metres."""
    places = np.concatenate(
        [np.linspace(a, b, max(2, round(dist(a, b) / 0.01))) for a, b in pairwise(truth)]
    )
    nodes = np.array([node[:2] for node in line.nodes if node.is_road])
    return float(np.hypot(*(nodes[:, None] - places).transpose(2, 0, 1)).min(1).max())


def ends_at(line: CentreLine, place: XY) -> bool:
    return hypot(line.nodes[-1].x - place[0], line.nodes[-1].y - place[1]) < 0.1


def arc(radius: float, turn: float, begin: XY = (-3.0, 0.0)) -> list[XY]:
    """A straight, a bend to the left, and a straight again."""
    x, y = begin
    angles = np.linspace(0, turn, 40)
    bend = [(x + radius * sin(a), y + radius * (1 - cos(a))) for a in angles]
    (u, v) = bend[-1]
    return [(x - 2.5, y), *bend, (u + 1.5 * cos(turn), v + 1.5 * sin(turn))]


def test_a_straight_road_is_followed_to_its_end() -> None:
    line = traced(mapped([[(-6, 0), (4, 0)]]))
    assert line.ending == "end" and ends_at(line, (4, 0))
    assert away(line, [(-6, 0), (4, 0)]) < 0.03
    assert line.width == pytest.approx(0.8, abs=0.05)


@settings(deadline=None, max_examples=40)
@given(st.floats(1.0, 6.0), st.floats(0.2, 2.5), st.floats(0.5, 1.2))
def test_bends_are_followed(radius: float, turn: float, width: float) -> None:
    radius = max(radius, 1.4 * width)
    road = arc(radius, turn if radius * turn < 6 else 6 / radius)
    line = traced(mapped([road], width), width=width)
    assert away(line, road) < 0.12 * width + 0.02
    assert hypot(line.nodes[-1].x - road[-1][0], line.nodes[-1].y - road[-1][1]) < 0.3


@pytest.mark.parametrize("turn", [-115, -90, -60, -45, 45, 60, 90, 115])
def test_sharp_corners_are_turned_in_their_middle(turn: float) -> None:
    way = radians(turn)
    end = (3.5 * cos(way), 3.5 * sin(way))
    road = [(-6.0, 0.0), (0.0, 0.0), end]
    line = traced(mapped([road]))
    assert (
        line.ending == "end" and hypot(line.nodes[-1].x - end[0], line.nodes[-1].y - end[1]) < 0.2
    )
    assert away(line, road) < 0.2
    assert min(hypot(node.x, node.y) for node in line.nodes) < 0.2


def test_a_hairpin_of_two_corners_leads_back() -> None:
    road = [(-6.0, 0.0), (1.0, 0.0), (1.0, 2.5), (-4.5, 2.5)]
    line = traced(mapped([road]))
    assert line.ending == "end" and ends_at(line, (-4.5, 2.5)) and away(line, road) < 0.12


def test_a_sharp_hairpin_leads_back() -> None:
    way = radians(150)
    end = (5 * cos(way), 5 * sin(way))
    line = traced(mapped([[(-6.0, 0.0), (0.0, 0.0), end]], 0.6), width=0.6)
    assert hypot(line.nodes[-1].x - end[0], line.nodes[-1].y - end[1]) < 0.4


@pytest.mark.parametrize("gap", [0.3, 0.6, 0.95])
@pytest.mark.parametrize("radius", [None, 3.0])
def test_gaps_are_crossed(gap: float, radius: float | None) -> None:
    if radius is None:
        first, second = [(-6.0, 0.0), (-1.0, 0.0)], [(-1.0 + gap, 0.0), (4.0, 0.0)]
    else:
        road = arc(radius, 1.8)
        passed = np.cumsum([0, *(dist(a, b) for a, b in pairwise(road))])
        first = [p for p, way in zip(road, passed, strict=True) if way <= 5]
        second = [p for p, way in zip(road, passed, strict=True) if way >= 5 + gap]
    line = traced(mapped([first, second]))
    assert line.ending == "end" and hypot(*np.subtract(line.nodes[-1][:2], second[-1])) < 0.2
    assert radius or any(not node.is_road for node in line.nodes)


def test_a_longer_gap_is_the_end() -> None:
    line = traced(mapped([[(-6, 0), (-1, 0)], [(0.5, 0), (4, 0)]]))
    assert line.ending == "end" and ends_at(line, (-1, 0))


@pytest.mark.parametrize("turn", [30, 45, 60, 90, 120, -30, -60, -90])
def test_where_another_road_leaves_it_goes_straight_on(turn: float) -> None:
    way = radians(turn)
    branch = [(0.0, 0.0), (4 * cos(way), 4 * sin(way))]
    line = traced(mapped([[(-6, 0), (5, 0)], branch]))
    assert ends_at(line, (5, 0)) and away(line, [(-6, 0), (5, 0)]) < 0.12


def test_a_crossing_is_passed() -> None:
    line = traced(mapped([[(-6, 0), (5, 0)], [(0, -4), (0, 4)]]))
    assert ends_at(line, (5, 0)) and away(line, [(-6, 0), (5, 0)]) < 0.05


@settings(deadline=None, max_examples=50)
@given(st.floats(-2, 2), st.floats(0.4, 1.6), st.floats(0.0, 3.1), st.floats(0.5, 2.0))
def test_a_patch_beside_it_is_left_alone(x: float, wide: float, turn: float, long: float) -> None:
    aside = 0.4 + hypot(long, wide) / 2
    dx, dy = long / 2 * cos(turn), long / 2 * sin(turn)
    patch = [(x - dx, aside - dy), (x + dx, aside + dy)]
    ground = GroundMap(0.04)
    frame = frame_at()
    both = np.maximum(drawn(frame, [[(-6, 0), (5, 0)]], 0.8), drawn(frame, [patch], wide))
    ground.add(both, frame)
    line = traced(ground)
    assert ends_at(line, (5, 0)) and away(line, [(-6, 0), (5, 0)]) < 0.15


def test_what_was_not_seen_is_open() -> None:
    line = traced(mapped([[(-6, 0), (40, 0)]]))
    assert line.ending == "open" and line.nodes[-1].x > 5


def test_where_there_is_no_road_there_is_no_line() -> None:
    line = traced(mapped([[(-6, 5), (4, 5)]]))
    assert line.ending == "none" and len(line.nodes) == 1


def test_the_nearest_road_is_found_with_its_two_ways() -> None:
    found = find(mapped([[(-6, 1), (6, 1)], [(-6, 4), (6, 4)]]), (0.0, 0.0), WIDTHS, 1.0)
    assert found is not None and found.width == pytest.approx(0.8, abs=0.1)
    assert sorted(round(abs(way.heading), 1) for way in found.ways) == [0.0, 3.1]
    assert all(way.y == pytest.approx(1.0, abs=0.06) for way in found.ways)


def test_a_patch_is_no_road() -> None:
    assert find(mapped([[(0, 0.5), (1, 0.5)]]), (0.0, 0.0), WIDTHS, 1.0) is None
    found = find(mapped([[(0, 0.8), (0.9, 0.8)], [(-6, 3), (6, 3)]]), (0.0, 0.0), WIDTHS, 1.0)
    assert found is not None and found.ways[0].y == pytest.approx(3.0, abs=0.06)


@pytest.mark.parametrize("value", [0, 255])
def test_one_colour_everywhere_is_no_road(value: int) -> None:
    ground, frame = GroundMap(0.04), frame_at()
    ground.add(np.full((480, 640), value, np.uint8), frame)
    assert find(ground, (0.0, 0.0), WIDTHS, 1.0) is None
    assert traced(ground).ending in ("none", "open")


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 2**32 - 1))
def test_noise_is_traced_without_a_fault(seed: int) -> None:
    random = np.random.default_rng(seed)
    coarse = (random.random((24, 32)) < 0.5).astype(np.uint8) * 255
    mask = np.kron(coarse, np.ones((20, 20), np.uint8))
    ground, frame = GroundMap(0.04), frame_at()
    ground.add(mask, frame)
    begin = find(ground, (0.0, 0.0), WIDTHS, 1.0)
    line = traced(ground, (0.0, 0.0), float(random.uniform(-pi, pi)))
    for nodes in (line.nodes, begin.ways if begin else ()):
        assert np.isfinite(np.array(nodes, float)).all()
    for a, b in pairwise(line.nodes):
        assert hypot(b.x - a.x, b.y - a.y) < 3.0
        assert -pi <= atan2(sin(b.heading), cos(b.heading)) <= pi
