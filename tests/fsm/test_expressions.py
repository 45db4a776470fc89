# ruff: noqa: E501  (missions and tables keep their lines)
"""Expressions: their values, their mistakes to the column, and what hostile ones cannot do."""

from __future__ import annotations

import ast
import math
import time
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fsm.expressions.compiled import compile_expression
from fsm.expressions.scope import Binding, Define, Scope
from fsm.values.functions import FAILURES
from fsm.values.types import ANY, BOOL, MAX_NUMBER, POINT, TEXT, ListOf, MapOf, Number, Text, Type
from vencejo.errors import UserError, Where
from vencejo.geometry import Point
from vencejo.nodes import Scalar
from vencejo.units import ANGLE, LENGTH, TIME

WHERE = Where("m.yaml", 1, 1)
NAMES: dict[str, tuple[Type, Any]] = {
    "n": (Number(), 3),
    "h": (Number(LENGTH), 2.5),
    "t": (Number(TIME), 4.0),
    "turn": (Number(ANGLE), 1.0),
    "yes": (BOOL, True),
    "word": (TEXT, "tag"),
    "mode": (Text(("auto", "manual")), "auto"),
    "at": (POINT, Point(1.0, 2.0, 3.0)),
    "items": (ListOf(Number()), [1, 2, 3]),
    "maps": (ListOf(MapOf()), [{"id": 4}, {"id": 9}]),
    "any": (ANY, None),
    "rec": (MapOf({"id": Number()}), {"id": 8}),
    "big": (ListOf(Number()), list(range(300))),
}


def scope() -> Scope:
    made = Scope()
    for slot, (name, (type_, _)) in enumerate(NAMES.items()):
        made.names[name] = Binding(name, "data", type_, slot)
    for name, arguments, body in (
        ("twice", ("v",), "v * 2"),
        ("far", (), "h > 2 m"),
        ("loop", (), "loop + 1"),
        ("over", ("v",), "1 / v"),
        ("debug", (), "false"),
        ("never", (), "1 > 2 and yes"),
    ):
        made.defines[name] = Define(name, arguments, Scalar(body, WHERE), made)
    return made


SLOTS = [value for _, value in NAMES.values()]


def value(text: str) -> Any:
    return compile_expression(text, WHERE, scope())(SLOTS)


def mistake(text: str, wanted: Type = ANY) -> str:
    with pytest.raises(UserError) as raised:
        compile_expression(text, WHERE, scope(), wanted)
    (fault,) = raised.value.faults
    assert fault.where is not None
    return f"{fault.code} {fault.where.column}"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (" n ", 3),
        ("true", True),
        ("word", "tag"),
        ("1 + 2 * 3", 7),
        ("2 ** 3", 8.0),
        ("-n", -3),
        ("7 / 2", 3.5),
        ("250 cm", 2.5),
        ("10 cm", 0.1),
        ("5 s + 250 ms", 5.25),
        ("90 deg", math.pi / 2),
        ("30 %", 0.3),
        ("h > 2 m and t < 5 s", True),
        ("10 km/h", 10 / 3.6),
        ("h * 2", 5.0),
        ("6 m / 2 s", 3.0),
        ("1 < 2 < 3", True),
        ("1 < 2 > 3", False),
        ("not yes", False),
        ("true and not false", True),
        ("null == none", True),
        ("1 if yes else 2", 1),
        ("'a' in 'tag'", True),
        ("2 in items", True),
        ("5 not in items", True),
        ("word == 'tag'", True),
        ("mode != 'manual'", True),
        ("at.z", 3.0),
        ("items[0] + items[-1]", 4),
        ("maps[1].id", 9),
        ("rec.id", 8),
        ("[x * 2 for x in items if x > 1]", [4, 6]),
        ("[a + b for a in items for b in items if a == b]", [2, 4, 6]),
        ("sum(m.id for m in maps)", 13),
        ("any([x > 2 for x in items])", True),
        ("all(x > 2 for x in items)", False),
        ("len(items)", 3),
        ("abs(-2 m)", 2.0),
        ("min(items)", 1),
        ("max(h, 3 m)", 3.0),
        ("clamp(7, 0, 5)", 5),
        ("sign(-2)", -1),
        ("round(2.567, 1)", 2.6),
        ("round(2.5)", 2),
        ("floor(2.9)", 2),
        ("sqrt(9)", 3.0),
        ("hypot(3, 4)", 5.0),
        ("wrap(370 deg)", math.radians(10)),
        ("sin(90 deg)", 1.0),
        ("atan2(0, 1)", 0.0),
        ("mod(7, 4)", 3),
        ("point(1, 2, 3)", Point(1, 2, 3)),
        ("distance(at, [1, 2, 5])", 2.0),
        ("bearing([0, 0, 0], [0, 1, 0])", math.pi / 2),
        ("twice(h)", 5.0),
        ("twice(twice(2))", 8),
        ("far", True),
        ("[twice(x) for x in items]", [2, 4, 6]),
        ("  1 +\n 2", 3),
        ("'5 m'", "5 m"),
        ("(1, 2)", [1, 2]),
        ("yes == (yes == (yes == yes) == yes)", True),
    ],
)
def test_value(text: str, expected: Any) -> None:
    found = value(text)
    assert found == pytest.approx(expected) if isinstance(expected, float) else found == expected
    assert isinstance(found, type(expected))


