"""Expressions and scripts of the ECMAScript data model: what it means there, or an error."""

from __future__ import annotations

import math
from copy import deepcopy
from dataclasses import replace
from typing import Any

import pytest

from fsm.expressions.scope import CONFIGURATION_SLOT
from fsm.faults import Faults
from fsm.scxml.datamodel import Names
from fsm.scxml.ecmascript import (
    assigned_names,
    compile_condition,
    compile_location,
    compile_script,
    compile_value,
)
from fsm.values.functions import FAILURES, plain
from fsm.values.null import NULL
from tests.fsm.one_fault import fault_of
from vencejo.errors import Where

WHERE = Where("c.scxml", 3, 10)
VALUES: dict[str, Any] = {
    "n": 7,
    "half": 0.5,
    "word": "tag",
    "none": None,
    "null_": NULL,
    "list": [3, 1, 2],
    "map": {"id": 4, "name": "gate"},
}
EVENT = {"name": "tag.seen", "data": {"id": 9}}
FIRST = CONFIGURATION_SLOT + 1
NAMES = Names(
    variables={name: FIRST + index for index, name in enumerate(["_event", *VALUES])},
    states={"a": 1, "b": 2},
    faults=Faults(),
)


def slots() -> list[Any]:
    """The configuration, of which state `a` is part; the event; the variables."""
    return [None] * CONFIGURATION_SLOT + [1 << 1, EVENT, *VALUES.values()]


