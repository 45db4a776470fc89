"""Values from the code of behaviours on their way into a graph."""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum, StrEnum
from fractions import Fraction
from math import inf, nan
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fsm.values.functions import EvaluationError
from fsm.values.intake import admitted, admitted_fields, copied, record_reader
from fsm.values.packing import pack, unpack
from fsm.values.types import ANY, BOOL, POINT, ListOf, MapOf, Number, Text, Type
from runner.appended_file import encode
from vencejo.geometry import Point
from vencejo.units import LENGTH


class Level(IntEnum):
    """A whole number of a class of its own."""

    HIGH = 3


class Word(StrEnum):
    """A text of a class of its own."""

    RED = "red"


class Color(Enum):
    """Something that is no value."""

    RED = 1


@dataclass(frozen=True)
class Spot:
    """A record."""

    at: Any = None
    name: str = ""


@pytest.mark.parametrize(
    ("value", "plain"),
    [
        (None, None),
        (True, True),
        (3, 3),
        (2.5, 2.5),
        ("drei €", "drei €"),
        (np.float32(0.5), 0.5),
        (np.float64(0.25), 0.25),
        (np.int16(7), 7),
        (np.bool_(True), True),
        (np.array(4), 4),
        (Fraction(1, 2), 0.5),
        (Level.HIGH, 3),
        (Word.RED, "red"),
        (Point(1, 2, np.float32(3)), Point(1.0, 2.0, 3.0)),
        ([1, (2, [3])], [1, (2, [3])]),
        (OrderedDict(a=1), {"a": 1}),
        ({7: "seven"}, {7: "seven"}),
        (Spot([np.int64(1)], "x"), Spot([1], "x")),
    ],
)
def test_it_becomes_a_plain_value(value: Any, plain: Any) -> None:
    taken = admitted(value)
    assert taken == plain
    assert type(taken) is type(plain)


ITSELF: list[Any] = []
ITSELF.append(ITSELF)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (nan, "not finite"),
        ([inf], "not finite"),
        ([10**5000], "too large"),
        (1e300, "too large"),
        (1j, "a complex is no value"),
        (b"x", "a bytes is no value"),
        ({1, 2}, "a set is no value"),
        (object(), "an object is no value"),
        (Point, "the class Point is no value"),
        (Color.RED, "a Color is no value"),
        (np.zeros(2), "a ndarray is no value"),
        (print, "is no value"),
        ((n for n in ()), "a generator is no value"),
        ("half \ud800", "half a character"),
        ({"half": Spot(name="\udfff")}, "half a character"),
        ({None: 1}, "the key of a map is a text, not a NoneType"),
        ({True: 1}, "not a bool"),
        ({1.5: 1}, "not a float"),
        ({"\ud800": 1}, "half a character"),
        ("x" * 1_000_001, "larger than 1 MB"),
        ([[0] * 1000] * 1000, "larger than 1 MB"),
        (ITSELF, "deep in each other"),
    ],
)
def test_what_no_graph_can_hold_is_refused(value: Any, told: str) -> None:
    with pytest.raises(EvaluationError, match=told):
        admitted(value)


@pytest.mark.parametrize(
    ("value", "place", "plain"),
    [
        (3, Number(LENGTH), 3.0),
        (3, Number(), 3),
        (2.5, Number(LENGTH), 2.5),
        (True, BOOL, True),
        ("red", Text(("red",)), "red"),
        (Point(1.0, 2.0, 3.0), POINT, Point(1.0, 2.0, 3.0)),
        ((1, 2), ListOf(), (1, 2)),
        ({}, MapOf(), {}),
        (None, Number(LENGTH), None),
    ],
)
def test_it_fits_its_place(value: Any, place: Type, plain: Any) -> None:
    taken = admitted(value, place)
    assert (taken, type(taken)) == (plain, type(plain))


@pytest.mark.parametrize(
    ("value", "place", "told"),
    [
        ("3", Number(LENGTH), "3 is not a length"),
        (True, Number(), "true is not a number"),
        (1.5, Number(whole=True), "1.5 is not a whole number"),
        (1, BOOL, "1 is not true or false"),
        (1, Text(), "1 is not a text"),
        ("blue", Text(("red",)), "blue is not one of red"),
        ([1, 2, 3], POINT, "is not a point"),
        ("abc", ListOf(), "abc is not"),
        ([], MapOf(), "is not"),
    ],
)
def test_what_does_not_fit_its_place_is_refused(value: Any, place: Type, told: str) -> None:
    with pytest.raises(EvaluationError, match=told):
        admitted(value, place)


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(st.characters(), max_size=5)
    | st.sampled_from([Color.RED, Word.RED, np.float32(1.5), b"", 1j])
    | st.builds(Point, st.floats(), st.floats(), st.floats()),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(max_size=3) | st.integers() | st.none(), inner, max_size=3)
        | st.tuples(inner, inner)
        | st.builds(Spot, inner, st.text(max_size=3))
    ),
    max_leaves=8,
)


@given(VALUES)
def test_whatever_is_admitted_can_be_logged_and_saved(value: Any) -> None:
    try:
        taken = admitted(value)
    except EvaluationError:
        return
    encode({"value": taken}).encode("utf-8")
    assert unpack(json.loads(json.dumps(pack(taken), allow_nan=False))) == taken
    assert admitted(taken) == taken


@pytest.mark.parametrize("copy", [admitted, copied])
def test_nobody_changes_it_afterwards(copy: Callable[[Any], Any]) -> None:
    mine: dict[str, Any] = {"a": [1, {"b": [2]}]}
    taken = copy(mine)
    mine["a"][1]["b"].append(3)
    mine["c"] = 4
    assert taken == {"a": [1, {"b": [2]}]}


def test_a_record_that_is_plain_stays_the_same_object() -> None:
    spot = Spot(1.5, "x")
    assert record_reader({"at": Number(LENGTH), "name": Text()})(spot) is spot


def test_a_record_is_a_copy_where_it_is_not_plain() -> None:
    places: list[Any] = [1, np.int8(2)]
    spot = Spot(places, "x")
    taken = record_reader({"at": ANY, "name": Text()})(spot)
    places.append(3)
    assert taken == Spot([1, 2], "x") and type(taken.at[1]) is int


@pytest.mark.parametrize("bad", [nan, inf, 1e300, "x", True, [1.0]])
def test_records_of_numbers_are_looked_at_too(bad: Any) -> None:
    read = record_reader({"at": Number(LENGTH), "name": Number()})
    whole = Spot(1.5, 2.5)  # type: ignore[arg-type]
    assert read(whole) is whole
    with pytest.raises(EvaluationError, match=r"^at: "):
        read(Spot(bad, 2.5 if bad is not True else 2))  # type: ignore[arg-type]


def test_a_wrong_field_is_named() -> None:
    with pytest.raises(EvaluationError, match=r"^name: 3 is not a text$"):
        record_reader({"at": ANY, "name": Text()})(Spot(name=3))  # type: ignore[arg-type]
    with pytest.raises(EvaluationError, match=r"^name: 3 is not a text$"):
        admitted_fields({"name": 3}, {"name": Text()})


def test_only_declared_fields_are_admitted() -> None:
    assert admitted_fields({}, {"name": Text()}) == {}
    assert admitted_fields({"name": "x"}, {"name": Text()}) == {"name": "x"}
    with pytest.raises(EvaluationError, match=r"no field 'nam' \(declared: name\)"):
        admitted_fields({"nam": "x"}, {"name": Text()})
    with pytest.raises(EvaluationError, match=r"no field 3 \(declared: none\)"):
        admitted_fields({3: "x"}, {})