def test_quantities_are_exact() -> None:
    assert value("10 cm") == 0.1
    assert value("30 %") == 0.3


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "empty-expression 1"),
        ("   ", "empty-expression 1"),
        ("1 +", "bad-expression 4"),
        ("nn", "unknown-name 1"),
        ("  nn ", "unknown-name 3"),
        (" \xa0n", "bad-expression 2"),
        ("if", "bad-expression 1"),
        ("n n", "bad-expression 1"),
        ("2 m 3 m", "bad-expression 1"),
        ("nn + 1", "unknown-name 1"),
        ("1 + (2 * nope)", "unknown-name 10"),
        ("ítem + nope", "unknown-name 1"),
        ("'é' == nope", "unknown-name 8"),
        ("5 m + nope", "unknown-name 7"),
        ("h + t", "wrong-dimension 1"),
        ("1 if yes else (h + t)", "wrong-dimension 16"),
        ("h > 2 s", "wrong-dimension 1"),
        ("h == 2 s", "wrong-dimension 1"),
        ("h == 'a'", "wrong-type 1"),
        ("yes + 1", "wrong-type 1"),
        ("word * 2", "wrong-type 1"),
        ("word < 'a'", "wrong-type 1"),
        ("not n", "wrong-type 5"),
        ("yes and n", "wrong-type 9"),
        ("1 if n else 2", "wrong-type 6"),
        ("at.w", "unknown-field 1"),
        ("rec.ide", "unknown-field 1"),
        ("n.real", "unknown-field 1"),
        ("n[0]", "wrong-type 1"),
        ("items['a']", "wrong-type 7"),
        ("1 in 2", "wrong-type 6"),
        ("mode == 'autop'", "unknown-word 9"),
        ("nope(1)", "unknown-function 1"),
        ("items.append(1)", "unknown-function 1"),
        ("abs()", "wrong-arguments 1"),
        ("abs(1, 2)", "wrong-arguments 1"),
        ("abs(x=1)", "wrong-arguments 1"),
        ("abs(items)", "wrong-type 1"),
        ("sum(1)", "wrong-type 1"),
        ("min(1 m, 2 s)", "wrong-dimension 1"),
        ("sin(2 m)", "wrong-dimension 1"),
        ("twice", "wrong-arguments 1"),
        ("twice(1, 2)", "wrong-arguments 1"),
        ("loop", "endless-define 1"),
        ("active('nowhere')", "unknown-state 1"),
        ("active(word)", "wrong-arguments 1"),
        ("7 % 4", "bad-expression 1"),
        ("n % 4", "bad-expression 1"),
        ("7 // 4", "bad-expression 1"),
        ("n is 3", "bad-expression 1"),
        ("n & 3", "bad-expression 1"),
        ("n + ~n", "bad-expression 5"),
        ("items[0:1]", "bad-expression 1"),
        ("{1: 2}", "bad-expression 1"),
        ("{1}", "bad-expression 1"),
        ("(y := 3)", "bad-expression 2"),
        ("lambda: 1", "bad-expression 1"),
        ("f'{n}'", "bad-expression 1"),
        ("b'a'", "bad-expression 1"),
        ("3j", "bad-expression 1"),
        ("...", "bad-expression 1"),
        ("[n for n in items]", "name-taken 8"),
        ("[a for a, b in items]", "bad-expression 1"),
        ("[a for a in n]", "wrong-type 13"),
        ("await n", "bad-expression 1"),
        ("*items", "bad-expression 1"),
        ("1e999", "bad-expression 1"),
        ("9" * 400 + " m", "bad-expression 1"),
        ("5 lightyears", "bad-expression 1"),
        ("n = 3", "bad-expression 1"),
        ("n && yes", "bad-expression 4"),
        ("import os", "bad-expression 1"),
        ("n; n", "bad-expression 2"),
        ("(n", "bad-expression 1"),
        ("n)", "bad-expression 3"),
        ("'n", "bad-expression 1"),
        ("$n", "bad-expression 1"),
        ("n\0", "bad-expression 2"),
        ("1 in items in items", "bad-expression 1"),
        ("h > 010 m", "bad-expression 5"),
        # constants without a value, wherever they stand
        ("1 / 0", "no-value 1"),
        ("n > 1 / 0", "no-value 5"),
        ("n / 0", "no-value 1"),
        ("1 + h / (2 m - 2 m)", "no-value 5"),
        ("yes or 1 / 0 > n", "no-value 8"),
        ("n if yes else 1 / 0", "no-value 15"),
        ("[n, 1 / 0]", "no-value 5"),
        ("n in [1 / 0]", "no-value 7"),
        ("items[1 / 0]", "no-value 7"),
        ("[1, 2][5] + n", "no-value 1"),
        ("sum([1 / 0, n])", "no-value 6"),
        ("max(n, sqrt(-1))", "no-value 8"),
        ("n + min([])", "no-value 5"),
        ("twice(1 / 0)", "no-value 7"),
        ("over(0) + n", "no-value 1"),
        ("over(n - n) + over(2 - 2)", "no-value 15"),
        ("distance(at, point(0, 0, 1 / 0))", "no-value 26"),
        ("[1 / a for a in [0]] == items", "no-value 1"),
        ("n * (1e200 * 1e200)", "no-value 6"),
        ("n + (-8) ** 0.5", "no-value 5"),
        ("range(0, 5, 0)", "no-value 1"),
        ("range(n, 0.5)[0] + range(0.5)[0]", "no-value 20"),
        # dimensions
        ("sqrt(h)", "wrong-dimension 1"),
        ("sqrt(h) > 2 m", "wrong-dimension 1"),
        ("h ** 0.5", "wrong-dimension 1"),
        ("h ** (1 / 2)", "wrong-dimension 1"),
        ("h ** 3 > 2 m", "wrong-dimension 1"),
        ("h in [1 s, 2 s]", "wrong-dimension 1"),
        ("h in [1 m, 2 s]", "wrong-dimension 1"),
        ("word in [1, 2]", "wrong-type 1"),
        ("n in word", "wrong-type 1"),
        ("n in rec", "wrong-type 1"),
        ("mode in ['auto', 'manul']", "unknown-word 18"),
        ("items[2 m]", "wrong-dimension 7"),
        ("items[0.5]", "wrong-type 7"),
        ("rec[1]", "wrong-type 5"),
        ("rec['ide']", "unknown-field 5"),
        ("sum([h, t])", "wrong-dimension 1"),
        ("sum([h, 'a'])", "wrong-type 1"),
        ("min([h, t])", "wrong-dimension 1"),
        ("max(h, n, t)", "wrong-dimension 1"),
        ("round(h, 2 m)", "wrong-dimension 1"),
        ("range(h)", "wrong-dimension 1"),
        ("any([1, 2])", "wrong-type 1"),
        ("all(items)", "wrong-type 1"),
        ("distance([1 s, 2, 3], at)", "wrong-dimension 1"),
        ("point(1 s, 2 m, 3 m)", "wrong-dimension 1"),
        ("cos(h)", "wrong-dimension 1"),
        ("cos(word)", "wrong-type 1"),
        ("turn > h / h + t", "wrong-dimension 8"),
        # null
        ("null > 3", "wrong-type 1"),
        ("n + null", "wrong-type 5"),
        ("not null", "wrong-type 5"),
        ("max(n, null)", "wrong-type 1"),
        ("null.x", "unknown-field 1"),
        ("items[null]", "wrong-type 7"),
    ],
)
def test_mistake(text: str, expected: str) -> None:
    assert mistake(text) == expected