def value(text: str) -> Any:
    return compile_value(text, WHERE, NAMES)(slots(), {})


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # Words.
        ("true", True),
        ("false", False),
        ("null", NULL),
        ("undefined", None),
        ("1 && 2", 2),
        ("0 && 2", 0),
        ("'' || 'x'", "x"),
        ("false || false || 3", 3),
        ("1 || 0 && 0", 1),
        ("!1 == 2", False),
        ("!!3", True),
        ("typeof n", "number"),
        ("typeof word", "string"),
        ("typeof true", "boolean"),
        ("typeof null", "object"),
        ("typeof list", "object"),
        ("typeof none", "undefined"),
        ("typeof nowhere", "undefined"),
        ("typeof typeof n", "string"),
        ("typeof map.id === 'number'", True),
        # What is true.
        ("[] ? 1 : 2", 1),
        ("'' ? 1 : 2", 2),
        ("0 ? 1 : 2", 2),
        ("null ? 1 : 2", 2),
        ("NaN ? 1 : 2", 2),
        ("map ? 1 : 2", 1),
        ("1 ? 0 ? 1 : 2 : 3", 2),
        # Comparisons.
        ("1 == 1.0", True),
        ("1 === '1'", False),
        ("1 === true", False),
        ("1 == '1'", True),
        ("1 == true", True),
        ("0 != false", False),
        ("'' == 0", True),
        ("' 0x10 ' == 16", True),
        ("'1' == true", True),
        ("'a' == 0", False),
        ("null == undefined", True),
        ("null === undefined", False),
        ("null == 0", False),
        ("null == false", False),
        ("null_ === null", True),
        ("none === undefined", True),
        ("NaN == NaN", False),
        ("NaN != NaN", True),
        ("list == list", True),
        ("[1] == [1]", False),
        ("[1] === [1]", False),
        ("[1] == 1", True),
        ("[1, 2] == '1,2'", True),
        ("map == '[object Object]'", True),
        ("'10' < '9'", True),
        ("'10' < 9", False),
        ("null < 1", True),
        ("undefined < 1", False),
        ("undefined >= 1", False),
        ("'a' < 1", False),
        ("[2] > 1", True),
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
        ("1 + true", 2),
        ("1 + null", 1),
        ("'6' * '7'", 42),
        ("'6' - 1", 5),
        ("'6' + 1", "61"),
        ("+'  12  '", 12),
        ("+true", 1),
        ("-'3'", -3),
        ("1 / 0 > 1e300", True),
        ("1 / -0 < -1e300", True),
        ("0 / 0 === 0", False),
        ("9007199254740992 + 1 === 9007199254740992", True),
        ("5 & 6 | 8 ^ 1", 13),
        ("~5", -6),
        ("1 << 31", -2147483648),
        ("-1 >>> 28", 15),
        ("-9 >> 1", -5),
        ("1 | 2 == 2", 1),
        ("(-2) ** 2", 4.0),
        ("-7 % 4", -3.0),
        ("7 % -4", 3.0),
        ("2 ** -1", 0.5),
        ("+n", 7),
        ("-half", -0.5),
        ("0X1f", 31),
        ("0b101", 5),
        ("0o17", 15),
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
        ("'' + null", "null"),
        ("'' + undefined", "undefined"),
        ("'' + NaN", "NaN"),
        ("'' + (-1 / 0)", "-Infinity"),
        ("'' + 1e-7", "1e-7"),
        ("'' + 0.00001", "0.00001"),
        ("'' + 1.5e-9", "1.5e-9"),
        ("'' + 123456789012345680000", "123456789012345680000"),
        ("'' + 1.5e300", "1.5e+300"),
        ("'' + -0.5", "-0.5"),
        ("'' + [1, [2, null], undefined, 'x']", "1,2,,,x"),
        ("[] + {}", "[object Object]"),
        ("'' + map", "[object Object]"),
        (r"'it\'s\n\t\\'", "it's\n\t\\"),
        (r'"\0\r\b\f\v\q"', "\0\r\b\f\vq"),
        (r"'\x41\u00e4\u{1F600}'", "Aä😀"),
        (r"'\ud83d\ude00'", "😀"),
        ("'a\\\nb'", "ab"),
        # Fields and elements.
        ("map.id", 4),
        ("map['name']", "gate"),
        ("map.nothing", None),
        ("map['nothing']", None),
        ("list.length", 3),
        ("word.length", 3),
        ("list[0]", 3),
        ("list[2]", 2),
        ("list['1']", 1),
        ("list['length']", 3),
        ("list.size", None),
        ("'😀'.length", 2),
        ("{a: 1, 'b': 2, 3: 4, n}.n", 7),
        ("{a: [1, 2,],}['a'].length", 2),
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
        ("Math.floor('2.5')", 2),
        ("Math.max(1, '3', true)", 3),
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
        ("word - 1", "the result is no number"),
        ("-word", "the result is no number"),
        ("none + 1", "the result is no number"),
        ("none.x", "undefined has no 'x'"),
        ("null.x", "null has no 'x'"),
        ("n[0]", "7 has no '0'"),
        ("1 / 0", "the result is too large a number"),
        ("0 / 0", "the result is no number"),
        ("1 % 0", "the result is no number"),
        ("(-8) ** 0.5", "the result is no number"),
        ("10 ** 400", "the result is too large a number"),
        ("Math.max(word)", "the result is no number"),
        ("Math.sqrt(-1)", "the result is no number"),
        ("'😀'[0]", "element 0 of 😀 is half a letter"),
        ("[n, nowhere]", "there is no variable 'nowhere'"),
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
        ("n @ 2", "3:12 bad-expression '@' cannot be read here"),
        ("n +\n  # 2", "4:3 bad-expression '#' cannot be read here"),
        ("map.1", "3:13 bad-expression '.1' does not belong here"),
        ("map.'id'", "3:14 bad-expression ''id'' is no name of a field"),
        ("1 = 1", "3:12 bad-expression '=' does not belong here (`==` compares)"),
        ("return", "3:10 bad-expression 'return' cannot stand here"),
        ("1 and 2", "3:12 bad-expression 'and' does not belong here (`&&`)"),
        ("not 1", "3:14 bad-expression '1' does not belong here"),
        ("-2 ** 2", "3:13 bad-expression put the power, or what stands before it, in parentheses"),
        ("007", "3:10 bad-expression '0' cannot be read here"),
        (r"'\x4'", r"3:10 bad-expression '\x' needs the number of a letter after it"),
        (r"'\u12'", r"3:10 bad-expression '\u' needs the number of a letter after it"),
        (r"'\u{110000}'", r"3:10 bad-expression there is no letter \u{110000}"),
        (r"'\ud83d'", "3:10 bad-expression half of a letter stands here alone"),
        (r"'\01'", r"3:10 bad-expression '\0' is no escape: write \x or \u"),
        (r"'\7'", r"3:10 bad-expression '\7' is no escape: write \x or \u"),
        ("{1 + 1: 2}", "3:13 bad-expression ':' is missing before +"),
        # Well-formed, and not run here.
        ("n = 2", "3:12 not-supported an assignment inside an expression is not run here (`==`"),
        ("n++", "3:11 not-supported '++' is a part of ECMAScript that is not run here"),
        ("n, 2", "3:11 not-supported ',' is a part of ECMAScript that is not run here"),
        ("new Date", "3:10 not-supported 'new' is a part of ECMAScript that is not run here"),
        ("list instanceof Array", "3:15 not-supported 'instanceof' is a part of ECMAScript that"),
        ("x => 2", "3:12 not-supported '=>' is a part of ECMAScript that is not run here"),
        ("`a`", "3:10 not-supported '`' is a part of ECMAScript that is not run here"),
        ("none ?? 2", "3:15 not-supported '??' is a part of ECMAScript that is not run here"),
        ("/a/", "3:10 not-supported patterns are not run here"),
        ("list.push(1)", "3:19 not-supported calls other than In('state') and Math.… are not run"),
        ("String(1)", "3:16 not-supported calls other than In('state') and Math.… are not run"),
        ("Math.sinn(1)", "3:15 unknown-function there is no function 'Math.sinn' here (did you"),
        ("Math.sin()", "3:15 not-supported Math.sin does not take 0 arguments here"),
        ("Math.atan2(1, 2, 3)", "3:15 not-supported Math.atan2 does not take 3 arguments here"),
        ("1" * 1001, "3:10 expression-too-long more than 1000 characters"),
    ],
)
def test_mistake(text: str, expected: str) -> None:
    assert fault_of(compile_value, text, WHERE, NAMES, hint=True).startswith(expected)


