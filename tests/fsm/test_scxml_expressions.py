"""Expressions and scripts of SCXML documents: ECMAScript's values, and Python's words for them."""

from __future__ import annotations

import math
from typing import Any

import pytest

from fsm.expressions.scope import CONFIGURATION_SLOT
from fsm.scxml.ecmascript import (
    Names,
    assigned_names,
    compile_condition,
    compile_script,
    compile_value,
)
from fsm.values.functions import FAILURES, plain
from vencejo.errors import UserError, Where

WHERE = Where("c.scxml", 3, 10)
VALUES: dict[str, Any] = {
    "n": 7,
    "half": 0.5,
    "word": "tag",
    "none": None,
    "list": [3, 1, 2],
    "map": {"id": 4, "name": "gate"},
}
EVENT = {"name": "tag.seen", "data": {"id": 9}}
FIRST = CONFIGURATION_SLOT + 1
NAMES = Names(
    variables={name: FIRST + 1 + index for index, name in enumerate(VALUES)},
    states={"a": 1, "b": 2},
    event_slot=FIRST,
)


def slots() -> list[Any]:
    """The configuration, of which state `a` is part; the event; the variables."""
    return [None] * CONFIGURATION_SLOT + [1 << 1, EVENT, *VALUES.values()]


def value(text: str) -> Any:
    return compile_value(text, WHERE, NAMES)(slots(), {})


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # Words, ours and Python's.
        ("true", True),
        ("True", True),
        ("false", False),
        ("False", False),
        ("null", None),
        ("None", None),
        ("undefined", None),
        ("1 and 2", 2),
        ("0 and 2", 0),
        ("1 or 2", 1),
        ("0 or 2", 2),
        ("false or false or 3", 3),
        ("1 && 2", 2),
        ("'' || 'x'", "x"),
        ("not 0", True),
        ("not 1 == 2", True),
        ("not not n == 7", True),
        ("!1 == 2", False),
        ("!!3", True),
        ("1 is 1", True),
        ("1 or 0 and 0", 1),
        # What is true.
        ("[] ? 1 : 2", 1),
        ("'' ? 1 : 2", 2),
        ("0 ? 1 : 2", 2),
        ("null ? 1 : 2", 2),
        ("1 ? 0 ? 1 : 2 : 3", 2),
        # Comparisons.
        ("1 == 1.0", True),
        ("1 === '1'", False),
        ("1 == true", False),
        ("0 != false", True),
        ("true === true", True),
        ("1 !== 2", True),
        ("'a' < 'b'", True),
        ("2 < 2", False),
        ("2 <= 2", True),
        ("2 > 2", False),
        ("2 >= 2", True),
        ("1 + 1 < 3 == true", True),
        # Arithmetic.
        ("7 - 2 - 1", 4),
        ("7 / 2", 3.5),
        ("-7 % 4", -3.0),
        ("7 % -4", 3.0),
        ("2 ** -1", 0.5),
        ("+n", 7),
        ("-half", -0.5),
        ("0X1f", 31),
        ("007", 7),
        ("1e2", 100.0),
        (".5", 0.5),
        # Texts.
        ("'a' + 1", "a1"),
        ("1 + 'a'", "1a"),
        ("'' + 2.0", "2"),
        ("'' + 2.5", "2.5"),
        ("'' + 1e21", "1e+21"),
        ("'' + true", "true"),
        ("'' + false", "false"),
        ("'' + null", "undefined"),
        ("'' + [1, [2, null], 'x']", "1,2,undefined,x"),
        ("'' + map", "[object Object]"),
        (r"'it\'s\n\t\\'", "it's\n\t\\"),
        (r'"\0\r\b\f\q"', "\0\r\b\fq"),
        # Fields and elements.
        ("map.id", 4),
        ("map['name']", "gate"),
        ("map.nothing", None),
        ("map['nothing']", None),
        ("list.length", 3),
        ("word.length", 3),
        ("list[0]", 3),
        ("list[2]", 2),
        ("list[3]", None),
        ("list[-1]", None),
        ("list[0.5]", None),
        ("word[1]", "a"),
        ("_event.data.id", 9),
        ("_event.name", "tag.seen"),
        ("[[1, 2], [3]][0][1]", 2),
        ("[]", []),
        # States and functions.
        ("In('a')", True),
        ("In('b')", False),
        ('!In("b")', True),
        ("Math.PI", math.pi),
        ("Math.abs(-3)", 3),
        ("Math.ceil(1.2)", 2),
        ("Math.floor(-1.2)", -2),
        ("Math.round(2.5)", 3),
        ("Math.round(-2.5)", -2),
        ("Math.sqrt(9)", 3.0),
        ("Math.sin(0)", 0.0),
        ("Math.cos(0)", 1.0),
        ("Math.atan2(1, 0)", math.pi / 2),
        ("Math.pow(2, 3)", 8.0),
        ("Math.min(3, 1, 2)", 1),
        ("Math.max(3, 1, 2)", 3),
    ],
)
def test_value(text: str, expected: Any) -> None:
    found = value(text)
    assert (found, type(found)) == (expected, type(expected))


