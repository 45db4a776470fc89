"""Values that a checked expression can still meet in flight, and the sentences about them."""

from __future__ import annotations

from math import pi
from typing import Any

import pytest

from fsm.expressions.compiled import compile_expression
from fsm.expressions.scope import Binding, Scope
from fsm.values.functions import FAILURES, LOOP_BUDGET, plain
from fsm.values.types import ANY, Number
from tests.fsm.toy import END, Run
from vencejo.errors import Where
from vencejo.geometry import Point


def value(text: str, v: Any = None, *, i: int = 0) -> Any:
    """An expression of `v`, whose type nobody knows, and of the number `i`."""
    scope = Scope()
    scope.names["v"] = Binding("v", "data", ANY, 0)
    scope.names["i"] = Binding("i", "data", Number(), 1)
    return compile_expression(text, Where("m.yaml", 1, 1), scope)([v, i])


def reason(text: str, v: Any = None, *, i: int = 0) -> str:
    """The sentence for the log of an expression that has no value."""
    with pytest.raises(FAILURES) as raised:
        value(text, v, i=i)
    return plain(raised.value)


NESTED: list[Any] = []
for _ in range(60):
    NESTED = [NESTED]


@pytest.mark.parametrize(
    ("text", "v", "expected"),
    [
        ("v + 1", "tag", "tag is no number"),
        ("v + 1", True, "true is no number"),
        ("v + 1", None, "none is no number"),
        ("1 < v", [1], "[1] is no number"),
        ("-v", {"id": 3}, "{id: 3} is no number"),
        ("v + 1", "a" * 41, "a" * 39 + "… is no number"),
        ("v + 1", "a" * 40, "a" * 40 + " is no number"),
        ("not v", 1, "1 is neither true nor false"),
        ("1 if v else 2", "yes", "yes is neither true nor false"),
        ("v and true", None, "none is neither true nor false"),
        ("any(v)", [False, 2], "2 is neither true nor false"),
        ("all(v)", [True, 0.5], "0.5 is neither true nor false"),
        ("v ** 0.5", -1, "a negative number has no such power"),
        ("v ** -1", 0, "a division by zero"),
        ("1 / v", 0, "a division by zero"),
        ("mod(1, v)", 0, "a division by zero"),
        ("v ** 999", 999, "the result is too large"),
        ("v.x", [1, 2, 3], "[1, 2, 3] has no 'x'"),
        ("v.w", Point(1.0, 2.0, 3.0), "(1.00, 2.00, 3.00) has no 'w'"),
        ("v.count", Point(1.0, 2.0, 3.0), "(1.00, 2.00, 3.00) has no 'count'"),
        ("v.id", {"at": 1}, "{at: 1} has no 'id'"),
        ("v.items", {"at": 1}, "{at: 1} has no 'items'"),
        ("v[0]", 3, "3 is no list"),
        ("v[0]", "tag", "tag is no list"),
        ("v[0]", [], "a list of 0 has no element 0"),
        ("v[3]", [1, 2, 3], "a list of 3 has no element 3"),
        ("v[-4]", [1, 2, 3], "a list of 3 has no element -4"),
        ("v[0.5]", [1, 2, 3], "a list of 3 has no element 0.5"),
        ("v['id']", {"at": 1}, "the map has no id"),
        ("1 in v", 3, "3 is no list"),
        ("'a' in v", None, "none is no list"),
        ("[e for e in v]", "tag", "tag is no list"),
        ("min(v)", [], "an empty list has no smallest or largest element"),
        ("max(v)", [1, "b"], "b is no number"),
        ("sum(v)", [1, True], "true is no number"),
        ("sqrt(v)", -0.01, "a negative number has no square root"),
        ("distance(v, [0, 0, 0])", [1, 2, 3, 4], "[1, 2, 3, 4] is no point of the mission frame"),
        ("distance([0, 0, 0], v)", {}, "{} is no point of the mission frame"),
        (
            "distance([0, 0, 0], v)",
            {"lat": 1, "lon": 2},
            "{lat: 1, lon: 2} is no point of the mission frame",
        ),
        (
            "distance([0, 0, 0], v)",
            {"x": 1, "frame": "world"},
            "{x: 1, frame: world} is no point of the mission frame",
        ),
        ("bearing(v, [0, 0, 0])", [1, 2, "z"], "z is no number"),
        ("bearing([0, 0, 0], v)", "pond", "pond is no point of the mission frame"),
        ("v.z", "home", "home has no 'z'"),
        ("range(v)", 1.5, "range() counts in whole numbers"),
        ("range(v)", "a", "a is no number"),
        ("range(v)", 20_001, "more than 20000 steps of loops at once"),
        ("[range(v) for a in [1, 2, 3]]", 9_000, "more than 20000 steps of loops at once"),
        ("[v]", NESTED, "the result has too many lists inside lists"),
        ("[v]", [1e300], "the result is too large a number"),
        ("[v]", ["a" * 1_000_001], "the result is larger than 1 MB"),
    ],
)
def test_what_has_no_value_says_why(text: str, v: Any, expected: str) -> None:
    assert reason(text, v) == expected


