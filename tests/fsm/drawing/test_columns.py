from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from fsm.drawing.channels import NEAR, Net, route
from fsm.drawing.columns import settle, slots

XS = st.lists(st.integers(-500, 500).map(float), min_size=1, max_size=12)


def test_who_has_room_gets_the_wish() -> None:
    assert settle([0.0, 30.0, 90.0], [1.0] * 3, [20.0, 20.0]) == [0.0, 30.0, 90.0]


def test_those_that_push_each_other_share_the_way_by_weight() -> None:
    assert settle([10.0, 10.0], [3.0, 1.0], [8.0]) == [8.0, 16.0]


@given(XS)
def test_all_are_apart(wished: list[float]) -> None:
    places = settle(wished, [1.0] * len(wished), [15.0] * (len(wished) - 1))
    assert all(two - one >= 15.0 - 1e-6 for one, two in pairwise(places))


@given(XS, st.integers(0, 4))
def test_slots_are_free_and_inside(wished: list[float], count: int) -> None:
    taken = [-40.0 + 25.0 * index for index in range(count)]
    high = 14.0 * (len(wished) + count)
    found = slots(wished, taken, -high, high, 14.0)
    everything = sorted([*found, *taken])
    assert all(-high <= x <= high for x in found)
    assert all(two - one >= 14.0 - 1e-5 for one, two in pairwise(everything))


def test_a_straight_line_needs_no_track() -> None:
    assert route([Net([5.0], [5.0])], 0.0, 100.0) == 0


def test_who_leaves_above_an_arrival_turns_off_first() -> None:
    leaving, arriving = Net([50.0], [90.0]), Net([10.0], [50.0])
    assert route([arriving, leaving], 0.0, 100.0) == 2
    assert (leaving.upper_track, arriving.upper_track) == (0, 1)


def test_two_that_change_places_need_a_spine() -> None:
    one, two = Net([10.0], [50.0]), Net([50.0], [10.0])
    assert route([one, two], 0.0, 100.0) == 3
    (spine,) = (net.spine for net in (one, two) if net.spine is not None)
    assert min(abs(spine - x) for x in (10.0, 50.0)) >= NEAR
    cut = one if one.spine is not None else two
    other = two if cut is one else one
    assert cut.upper_track < other.upper_track == other.lower_track < cut.lower_track