def warnings(text: str, *, condition: bool = True) -> list[str]:
    seen = scope()
    compile_expression(text, WHERE, seen, condition=condition)
    return [f"{w.code} {w.where.column if w.where else 0}: {w.message}" for w in seen.warnings]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 > 2", ["1: '1 > 2' is always false"]),
        ("n > 2 and 3 m < 4 m", ["11: '3 m < 4 m' is always true"]),
        ("not (1 > 2)", ["1: 'not (1 > 2)' is always true"]),
        ("yes if 2 == 2 else n > 1", ["8: '2 == 2' is always true"]),
        ("any([a > 2 for a in items if 1 in [1, 2]])", ["30: '1 in [1, 2]' is always true"]),
        ("false", ["1: 'false' is always false"]),
        ("len('abc') > 2 or yes", ["1: 'len('abc') > 2' is always true"]),
        ("never", ["1: '1 > 2' is always false"]),
        ("debug and yes", []),
        ("debug", []),
        ("n > 2", []),
        ("yes", []),
    ],
)
def test_constant_conditions_are_told(text: str, expected: list[str]) -> None:
    assert warnings(text) == [f"constant-condition {each}" for each in expected]


def test_a_constant_that_is_no_condition_is_not_told() -> None:
    assert warnings("1 > 2", condition=False) == []