def test_what_does_not_decide_is_not_asked() -> None:
    assert value("1 || none.x") == 1
    assert value("0 && none.x") == 0
    assert value("true ? 1 : none.x") == 1
    assert value("false ? none.x : 2") == 2


@pytest.mark.parametrize(
    ("text", "expected"),
    [("[]", True), ("map", True), ("''", False), ("word", True), ("0", False), ("none", False)],
)
def test_a_condition_is_true_or_false(text: str, expected: bool) -> None:
    assert compile_condition(text, WHERE, NAMES)(slots(), {}) is expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + true", "true is no number"),
        ("word - 1", "tag is no number"),
        ("word < 1", "tag is no number"),
        ("-word", "tag is no number"),
        ("none.x", "none has no 'x'"),
        ("list.size", "[3, 1, 2] has no 'size'"),
        ("n[0]", "7 has no elements"),
        ("list['a']", "a is no number"),
        ("1 / 0", "a division by zero"),
        ("(-8) ** 0.5", "a negative number has no such power"),
        ("Math.max(word)", "tag is no number"),
    ],
)
def test_what_has_no_value_says_why(text: str, expected: str) -> None:
    with pytest.raises(FAILURES) as raised:
        value(text)
    assert plain(raised.value) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "3:10 bad-expression nothing follows"),
        ("1 +", "3:13 bad-expression nothing follows"),
        ("1 + )", "3:14 bad-expression ')' cannot stand here"),
        ("(1", "3:12 bad-expression ')' is missing before the end"),
        ("[1 2]", "3:13 bad-expression ',' is missing before 2"),
        ("list[1", "3:16 bad-expression ']' is missing before the end"),
        ("1 ? 2", "3:15 bad-expression ':' is missing before the end"),
        ("1 2", "3:12 bad-expression '2' does not belong here"),
        ("n = 2", "3:12 bad-expression '=' does not belong here (`===` compares)"),
        ("n @ 2", "3:12 bad-expression '@' cannot be read here"),
        ("n +\n  # 2", "4:3 bad-expression '#' cannot be read here"),
        ("map.1", "3:13 bad-expression '.1' does not belong here"),
        ("map.'id'", "3:14 bad-expression ''id'' is no name of a field"),
        ("x", "3:10 unknown-name there is no variable 'x' (known: half, list, map, n, none, word)"),
        ("wordy + 1", "3:10 unknown-name there is no variable 'wordy' (did you mean 'word'?)"),
        ("In('c')", "3:13 unknown-state there is no state 'c' (known: a, b)"),
        ("In(a)", "3:13 unknown-state there is no state a (known: a, b)"),
        ("Math.sinn(1)", "3:15 unknown-function there is no function 'Math.sinn' (did you mean"),
        ("Math.sin()", "3:15 bad-expression Math.sin does not take 0 arguments"),
        ("Math.atan2(1, 2, 3)", "3:15 bad-expression Math.atan2 does not take 3 arguments"),
        ("1" * 1001, "3:10 expression-too-long more than 1000 characters"),
    ],
)
def test_mistake(text: str, expected: str) -> None:
    with pytest.raises(UserError) as raised:
        compile_value(text, WHERE, NAMES)
    (fault,) = raised.value.faults
    assert fault.where is not None
    hint = f" ({fault.hint})" if fault.hint else ""
    told = f"{fault.where.line}:{fault.where.column} {fault.code} {fault.message}{hint}"
    assert told.startswith(expected) if expected.endswith("mean") else told == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("n = 2", [("n", 2)]),
        ("var n = n + 1; let half = 1 / 4;", [("n", 8), ("half", 0.25)]),
        ("n += 2\nn -= 2\nn *= 2\nn /= 2", [("n", 9), ("n", 5), ("n", 14), ("n", 3.5)]),
        ("n %= 4; n **= 2", [("n", 3.0), ("n", 49.0)]),
        ("n++; n--", [("n", 8), ("n", 6)]),
        ("word += n", [("word", "tag7")]),
        (";; n = 1 ;;", [("n", 1)]),
        ("", []),
    ],
)
def test_the_assignments_of_a_script(text: str, expected: list[tuple[str, Any]]) -> None:
    found = compile_script(text, WHERE, NAMES)
    assert [(each.name, each.value(slots(), {})) for each in found] == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("n == 2", "3:12 bad-expression an assignment is needed here"),
        ("n", "3:11 bad-expression an assignment is needed here"),
        ("x = 2", "3:10 unknown-name there is no variable 'x'"),
        ("n = 1;\n  1 = 2", "4:3 unknown-name there is no variable '1'"),
    ],
)
def test_what_is_no_assignment(text: str, expected: str) -> None:
    with pytest.raises(UserError) as raised:
        compile_script(text, WHERE, NAMES)
    (fault,) = raised.value.faults
    assert fault.where is not None
    assert f"{fault.where.line}:{fault.where.column} {fault.code} {fault.message}" == expected


def test_what_a_script_assigns() -> None:
    text = "var a = 1; let b=2\n  c = a == b; d == 1\nvar  e  =  3;f += 1"
    assert assigned_names(text) == ["a", "b", "c", "e"]