@pytest.mark.parametrize(
    ("text", "v", "expected"),
    [
        ("v[-3]", [1, 2, 3], 1),
        ("v[2]", [1, 2, 3], 3),
        ("v['id']", {"id": 4}, 4),
        ("v.id", {"id": 4}, 4),
        ("v.y", Point(1.0, 2.0, 3.0), 2.0),
        ("'id' in v", {"id": 4}, True),
        ("4 in v", {"id": 4}, False),
        ("'ag' in v", "tag", True),
        ("'at' in v", "tag", False),
        ("4 in v", "tag 4", False),
        ("4 in v", [3, 4], True),
        ("4 not in v", [3, 4], False),
        ("min(v)", [3, 1, 2], 1),
        ("max(v)", [3, 1, 2], 3),
        ("min(v)", 3, 3),
        ("range(v)", 3, [0, 1, 2]),
        ("range(1, v)", 3.0, [1, 2]),
        ("range(v, 0, -2)", 5, [5, 3, 1]),
        ("[2 * a for a in range(v)]", 3, [0, 2, 4]),
        ("distance(v, point(3, 4, 9))", "home", 5.0),
        ("distance(point(3, 4, 9), v)", [0, 0], 5.0),
        ("distance(v, [3, 0])", {"x": 0, "y": 4, "frame": "mission"}, 5.0),
        ("distance(v, [3, 4, 9])", {"x": 3}, 0.0),
        ("bearing(v, [0, 2, 9])", "home", pi / 2),
        ("v.x + v.y", "home", 0.0),
        ("v.y", {"x": 1, "y": 2}, 2),
        ("sum(v)", [], 0),
        ("any(v)", [], False),
        ("all(v)", [], True),
        ("sqrt(v)", 0, 0.0),
        ("sign(v)", 0, 0),
        ("sign(v)", 0.1, 1),
        ("sign(v)", -0.1, -1),
        ("round(v)", 3.5, 4),
        ("round(v, 1)", 0.25, 0.2),
        ("round(v, -1)", 26, 30.0),
        ("floor(v)", -0.5, -1),
        ("clamp(v, 0, 1)", -1, 0),
        ("clamp(v, 0, 1)", 2, 1),
        ("clamp(v, 0, 1)", 0.5, 0.5),
        ("mod(v, 4)", -1, 3),
        ("len(v)", {"id": 4}, 1),
        ("distance(v, [1, 2, 5])", (1, 2, 3), 2.0),
        ("v == none", None, True),
    ],
)
def test_a_value_of_unknown_type_is_taken_as_what_it_is(text: str, v: Any, expected: Any) -> None:
    found = value(text, v)
    assert (found, type(found)) == (expected, type(expected))


def test_the_steps_of_all_loops_of_an_evaluation_are_counted_together() -> None:
    half = [0] * (LOOP_BUDGET // 2)
    assert value("len([e for e in v]) + len([e for e in v])", half) == LOOP_BUDGET
    told = reason("len([e for e in v]) + len([e for e in v])", [*half, 0])
    assert told == "more than 20000 steps of loops at once"
    # And each evaluation begins to count anew.
    assert value("len([e for e in v])", half) == len(half)


def test_a_mission_reads_the_sentence_and_the_place_in_the_event() -> None:
    run = Run(
        "mission: m\ndata: {n: 0}\nstates:\n  s:\n    entry: {log: '${1 / n}'}\n"
        "    on: {error.execution: {target: end, actions: "
        "{log: '${event.message} at ${event.where}'}}}\n" + END
    )
    run.run(2)
    assert run.logged() == ["log: a division by zero at m.yaml:5:13"]
