"""The pace of a path."""

from __future__ import annotations

from itertools import pairwise
from math import inf, pi, sqrt, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors.guidance import BRAKING, acceleration_at
from behaviors.pace import TURN_RATE, Agility, Pace, paced, slowed, timed
from behaviors.path import Corner, Path, blended, spline
from hal.limits import Limits
from vencejo.geometry import Point

ABLE = Agility(3.0)


def line(length: float) -> Path:
    return blended([Corner(Point(0, 0, 2), 0), Corner(Point(length, 0, 2), 0)])[0]


def test_a_line_is_flown_at_speed_and_from_rest_to_rest() -> None:
    pace = paced(line(20.0), [2.0], ABLE)
    gain = acceleration_at(2.0)
    rise, fall = 2 / gain, 2 / (BRAKING * gain)
    assert pace.duration == pytest.approx((20 - rise - fall) / 2 + rise + fall)
    assert (pace.at(0.0), pace.at(99.0)) == ((0.0, 0.0), (20.0, 0.0))
    assert pace.at(rise / 2) == pytest.approx((gain * rise**2 / 8, 1.0))
    assert pace.at(rise + 1.0) == pytest.approx((rise + 2.0, 2.0))


def test_a_short_line_never_comes_to_speed() -> None:
    pace = paced(line(1.0), [5.0], ABLE)
    gain = acceleration_at(5.0)
    assert pace.fastest == pytest.approx(sqrt(2 * gain * BRAKING * gain / (gain * (1 + BRAKING))))


def test_a_bend_is_as_fast_as_tilt_and_turn_allow() -> None:
    corner = [Point(0, 0, 2), Point(20, 0, 2), Point(20, 20, 2)]
    for deviation, most in ((2.0, "tilt"), (0.01, "turn")):
        path, (_, way, _) = blended([Corner(place, deviation) for place in corner])
        pace = paced(path, [5.0] * (len(path.ways) - 1), ABLE)
        radius = deviation / (sqrt(2) - 1)
        bound = sqrt(3.0 * radius) if most == "tilt" else TURN_RATE * radius
        in_bend = [v for w, v in zip(pace.ways, pace.speeds, strict=True) if abs(w - way) < radius]
        assert in_bend and max(in_bend) <= bound * 1.001
        assert max(in_bend) == pytest.approx(bound, rel=0.02)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(st.tuples(st.floats(0.1, 30), st.floats(0.1, 6)), min_size=1, max_size=6),
    st.floats(0.5, 8),
)
def test_nowhere_is_it_faster_or_more_abrupt_than_it_may(
    parts: list[tuple[float, float]], most: float
) -> None:
    places = [Point(0, 0, 2)]
    for k, (length, _) in enumerate(parts):
        step = (length, 0, 0) if k % 2 else (0, length, 0)
        places.append(places[-1].plus(step))
    path, ways = blended([Corner(place, 0.3) for place in places])
    asked = [
        next(speed for (_, speed), way in zip(parts, ways[1:], strict=True) if end <= way + 1e-6)
        for end in path.ways[1:]
    ]
    pace = paced(path, asked, Agility(4.0, speed=most))
    assert pace.speeds[0] == pace.speeds[-1] == 0.0
    assert pace.ways[-1] == pytest.approx(path.length)
    assert pace.fastest <= min(most, max(speed for _, speed in parts)) + 1e-9
    for (t, v), (u, w) in pairwise(zip(pace.times, pace.speeds, strict=True)):
        assert u > t
        assert abs(w - v) <= 2.0 * (u - t) + 1e-6


def test_the_vehicle_bounds_it() -> None:
    assert Agility.of(Limits()).acceleration == pytest.approx(0.75 * 9.81 * tan(0.35))
    able = Agility.of(Limits(max_tilt=20 * pi / 180, max_speed=3.0, max_climb=1.0))
    assert able.acceleration == pytest.approx(0.75 * 9.81 * tan(20 * pi / 180))
    assert able.most(Point(1, 0, 0)) == 3.0
    assert able.most(Point(0, 0, -1)) == 1.0
    assert able.most(Point(0.8, 0, 0.6)) == pytest.approx(1 / 0.6)
    assert Agility.resumed(able.progress()) == able
    assert Agility.resumed(ABLE.progress()) == ABLE and ABLE.climb == inf


def test_a_pace_without_a_way_takes_no_time() -> None:
    alone = blended([Corner(Point(0, 0, 2), 0)])[0]
    pace = paced(alone, [], ABLE)
    assert pace == Pace([0.0], [0.0], [0.0]) and pace.at(1.0) == (0.0, 0.0)


STEPS = st.lists(
    st.tuples(st.floats(0.2, 9.0), st.floats(-9.0, 9.0), st.floats(0.1, 20.0)),
    min_size=1,
    max_size=8,
)


@settings(deadline=None)
@given(STEPS)
def test_a_timed_pace_is_at_each_place_at_its_time_and_flies_forwards(
    steps: list[tuple[float, float, float]],
) -> None:
    places, times = [Point(0, 0, 2)], [0.0]
    for x, y, time in steps:
        places.append(places[-1].plus((x, y, 0.0)))
        times.append(times[-1] + time)
    path, ways = spline(places)
    pace = timed(path, ways, times)
    for way, time, place in zip(ways, times, places, strict=True):
        assert pace.at(time)[0] == pytest.approx(way)
        assert path.place(pace.at(time)[0]) == pytest.approx(place, abs=1e-6)
    assert pace.duration == times[-1]
    assert all(a < b for a, b in pairwise(pace.ways)) and min(pace.speeds) > 0
    assert len(pace.times) >= len(path.ways)
    directions = [path.direction(way) for way in pace.ways]
    slower = slowed(directions, pace, ABLE)
    assert slower.ways == pace.ways and slower.duration >= pace.duration
    velocities = [
        Point(*(v * speed for v in d)) for d, speed in zip(directions, slower.speeds, strict=True)
    ]
    for a, b, t, u in zip(velocities, velocities[1:], slower.times, slower.times[1:], strict=False):
        assert b.minus(a).norm() / (u - t) <= ABLE.acceleration * 1.001
