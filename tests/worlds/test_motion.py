"""Things that move: exactly on their path, facing where they go."""

from __future__ import annotations

from math import dist, pi

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vencejo.geometry import Point, wrap, yaw_of, yaw_quaternion
from worlds.motion import pose_at
from worlds.things import UPRIGHT, Motion, Thing

SQUARE = (Point(0, 0, 0), Point(10, 0, 0), Point(10, 10, 0), Point(0, 10, 0))


def thing(motion: Motion | None, heading: float = 0.0) -> Thing:
    return Thing("t", "box", Point(1, 2, 3), yaw_quaternion(heading), (), True, motion)


def test_what_stands_still_stays() -> None:
    still = thing(None, 1.0)
    assert pose_at(still, 100.0) == (Point(1, 2, 3), yaw_quaternion(1.0))


def test_a_loop_comes_round() -> None:
    loop = thing(Motion(SQUARE, 2.0, loop=True, turns=False))
    for time, place in ((0, (0, 0, 0)), (2, (4, 0, 0)), (6, (10, 2, 0)), (19, (0, 2, 0))):
        for rounds in (0, 1, 1000):
            assert pose_at(loop, time + 20 * rounds)[0] == pytest.approx(place, abs=1e-9)
    assert pose_at(loop, 6)[1] == UPRIGHT


def test_a_path_with_two_ends_is_flown_there_and_back() -> None:
    path = thing(Motion((Point(0, 0, 1), Point(6, 0, 1), Point(6, 0, 4)), 1.0, False, True))
    assert pose_at(path, 8)[0] == pytest.approx((6, 0, 3))
    assert pose_at(path, 10)[0] == pytest.approx((6, 0, 3))
    assert pose_at(path, 15)[0] == pytest.approx((3, 0, 1))
    assert yaw_of(pose_at(path, 15)[1]) == pytest.approx(pi)


def test_it_turns_round_a_corner_within_a_second() -> None:
    loop = thing(Motion(SQUARE, 2.0, loop=True, turns=True))
    headings = {t: yaw_of(pose_at(loop, t)[1]) for t in (2.5, 4.5, 5.0, 5.5, 7.5)}
    assert headings == pytest.approx({2.5: 0, 4.5: 0, 5.0: pi / 4, 5.5: pi / 2, 7.5: pi / 2})


def test_its_own_heading_is_on_top_of_the_paths() -> None:
    loop = thing(Motion(SQUARE, 2.0, loop=True, turns=True), pi / 2)
    assert yaw_of(pose_at(loop, 2.5)[1]) == pytest.approx(pi / 2)
    assert abs(yaw_of(pose_at(loop, 7.5)[1])) == pytest.approx(pi)


coordinates = st.floats(-50, 50).map(lambda v: round(v, 1))
paths = st.lists(
    st.builds(Point, coordinates, coordinates, coordinates), min_size=2, max_size=6, unique=True
)


# Not by the wall clock: the machine may be busy.
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(paths, st.floats(0.1, 5.0), st.booleans(), st.floats(0, 700))
def test_neither_place_nor_heading_ever_jumps(
    points: list[Point], speed: float, loop: bool, time: float
) -> None:
    moving = thing(Motion(tuple(points), speed, loop, turns=True))
    step = 1e-6
    before, after = pose_at(moving, time), pose_at(moving, time + step)
    assert dist(before[0], after[0]) <= speed * step * (1 + 1e-6) + 1e-12
    turned = wrap(yaw_of(after[1]) - yaw_of(before[1]))
    # Not even at a corner.
    assert abs(turned) <= pi / (2 * min(0.5 * speed, 0.05)) * speed * step * 1.01 + 1e-9