@pytest.mark.parametrize(
    ("text", "columns"),
    [
        ("turn > 90", [8]),
        ("-90 < turn", [1]),
        ("turn - 180 > 0", [8]),
        ("mod(turn, 360) > 1", [11]),
        ("clamp(turn, -45, 45) > 0", [13, 18]),
        ("sin(90) * n > 0", [5]),
        ("(turn if yes else 45) > 0", [19]),
        ("turn > 6.2832", []),
        ("turn > 90 deg", []),
        ("turn * 90 > 0", []),
        ("h > 90", []),
    ],
)
def test_a_bare_angle_above_a_full_turn_is_told(text: str, columns: list[int]) -> None:
    seen = scope()
    compile_expression(text, WHERE, seen)
    assert [(w.code, w.where and w.where.column) for w in seen.warnings] == [
        ("bare-angle", column) for column in columns
    ]
    if columns:
        assert seen.warnings[0].hint is not None
        assert " deg'?" in seen.warnings[0].hint


@pytest.mark.parametrize(
    "text",
    [
        "cos(h / (2 m) * n) > 0",
        "cos(h / t / (2 m) * t) > 0",
        "turn + h / h > 1",
        "h / h + turn > 1 rad",
        "h / t / h > 30 deg/s",
        "min(turn, h / h) > 30 deg",
    ],
)
def test_a_number_without_dimension_is_an_angle_where_one_is_asked_for(text: str) -> None:
    assert isinstance(value(text), bool)


def test_the_place_decides() -> None:
    assert mistake("h", Number(TIME)) == "wrong-dimension 1"
    assert mistake("h", BOOL) == "wrong-type 1"
    assert compile_expression("2 * h", WHERE, scope(), Number(TIME))(SLOTS) == 5.0


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("itms", "'items'"),
        ("maxx(1)", "'max'"),
        ("n = 3", "`==`"),
        ("yes && yes", "`and`"),
        ("7 % 4", "mod(a, b)"),
        ("yes || yes", "`or`"),
        ("!yes", "`not`"),
        ("~yes", "use `not`"),
        ("$n", "without `$`"),
        ("5 sec", "'sec'"),
        ("id", "'rec.id'"),
        ("len", "function"),
        ("lambda: 1", "define"),
    ],
)
def test_hint(text: str, part: str) -> None:
    with pytest.raises(UserError) as raised:
        compile_expression(text, WHERE, scope())
    assert part in (raised.value.faults[0].hint or "")


HOSTILE = [
    "9**9**9",
    "9**9**9**9**9",
    "'a' * 10**9",
    "[0] * 10**9",
    "'a'.__class__",
    "().__class__.__bases__[0].__subclasses__()",
    "any.__class__",
    "__import__('os')",
    "eval('1')",
    "getattr(n, 'real')",
    "'{0.__class__}'.format(n)",
    "'%s' % n",
    "f'{n.__class__}'",
    "(lambda: 1)()",
    "(x := 5)",
    "round(5, -999999999)",
    "[a for a in big for b in big for c in big for d in big]",
    "len([len([b for b in big]) for a in big for c in big])",
    "sum(1 for a in big for b in big for c in big)",
    "(" * 150 + "1" + ")" * 150,
    "(" * 400 + "1" + ")" * 400,
    "-" * 900 + "1",
    "not " * 190 + "yes",
    "not " * 249 + "yes",
    "abs(" * 90 + "any" + ")" * 90,
    "yes==(" * 60 + "yes" + ")==yes" * 60,
    "[" * 190 + "]" * 190,
    "a" * 1001,
    "+".join(["1"] * 201),
    "99999999999**99*99999999999**99*9e299*9e299",
    "[[[[big for a in big] for a in big] for a in big] for a in big]",
]


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_text_is_refused_quickly(text: str) -> None:
    began = time.process_time()
    try:
        compiled = compile_expression(text, WHERE, scope())
        compiled(SLOTS)
    except (UserError, *FAILURES):
        pass
    else:
        assert text in ("round(5, -999999999)", "(" * 150 + "1" + ")" * 150) or (
            text.startswith(("not ", "yes==", "99999")) or text in HOSTILE[24:27]
        ), "this had a value"
    assert time.process_time() - began < 1.0


