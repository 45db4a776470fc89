"""The types of values: what fits where, what two have in common, what arithmetic makes of them."""

from __future__ import annotations

from itertools import product as pairs
from types import SimpleNamespace
from typing import Any

import pytest

from fsm.values.types import (
    ANY,
    AREA,
    BARE,
    BOOL,
    HEADING,
    NAMED,
    NONE,
    POINT,
    ROUTE,
    TEXT,
    ListOf,
    MapOf,
    Mixed,
    Number,
    Text,
    Type,
    alike,
    fits,
    join,
    join_all,
    product,
    raised,
    type_of,
)
from vencejo.geometry import Point
from vencejo.units import ANGLE, FREQUENCY, LENGTH, RATIO, SPEED, TIME, TURN_RATE

METRES, SECONDS, RADIANS = Number(LENGTH), Number(TIME), Number(ANGLE)
WORDS = Text(("red", "blue"))


@pytest.mark.parametrize(
    ("place", "given"),
    [
        (METRES, METRES),
        (METRES, BARE),
        (BARE, METRES),
        (METRES, Number(LENGTH, 0.0, 5.0)),
        (HEADING, RADIANS),
        (HEADING, BARE),
        (HEADING, TEXT),
        (HEADING, MapOf()),
        (TEXT, WORDS),
        (WORDS, TEXT),
        (MapOf({"id": BARE}), MapOf()),
        (POINT, TEXT),
        (POINT, MapOf()),
        (POINT, ListOf(METRES)),
        (ListOf(METRES), ListOf(BARE)),
        (ListOf(), ListOf(TEXT)),
        (AREA, ListOf(ListOf())),
        (ANY, BOOL),
        (BOOL, ANY),
        (BOOL, BOOL),
    ],
)
def test_what_fits(place: Type, given: Type) -> None:
    assert fits(place, given)


@pytest.mark.parametrize(
    ("place", "given"),
    [
        (METRES, SECONDS),
        (METRES, TEXT),
        (METRES, BOOL),
        (BOOL, BARE),
        (BOOL, TEXT),
        (TEXT, BARE),
        (TEXT, POINT),
        (HEADING, METRES),
        (HEADING, POINT),
        (HEADING, BOOL),
        (POINT, METRES),
        (POINT, BOOL),
        (ListOf(METRES), ListOf(SECONDS)),
        (ListOf(METRES), METRES),
        (ListOf(METRES), MapOf()),
        (MapOf(), ListOf()),
    ],
)
def test_what_does_not_fit(place: Type, given: Type) -> None:
    assert not fits(place, given)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        (METRES, METRES, METRES),
        (METRES, BARE, METRES),
        (Number(LENGTH, 0.0, 5.0), Number(LENGTH, 1.0, 9.0), METRES),
        (METRES, SECONDS, Mixed((METRES, SECONDS))),
        (BARE, Number(whole=True), BARE),
        (TEXT, WORDS, TEXT),
        (WORDS, WORDS, WORDS),
        (BOOL, BARE, Mixed((BARE, BOOL))),
        (BOOL, ANY, ANY),
        (Mixed((BARE, BOOL)), TEXT, Mixed((BARE, TEXT, BOOL))),
        (Mixed((BARE, BOOL)), BARE, Mixed((BARE, BOOL))),
        (ListOf(METRES), ListOf(BARE), ListOf(METRES)),
        (ListOf(METRES), ListOf(TEXT), ListOf(Mixed((METRES, TEXT)))),
        (ListOf(METRES), METRES, Mixed((METRES, ListOf(METRES)))),
        (POINT, POINT, POINT),
        (POINT, MapOf(), Mixed((MapOf(), POINT))),
    ],
)
def test_what_two_types_have_in_common(a: Type, b: Type, expected: Type) -> None:
    assert join(a, b) == join(b, a) == expected


def test_what_many_types_have_in_common() -> None:
    assert join_all([]) == ANY
    assert join_all([BARE, METRES, Number(LENGTH, 1.0)]) == METRES
    assert join_all([BARE, METRES, SECONDS]) == Mixed((METRES, SECONDS))


@pytest.mark.parametrize(
    ("a", "b", "times", "over"),
    [
        (METRES, SECONDS, Number(LENGTH.times(TIME)), Number(SPEED)),
        (METRES, METRES, Number(LENGTH.times(LENGTH)), Number(LENGTH.times(LENGTH, -1))),
        (METRES, BARE, BARE, BARE),
        (BARE, METRES, BARE, BARE),
        (METRES, RADIANS, BARE, BARE),
        (RADIANS, SECONDS, BARE, Number(ANGLE.times(TIME, -1))),
    ],
)
def test_products_and_quotients(a: Number, b: Number, times: Number, over: Number) -> None:
    assert (product(a, b, 1), product(a, b, -1)) == (times, over)


@pytest.mark.parametrize(
    ("base", "exponent", "expected"),
    [
        (METRES, 2, Number(LENGTH.times(LENGTH))),
        (METRES, 1.0, METRES),
        (METRES, 0, Number(RATIO)),
        (METRES, -1, Number(RATIO.times(LENGTH, -1))),
        (METRES, 0.5, None),
        (Number(LENGTH.times(LENGTH)), 0.5, METRES),
        (METRES, None, BARE),
        (BARE, 0.5, BARE),
        (RADIANS, 2, BARE),
    ],
)
def test_powers(base: Number, exponent: float | None, expected: Number | None) -> None:
    assert raised(base, exponent) == expected


@pytest.mark.parametrize(
    ("place", "given"),
    [
        (RADIANS, Number(RATIO)),
        (HEADING, Number(RATIO)),
        (Number(TURN_RATE), Number(FREQUENCY)),
    ],
)
def test_a_plain_number_is_an_angle_where_one_is_asked_for(place: Type, given: Number) -> None:
    assert fits(place, given)
    assert not fits(given, place) or place == HEADING
    assert join(place, given) == join(given, place) == place or place == HEADING


@pytest.mark.parametrize("place", [METRES, BOOL, TEXT, POINT, HEADING, ListOf(), MapOf()])
def test_none_fits_where_anything_does(place: Type) -> None:
    assert fits(ANY, NONE)
    assert not fits(place, NONE)
    assert alike(place, NONE)
    assert alike(NONE, place)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (True, BOOL),
        (1, BARE),
        (1.5, BARE),
        ("a", TEXT),
        (Point(1.0, 2.0, 3.0), POINT),
        ({"id": 1}, MapOf()),
        ([1, 2.0], ListOf(BARE)),
        ((True, False), ListOf(BOOL)),
        ([1, "a"], ListOf(Mixed((BARE, TEXT)))),
        ([[1], [2]], ListOf(ListOf(BARE))),
        ([], ListOf(ANY)),
        (None, ANY),
        (SimpleNamespace(), ANY),
    ],
)
def test_the_type_of_a_value(value: Any, expected: Type) -> None:
    assert type_of(value) == expected


def test_types_are_equal_and_hashed_by_what_they_say() -> None:
    every = [*NAMED.values(), WORDS, MapOf({"id": BARE}), MapOf({"id": METRES}), HEADING, ROUTE]
    for one, other in pairs(every, every):
        assert (one == other) <= (hash(one) == hash(other))
    assert len(set(NAMED.values())) == len(NAMED)