@pytest.mark.parametrize(
    ("text", "told", "found"),
    [
        ("x", "3:10 unknown-name there is no variable 'x'", "there is no variable 'x'"),
        (
            "wordy + 1",
            "3:10 unknown-name there is no variable 'wordy'",
            "there is no variable 'wordy'",
        ),
        ("True", "3:10 unknown-name there is no variable 'True'", "there is no variable 'True'"),
        ("true || x", "3:18 unknown-name there is no variable 'x'", True),
        ("In('c')", "3:13 unknown-state there is no state 'c': In() is false", False),
        ("In('a' + '')", None, True),
    ],
)
def test_an_unknown_name_is_a_warning_and_fails_when_it_is_read(
    text: str, told: str | None, found: Any
) -> None:
    faults = Faults()
    function = compile_value(text, WHERE, replace(NAMES, faults=faults))
    warned = [f"{f.where.line}:{f.where.column} {f.code} {f.message}" for f in faults if f.where]
    assert warned == ([told] if told else [])
    assert not faults.errors
    if isinstance(found, bool):
        assert function(slots(), {}) is found
        return
    with pytest.raises(FAILURES) as raised:
        function(slots(), {})
    assert plain(raised.value) == found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("n = 2", [("n", 2)]),
        ("var n = n + 1; let half = 1 / 4;", [("n", 8), ("half", 0.25)]),
        ("n += 2\nn -= 2\nn *= 2\nn /= 2", [("n", 9), ("n", 5), ("n", 14), ("n", 3.5)]),
        ("n |= 8; n <<= 1", [("n", 15), ("n", 14)]),
        ("map.id = 5; map['id'] += 1; list[0]--", [("map", 5), ("map", 5), ("list", 2)]),
        ("const n = '1'; n++", [("n", "1"), ("n", 8)]),
        ("n %= 4; n **= 2", [("n", 3.0), ("n", 49.0)]),
        ("n++; n--", [("n", 8), ("n", 6)]),
        ("word += n", [("word", "tag7")]),
        (";; n = 1 ;;", [("n", 1)]),
        ("", []),
    ],
)
def test_the_assignments_of_a_script(text: str, expected: list[tuple[str, Any]]) -> None:
    found = compile_script(text, WHERE, NAMES)
    assert [(each.location.name, each.value(slots(), {})) for each in found] == expected


