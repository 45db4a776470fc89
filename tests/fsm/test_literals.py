# ruff: noqa: E501  (tables keep their lines)
"""The values that places of each type take, and the exact place of each mistake."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fsm.expressions.literals import Context, read_value
from fsm.expressions.scope import Binding, Scope
from fsm.values.conversion import convert, converted
from fsm.values.functions import FAILURES, EvaluationError
from fsm.values.types import (
    ANY,
    AREA,
    BOOL,
    HEADING,
    NAMED,
    POINT,
    ROUTE,
    TEXT,
    ListOf,
    MapOf,
    Number,
    Text,
    Type,
)
from vencejo.errors import UserError
from vencejo.geometry import Point
from vencejo.nodes import read_text
from vencejo.units import ANGLE, LENGTH, SPEED, TIME

HERE = Point(1.0, 2.0, 3.0)


def context() -> Context:
    scope = Scope()
    for slot, (name, type_) in enumerate(
        {"h": Number(LENGTH), "at": POINT, "word": TEXT, "some": ANY, "n": Number()}.items()
    ):
        scope.names[name] = Binding(name, "data", type_, slot)
    return Context(scope, {"gate": Point(4.0, 5.0, 6.0)}, frozenset({"pond"}))


SLOTS = [2.5, HERE, "tag", None, 3]


def read(text: str, place: Type) -> Any:
    node = read_text(f"v: {text}", "m.yaml").entries[0][1]
    return read_value(node, place, context())(SLOTS)


def faults(text: str, place: Type) -> list[str]:
    with pytest.raises(UserError) as raised:
        read(text, place)
    return [
        f"{fault.where.line}:{fault.where.column} {fault.code}" if fault.where else fault.code
        for fault in raised.value.faults
    ]


@pytest.mark.parametrize(
    ("text", "place", "value"),
    [
        ("4", Number(), 4),
        ("-0.5", Number(), -0.5),
        ("1e-3", Number(), 0.001),
        ("010", ANY, "010"),
        ("4 m", Number(LENGTH), 4.0),
        ("4", Number(LENGTH), 4.0),
        ("10 cm", Number(LENGTH), 0.1),
        ("'4 m'", Number(LENGTH), 4.0),
        ("$h", Number(LENGTH), 2.5),
        ("${h * 2}", Number(LENGTH), 5.0),
        ("true", BOOL, True),
        ("${h > 2}", BOOL, True),
        ("off", TEXT, "off"),
        ("1:30", TEXT, "1:30"),
        ("red", Text(("red", "blue")), "red"),
        ("$word", TEXT, "tag"),
        ("a $word at ${h:.1f} m, $$5", TEXT, "a tag at 2.5 m, $5"),
        ("costs $$5", TEXT, "costs $5"),
        ("'${at}'", TEXT, None),
        ("at ${at}", TEXT, "at (1.00, 2.00, 3.00)"),
        ("${n:d} ${n:3d} ${h:+.2f}", TEXT, "3   3 +2.50"),
        ("[1, 2, 3]", POINT, Point(1.0, 2.0, 3.0)),
        ("[100 cm, 2 m]", POINT, {"x": 1.0, "y": 2.0}),
        ("{x: 1, y: 2, z: 3}", POINT, Point(1.0, 2.0, 3.0)),
        ("{x: 1, z: 3 m}", POINT, {"x": 1.0, "z": 3.0}),
        ("{x: 1, y: 2, z: 3, frame: world}", POINT, {"x": 1.0, "y": 2.0, "z": 3.0, "frame": "world"}),
        ("{forward: 2 m}", POINT, {"forward": 2.0}),
        ("{forward: 2, left: -1, up: 50 cm}", POINT, {"forward": 2.0, "left": -1.0, "up": 0.5}),
        ("{lat: 40.1, lon: -3.2, above_home: 5 m}", POINT, {"lat": 40.1, "lon": -3.2, "above_home": 5.0}),
        ("{x: 1, above_ground: 4 m}", POINT, {"x": 1.0, "above_ground": 4.0}),
        ("{forward: 2 m, above_ground: 4}", POINT, {"forward": 2.0, "above_ground": 4.0}),
        ("{lat: 40.1, lon: -3.2, above_ground: 5 m}", POINT, {"lat": 40.1, "lon": -3.2, "above_ground": 5.0}),
        ("home", POINT, "home"),
        ("gate", POINT, Point(4.0, 5.0, 6.0)),
        ("pond", POINT, "pond"),
        ("$at", POINT, HERE),
        ("[$h, '${h + 1}', 0]", POINT, Point(2.5, 3.5, 0.0)),
        ("{up: $h}", POINT, {"up": 2.5}),
        ("90 deg", HEADING, math.pi / 2),
        ("1.5", HEADING, 1.5),
        ("keep", HEADING, "keep"),
        ("travel", HEADING, "travel"),
        ("{face: gate}", HEADING, {"face": Point(4.0, 5.0, 6.0)}),
        ("${n * 30 deg}", HEADING, 3 * math.radians(30)),
        ("[[1, 2, 3], gate, {at: pond, speed: 2 m/s, dwell: 1 s, heading: keep}]", ROUTE,
         [Point(1.0, 2.0, 3.0), Point(4.0, 5.0, 6.0),
          {"at": "pond", "speed": 2.0, "dwell": 1.0, "heading": "keep"}]),
        ("[[0, 0], [1, 0], gate]", AREA, [{"x": 0.0, "y": 0.0}, {"x": 1.0, "y": 0.0}, Point(4.0, 5.0, 6.0)]),
        ("[1 m, 2 m]", ListOf(Number(LENGTH)), [1.0, 2.0]),
        ("{a: 1, b: [x, '2']}", ANY, {"a": 1, "b": ["x", "2"]}),
        ("{a: 1 m}", MapOf({"a": Number(LENGTH)}), {"a": 1.0}),
        ("4 m", ANY, 4.0),
        ("'4 m'", ANY, "4 m"),
        ("null", ANY, None),
        ("false", ANY, False),
    ],
)  # fmt: skip
def test_value(text: str, place: Type, value: Any) -> None:
    if value is None and place is TEXT:
        with pytest.raises(UserError):
            read(text, place)
        return
    found = read(text, place)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "place", "expected"),
    [
        ("high", Number(LENGTH), ["1:4 wrong-type"]),
        ("", Number(LENGTH), ["1:3 wrong-type"]),
        ("[1]", Number(LENGTH), ["1:4 wrong-type"]),
        ("4 s", Number(LENGTH), ["1:4 wrong-dimension"]),
        ("4 parsec", Number(LENGTH), ["1:4 unknown-unit"]),
        ("$word", Number(LENGTH), ["1:5 wrong-type"]),
        ("${h > nope}", BOOL, ["1:10 unknown-name"]),
        ("'${h > nope}'", BOOL, ["1:11 unknown-name"]),
        ("off", BOOL, ["1:4 wrong-type"]),
        ("x ${h}", Number(LENGTH), ["1:4 wrong-type"]),
        ("green", Text(("red", "blue")), ["1:4 unknown-word"]),
        ("a ${nope} b", TEXT, ["1:8 unknown-name"]),
        ("[1]", POINT, ["1:4 wrong-type"]),
        ("[1, 2, 3, 4]", POINT, ["1:4 wrong-type"]),
        ("[1, 2 s, x]", POINT, ["1:8 wrong-dimension", "1:13 wrong-type"]),
        ("{}", POINT, ["1:4 wrong-type"]),
        ("{x: 1, y: 2, z: 3, above_ground: 4}", POINT, ["1:4 wrong-type"]),
        ("{x: 1, forward: 2}", POINT, ["1:4 wrong-type"]),
        ("{x: 1, y: 2, above_grund: 4}", POINT, ["1:17 unknown-key"]),
        ("{x: 1, yy: 2}", POINT, ["1:11 unknown-key"]),
        ("{x: 1, y: 2, frame: moon}", POINT, ["1:24 unknown-word"]),
        ("{lat: 40}", POINT, ["1:4 missing-key"]),
        ("{forward: 2 s}", POINT, ["1:14 wrong-dimension"]),
        ("nowhere", POINT, ["1:4 unknown-place"]),
        ("4 m", POINT, ["1:4 unknown-place"]),
        ("north", HEADING, ["1:4 wrong-type"]),
        ("2 m", HEADING, ["1:4 wrong-dimension"]),
        ("{fase: gate}", HEADING, ["1:5 unknown-key"]),
        ("{face: nowhere}", HEADING, ["1:11 unknown-place"]),
        ("[[1, 2], {at: nowhere, sped: 1}]", ROUTE, ["1:27 unknown-key", "1:18 unknown-place"]),
        ("[{at: gate, speed: 0 m/s}]", ROUTE, ["1:23 out-of-range"]),
        ("gate", ROUTE, ["1:4 wrong-type"]),
        ("[[0, 0], [1, 1]]", AREA, ["1:4 wrong-type"]),
        ("[1 m, 2 s]", ListOf(Number(LENGTH)), ["1:10 wrong-dimension"]),
        ("{a: 1, b: 2}", MapOf({"a": Number()}), ["1:11 unknown-key"]),
        ("0.5 m/s", Number(SPEED, min=1.0), ["1:4 out-of-range"]),
        ("1e999", ANY, ["1:4 out-of-range"]),
        ("${1 / 0}", Number(), ["1:6 no-value"]),
        ("${[1, 2][5]}", Number(), ["1:6 no-value"]),
    ],
)
def test_mistake(text: str, place: Type, expected: list[str]) -> None:
    assert faults(text, place) == expected


@pytest.mark.parametrize(
    ("value", "place", "expected"),
    [
        (3, Number(LENGTH), 3.0),
        (3, Number(whole=True), 3),
        (HERE, POINT, HERE),
        ([1, 2, 3], POINT, Point(1.0, 2.0, 3.0)),
        ([1, 2], POINT, {"x": 1.0, "y": 2.0}),
        ({"forward": 2}, POINT, {"forward": 2}),
        ("keep", HEADING, "keep"),
        ({"face": [1, 2, 3]}, HEADING, {"face": Point(1.0, 2.0, 3.0)}),
        ([HERE, {"at": [1, 2, 3]}], ROUTE, [HERE, {"at": Point(1.0, 2.0, 3.0)}]),
        ([HERE], AREA, [HERE]),
        (None, Number(), None),
        (True, Number(), None),
        (float("nan"), Number(), None),
        (float("inf"), Number(ANGLE), None),
        (10, Number(max=10), 10),
        (2, Number(TIME, max=10), 2.0),
        (2.5, Number(TIME, max=10), 2.5),
        (2.0, Number(whole=True), 2.0),
        (11, Number(max=10), None),
        (1e300, Number(), None),
        (1.5, Number(whole=True), None),
        (1, BOOL, None),
        (1, TEXT, None),
        ("green", Text(("red",)), None),
        ([1], POINT, None),
        ({"a": 1}, POINT, None),
        ("north", HEADING, None),
        (3, ROUTE, None),
        (3, MapOf(), None),
        ({"b": 1}, MapOf({"a": ANY}), None),
    ],
)
def test_values_of_expressions_are_checked_for_their_place(
    value: Any, place: Type, expected: Any
) -> None:
    quickly = converted(lambda slots, event: value, place)
    if expected is None:
        with pytest.raises(EvaluationError):
            convert(value, place)
        with pytest.raises(EvaluationError):
            quickly([], None)
    else:
        for found in (convert(value, place), quickly([], None)):
            assert (found, type(found)) == (expected, type(expected))


@given(st.text(max_size=30), st.sampled_from(sorted(NAMED)))
def test_any_text_in_any_place_gives_a_value_or_a_user_error(text: str, name: str) -> None:
    try:
        read(text, NAMED[name])
    except (UserError, *FAILURES):
        return
