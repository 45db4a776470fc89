"""Expressions and scripts of the Python data model: what it means in Python, or an error."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fsm.expressions.scope import CONFIGURATION_SLOT
from fsm.faults import Faults
from fsm.scxml.datamodel import Names
from fsm.scxml.python import (
    assigned_names,
    compile_condition,
    compile_location,
    compile_script,
    compile_value,
)
from fsm.values.functions import FAILURES, plain
from tests.fsm.one_fault import fault_of
from vencejo.errors import UserError, Where

WHERE = Where("c.scxml", 3, 10)
VALUES: dict[str, Any] = {
    "n": 7,
    "word": "tag",
    "none": None,
    "list_": [3, 1, 2],
    "map_": {"id": 4, "inner": {"deep": [1]}},
}
EVENT = {"name": "tag.seen", "sendid": None, "data": {"id": 9}}
FIRST = CONFIGURATION_SLOT + 1
NAMES = Names(
    variables={name: FIRST + index for index, name in enumerate(["_event", *VALUES])},
    states={"a": 1, "b": 2},
    faults=Faults(),
)

SIGNS = ["+", "-", "*", "/", "//", "%", "**", "<", "<=", "==", "!="]


def slots() -> list[Any]:
    """The configuration, of which state `a` is part; the event; the variables."""
    return [None] * CONFIGURATION_SLOT + [1 << 1, EVENT, *deepcopy(list(VALUES.values()))]


def value(text: str) -> Any:
    return compile_value(text, WHERE, NAMES)(slots(), {})


@pytest.mark.parametrize(
    "text",
    [
        "1 + 2 * 3 - 4 / 2",
        "7 // 2 + -7 % 3",
        "2 ** 100",
        "2 ** -1",
        "-2 ** 2",
        "'a' + 'b' * 3",
        "[1] + [2, 3]",
        "1 < 2 < 3",
        "1 < 3 < 2",
        "not not 3",
        "not 0 and not []",
        "3 and 0 or 'x'",
        "'' or None or []",
        "1 == 1.0",
        "'3' == 3",
        "True + True",
        "1 == True",
        "None is None",
        "'a'.upper() is not None",
        "2 in [1, 2]",
        "'a' not in 'bcd'",
        "'yes' if 0 else 'no'",
        "{'a': [1, 2]}['a'][-1]",
        "(1, 2)[0]",
        "len([1, 2]) + abs(-3) + int('4') + round(2.6)",
        "min(3, 1) + max([2, 5]) + sum([1, 2])",
        "str(1.0) + str(True) + str(None)",
        "float('1.5') + bool([0])",
        "all([1, 0]) or any([0, 1])",
        "'abc'.startswith('ab') and 'abc'.upper() == 'ABC'",
        "{'a': 1}.get('b', 5) + [4, 5].index(5)",
        "'\\u00e4\\x41' 'joined'",
        "0x10 + 0b1 + 1_000",
    ],
)
def test_what_is_run_means_what_it_means_in_python(text: str) -> None:
    found, expected = value(text), eval(text)
    assert (found, type(found)) == (expected, type(expected))


@given(st.integers(-9, 9), st.integers(-9, 9), st.sampled_from(SIGNS))
@settings(max_examples=200)
def test_operators_of_numbers_are_pythons(a: int, b: int, sign: str) -> None:
    text = f"({a}) {sign} ({b})"
    try:
        expected = eval(text)
    except ZeroDivisionError:
        with pytest.raises(ZeroDivisionError):
            value(text)
    else:
        assert value(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("_event.name", "tag.seen"),
        ("_event.data.get('id')", 9),
        ("_event.data['id'] + _event.data.id", 18),
        ("_event.sendid", None),
        ("hasattr(_event, 'sendid')", True),
        ("hasattr(_event, 'x')", False),
        ("map_.inner.deep[0]", 1),
        ("In('a')", True),
        ("In('b')", False),
        ("  n\n + 1", 8),
    ],
)
def test_what_a_document_can_see(text: str, expected: Any) -> None:
    assert value(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [("not not n", True), ("list_", True), ("[]", False), ("{}", False), ("'0'", True)],
)
def test_a_condition_is_true_or_false(text: str, expected: bool) -> None:
    assert compile_condition(text, WHERE, NAMES)(slots(), {}) is expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 'a'", "unsupported operand type"),
        ("1 < 'a'", "'<' not supported"),
        ("1 / 0", "a division by zero"),
        ("(-8) ** 0.5", "a negative number has no such power"),
        ("9 ** 9 ** 9", "the result is too large"),
        ("'a' * 10 ** 9", "the result is larger than 1 MB"),
        ("[0] * 10 ** 9", "the result is larger than 1 MB"),
        ("'%9999999999d' % 1", "a text cannot be filled in"),
        ("list_[5]", "list index out of range"),
        ("map_['x']", "has no 'x'"),
        ("map_.x", "has no 'x'"),
        ("none.x", "none has no 'x'"),
        ("n.get('x')", "7 has no method 'get'"),
        ("none['x']", "none has no 'x'"),
    ],
)
def test_what_has_no_value_says_why(text: str, expected: str) -> None:
    with pytest.raises(FAILURES) as raised:
        value(text)
    assert expected in plain(raised.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "3:10 bad-expression this is no Python: invalid syntax"),
        ("return", "3:10 bad-expression this is no Python: invalid syntax"),
        ("1 = 1", "3:12 bad-expression this is no Python"),
        ("n && 1", "3:13 bad-expression this is no Python"),
        ("1) + (2", "3:11 bad-expression this is no Python: unmatched ')'"),
        ("'\\ud83d'", "3:10 bad-expression half of a letter stands here alone"),
        ("n is 7", "3:10 not-supported `is` between values is not run here"),
        ("lambda: 1", "3:10 not-supported lambda is a part of Python that is not run here"),
        ("[x for x in list_]", "3:10 not-supported listcomp is a part of Python that is not run"),
        ("f'{n}'", "3:10 not-supported joinedstr is a part of Python that is not run here"),
        ("list_[0:1]", "3:16 not-supported slice is a part of Python that is not run here"),
        ("b'a'", "3:10 not-supported constant is a part of Python that is not run here"),
        ("n | 1", "3:10 not-supported bitor is a part of Python that is not run here"),
        ("~n", "3:10 not-supported invert is a part of Python that is not run here"),
        ("open('x')", "3:10 not-supported calling 'open' is not run here"),
        ("list_.append(1)", "3:10 not-supported the method 'append' is not run here"),
        ("round(1.5, ndigits=1)", "3:29 not-supported an argument with a name is not run here"),
        ("{**map_}", "3:13 not-supported `**` is not run here"),
        ("In('a', 'b')", "3:10 not-supported In() of 2 states is not run here"),
        ("1 +" * 400 + "1", "3:10 expression-too-long more than 1000 characters"),
        ("+".join("1" * 210), "3:10 expression-too-long more than 200 parts"),
        ("(" * 300 + ")" * 300, "3:210 bad-expression this is no Python"),
    ],
)
def test_mistake(text: str, expected: str) -> None:
    assert fault_of(compile_value, text, WHERE, NAMES).startswith(expected)


@pytest.mark.parametrize("text", ["().__class__.__bases__", "__import__('os')", "''.format(1)"])
def test_nothing_of_python_itself_is_in_reach(text: str) -> None:
    try:
        function = compile_value(text, WHERE, NAMES)
    except UserError:
        return
    with pytest.raises(FAILURES):
        function(slots(), {})


@pytest.mark.parametrize(
    ("text", "told", "found"),
    [
        ("nn", "3:10 unknown-name there is no variable 'nn'", "there is no variable 'nn'"),
        ("true", "3:10 unknown-name there is no variable 'true'", "there is no variable 'true'"),
        ("n or x", "3:15 unknown-name there is no variable 'x'", 7),
        ("In('c')", "3:13 unknown-state there is no state 'c': In() is false", False),
    ],
)
def test_an_unknown_name_is_a_warning_and_fails_when_it_is_read(
    text: str, told: str, found: Any
) -> None:
    faults = Faults()
    function = compile_value(text, WHERE, replace(NAMES, faults=faults))
    warned = [f"{f.where.line}:{f.where.column} {f.code} {f.message}" for f in faults if f.where]
    assert (warned, faults.errors) == ([told], 0)
    if not isinstance(found, str):
        assert function(slots(), {}) == found
        return
    with pytest.raises(FAILURES) as raised:
        function(slots(), {})
    assert plain(raised.value) == found


@pytest.mark.parametrize(
    ("script", "expected"),
    [
        ("n = 1", {"n": 1}),
        ("n += 2\nword = word + '!'", {"n": 9, "word": "tag!"}),
        ("n = none = 2; pass", {"n": 2, "none": 2}),
        ("list_[0] = n\n   \n   map_['new'] = [1]", {"list_": [7, 1, 2], "map_new": [1]}),
        ("list_[-1] **= 2", {"list_": [3, 1, 4]}),
        ("map_.inner.deep[0] = 5", {"map_inner": {"deep": [5]}}),
    ],
)
def test_the_assignments_of_a_script(script: str, expected: dict[str, Any]) -> None:
    values = slots()
    for statement in compile_script(script, WHERE, NAMES):
        statement.location.assign(values, {}, statement.value(values, {}))
    found = {name: values[NAMES.variables[name]] for name in VALUES}
    found |= {f"map_{key}": inner for key, inner in found["map_"].items()}
    assert {name: found[name] for name in expected} == expected


@pytest.mark.parametrize(
    ("script", "expected"),
    [
        ("x += 1", "3:10 bad-location there is no variable 'x'"),
        ("_event = 1", "3:10 system-variable '_event' cannot be assigned"),
        ("f(1)", "3:10 not-supported an assignment is needed here"),
        ("def f():\n    class A:\n      b = 0\n    return A()", "3:10 not-supported an assignment"),
        ("n, word = 1, 2", "3:10 bad-location this is no variable"),
        ("n = 1\nif n", "4:5 bad-expression this is no Python: expected ':'"),
        ("n: int = 1", "3:10 not-supported an assignment is needed here"),
    ],
)
def test_what_is_no_assignment(script: str, expected: str) -> None:
    assert fault_of(compile_script, script, WHERE, NAMES).startswith(expected)


@pytest.mark.parametrize(
    ("location", "expected"),
    [
        ("'continue'", "3:10 bad-location this is no variable"),
        (" x", "3:11 bad-location there is no variable 'x'"),
        ("_name.x", "3:10 system-variable '_name' cannot be assigned"),
        ("return", "3:10 bad-expression this is no Python: invalid syntax"),
    ],
)
def test_what_cannot_be_assigned(location: str, expected: str) -> None:
    assert fault_of(compile_location, location, WHERE, NAMES) == expected


def test_what_a_script_assigns() -> None:
    assert assigned_names("a = b = 1; c += 1\n   d = 2\n   e[0] = 3") == ["a", "b", "d"]
    assert assigned_names("a = = 1") == []
