"""Things that move: exactly on their path, facing where they go."""

from __future__ import annotations

from math import cos, dist, hypot, pi, radians, sin

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vencejo.geometry import Point, bearing, wrap, yaw_of, yaw_quaternion
from worlds import find_world
from worlds.motion import STRETCH, pose_at, track_of
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


def test_it_turns_at_a_corner() -> None:
    loop = thing(Motion(SQUARE, 2.0, loop=True, turns=True))
    headings = {t: yaw_of(pose_at(loop, t)[1]) for t in (4.97, 5.0, 5.03)}
    assert headings == pytest.approx({4.97: 0, 5.0: pi / 4, 5.03: pi / 2}, abs=1e-9)


def test_it_turns_gradually_at_gentle_bends() -> None:
    """As those of the polyline that a smooth path is made of."""
    bend = pi / 30
    points = (Point(0, 0, 0), Point(10, 0, 0), Point(10 + 10 * cos(bend), 10 * sin(bend), 0))
    path = thing(Motion(points, 2.0, loop=False, turns=True))
    times = {4.7: 0.0, 4.9: 0.3 * bend, 5.0: bend / 2, 5.1: 0.7 * bend, 5.3: bend}
    assert {t: yaw_of(pose_at(path, t)[1]) for t in times} == pytest.approx(times)


def test_its_own_heading_is_on_top_of_the_paths() -> None:
    loop = thing(Motion(SQUARE, 2.0, loop=True, turns=True), pi / 2)
    assert yaw_of(pose_at(loop, 2.5)[1]) == pytest.approx(pi / 2)
    assert abs(yaw_of(pose_at(loop, 7.5)[1])) == pytest.approx(pi)


coordinates = st.floats(-50, 50).map(lambda v: round(v, 1))
paths = st.lists(
    st.builds(Point, coordinates, coordinates, coordinates), min_size=2, max_size=6, unique=True
)


def direction(moving: Thing, time: float) -> float | None:
    """The direction of travel over the ground; None for a thing that only climbs or sinks."""
    here, soon = pose_at(moving, time)[0], pose_at(moving, time + 1e-4)[0]
    level = hypot(soon.x - here.x, soon.y - here.y)
    return bearing(here, soon) if level > 1e-3 * dist(here, soon) else None


def is_near_corner(moving: Thing, time: float, within: float) -> bool:
    assert moving.motion is not None
    track = track_of(moving.motion)
    passed, course = track.speed * time, track.distances[-1]
    off = min(
        abs((passed - corner + course / 2) % course - course / 2) for corner in track.distances
    )
    return off <= track.speed * within


# Not by the wall clock: the machine may be busy.
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(paths, st.floats(0.1, 5.0), st.booleans(), st.one_of(st.just(0.0), st.floats(0, 700)))
def test_what_moves_faces_along_its_path(
    points: list[Point], speed: float, loop: bool, time: float
) -> None:
    moving = thing(Motion(tuple(points), speed, loop, turns=True))
    along, heading = direction(moving, time), yaw_of(pose_at(moving, time)[1])
    sharp = time > 0 and is_near_corner(moving, time, 2 * STRETCH)
    if along is not None and not sharp:
        # Half of the greatest bend that is turned round gradually.
        assert abs(wrap(heading - along)) < radians(5.1)


@pytest.mark.parametrize("world", ["marker_yard", "pursuit", "road_town"])
def test_what_moves_in_the_shipped_worlds_faces_along_its_path(world: str) -> None:
    moving = [each for each in find_world(world).things if each.motion and each.motion.turns]
    assert moving
    for each in moving:
        own, beside = yaw_of(each.attitude), 0.0
        for time in (k * 0.0371 for k in range(2000)):
            along = direction(each, time)
            if along is None or (each.name == "taxi" and abs(time % 7.5 - 3.75) > 3.7):
                continue  # the taxi turns back after every 7.5 s
            beside = max(beside, abs(wrap(yaw_of(pose_at(each, time)[1]) - own - along)))
        assert beside < radians(2), (each.name, beside)


def test_it_begins_facing_along_its_path() -> None:
    for loop in (False, True):
        path = thing(Motion(SQUARE[1:], 2.0, loop, turns=True))
        for time in (0.0, 0.001, 0.1):
            assert yaw_of(pose_at(path, time)[1]) == pytest.approx(pi / 2)


# Not by the wall clock: the machine may be busy.
@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(paths, st.floats(0.1, 5.0), st.booleans(), st.floats(0, 700))
def test_neither_place_nor_heading_jumps(
    points: list[Point], speed: float, loop: bool, time: float
) -> None:
    moving = thing(Motion(tuple(points), speed, loop, turns=True))
    step = 1e-6
    before, after = pose_at(moving, time), pose_at(moving, time + step)
    assert dist(before[0], after[0]) <= speed * step * (1 + 1e-6) + 1e-12
    turned = wrap(yaw_of(after[1]) - yaw_of(before[1]))
    # Not even at a corner: it turns there in two stretches, or along half of a short leg.
    assert abs(turned) <= pi / min(2 * STRETCH, 0.1 / speed) * step * 1.01 + 1e-9