@pytest.mark.parametrize(
    ("location", "name", "expected"),
    [
        ("n", "n", 1),
        (" map.id", "map", {"id": 1, "name": "gate"}),
        ("map['new']", "map", {"id": 4, "name": "gate", "new": 1}),
        ("list[n - 7]", "list", [1, 1, 2]),
        ("list[list.length]", "list", [3, 1, 2, 1]),
    ],
)
def test_what_can_be_assigned(location: str, name: str, expected: Any) -> None:
    values = deepcopy(slots())
    compile_location(location, WHERE, NAMES).assign(values, {}, 1)
    assert values[NAMES.variables[name]] == expected


@pytest.mark.parametrize(
    ("location", "expected"),
    [
        ("list[7]", "a list of 3 has no element 7 that can be set"),
        ("list.length", "a list of 3 has no element length that can be set"),
        ("word.x", "tag has no fields that can be set"),
        ("map.none.x", "none has no fields that can be set"),
    ],
)
def test_a_place_that_is_not_there_fails(location: str, expected: str) -> None:
    with pytest.raises(FAILURES, match=expected):
        compile_location(location, WHERE, NAMES).assign(deepcopy(slots()), {}, 1)


def test_a_value_cannot_be_put_into_itself() -> None:
    values = deepcopy(slots())
    place = compile_location("map.id", WHERE, NAMES)
    with pytest.raises(FAILURES, match="too many lists inside lists"):
        place.assign(values, {}, values[NAMES.variables["map"]])
    assert values == slots()


@pytest.mark.parametrize(
    ("location", "expected"),
    [
        ("x", "3:10 bad-location there is no variable 'x'"),
        ("x.y", "3:10 bad-location there is no variable 'x'"),
        ("'continue'", "3:10 bad-location 'continue' is no variable"),
        ("27", "3:10 bad-location 27 is no variable"),
        ("return", "3:10 bad-location return is no variable"),
        ("null", "3:10 bad-location null is no variable"),
        ("_event", "3:10 system-variable '_event' cannot be assigned"),
        ("_event.data", "3:10 system-variable '_event' cannot be assigned"),
        ("n + 1", "3:12 bad-expression '+' does not belong here"),
    ],
)
def test_what_cannot_be_assigned(location: str, expected: str) -> None:
    assert fault_of(compile_location, location, WHERE, NAMES) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("n == 2", "3:12 not-supported an assignment is needed here"),
        ("n", "3:11 not-supported an assignment is needed here"),
        ("if (n) n = 2", "3:10 not-supported an assignment is needed here"),
        ("function f() {}", "3:10 not-supported an assignment is needed here"),
        ("x += 2", "3:10 bad-location there is no variable 'x'"),
        ("n = 1;\n  1 = 2", "4:3 not-supported an assignment is needed here"),
        ("n = ", "3:14 bad-expression nothing follows"),
    ],
)
def test_what_is_no_assignment(text: str, expected: str) -> None:
    assert fault_of(compile_script, text, WHERE, NAMES) == expected


def test_what_a_script_assigns() -> None:
    text = "var a = 1; let b=2\n  c = a == b; d == 1\nvar  e  =  3;f += 1"
    assert assigned_names(text) == ["a", "b", "c", "e"]