def chained(pattern: str, length: int) -> Scope:
    """Defines of which each names the one before it, in the place of ``{}``."""
    made = scope()
    previous = "n"
    for index in range(length):
        body = Scalar(pattern.replace("{}", previous), WHERE)
        previous = f"d{index}"
        made.defines[previous] = Define(previous, (), body, made)
    return made


def test_defines_that_double_each_time_are_refused() -> None:
    began = time.process_time()
    with pytest.raises(UserError) as raised:
        compile_expression("d39", WHERE, chained("{} + {}", 40))
    assert raised.value.code == "expression-too-long"
    assert time.process_time() - began < 1.0


def test_the_expressions_of_a_mission_are_limited_together() -> None:
    made, found = chained("{} + {}", 10), 0
    with pytest.raises(UserError) as raised:
        for _ in range(100):
            compile_expression("d9", WHERE, made.with_event(ANY))
            found += 1
    assert (raised.value.code, raised.value.faults[0].where) == (
        "mission-too-large",
        Where("m.yaml"),
    )
    assert found == 9
    with pytest.raises(UserError, match="mission-too-large"):
        compile_expression("1", WHERE, made)


def test_a_deep_chain_of_defines_is_refused_not_a_crash() -> None:
    made = chained("{} + 1", 900)
    with pytest.raises(UserError) as raised:
        compile_expression("d899", WHERE, made)
    assert raised.value.code == "bad-expression"


def evaluate(text: str) -> None:
    try:
        compiled = compile_expression(text, WHERE, scope())
    except UserError as error:
        str(error)
        return
    for slots in (SLOTS, [None] * len(SLOTS)):
        try:
            compiled(slots)
        except FAILURES:
            continue


@given(st.text(max_size=40))
def test_any_text_gives_a_user_error_or_an_expression(text: str) -> None:
    evaluate(text)


PIECES = [*NAMES, "twice", "far", "1", "2.5", "0", "3 m", "5 s", "30 %", "'a'", "+", "-", "*", "/", "**",
          "(", ")", "[", "]", ",", ".id", ".x", "<", "==", "in", "not", "and", "or", "if", "else",
          "for", "x", "abs", "min", "len", "sum", "round", "sqrt", "sin", "mod", "distance", "point"]  # fmt: skip


@given(st.lists(st.sampled_from(PIECES), max_size=12))
def test_any_words_of_the_language_give_a_user_error_or_an_expression(pieces: list[str]) -> None:
    evaluate(" ".join(pieces))


NUMBERS = st.one_of(st.integers(-99, 99), st.floats(-99, 99, allow_nan=False)).map(
    lambda number: f"({number!r})"
)
ARITHMETIC = st.recursive(
    NUMBERS,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        st.tuples(inner, inner, inner).map(lambda t: f"({t[0]} if {t[1]} < {t[2]} else {t[1]})"),
        inner.map(lambda text: f"(-{text})"),
        inner.map(lambda text: f"abs({text})"),
        st.tuples(inner, inner).map(lambda t: f"max({t[0]}, {t[1]})"),
    ),
    max_leaves=12,
)


def has_value(part: ast.expr) -> bool:
    try:
        return abs(eval(compile(ast.Expression(part), "part", "eval"))) < MAX_NUMBER
    except ArithmeticError:
        return False


@given(ARITHMETIC)
@example("((1) / (2.225073858507203e-309))")
def test_arithmetic_agrees_with_python(text: str) -> None:
    parts = [p for p in ast.walk(ast.parse(text, mode="eval").body) if isinstance(p, ast.expr)]
    # A constant without a value is refused, even in an alternative that is never chosen.
    if all(has_value(part) for part in parts if not isinstance(part, ast.Name)):
        assert value(text) == eval(text)
    else:
        assert mistake(text).startswith("no-value ")
