"""The safety proof against the engine: every flight of random missions, each claim compared."""

from __future__ import annotations

import pytest

from tests.fsm.exhaustive import VOCABULARY, Flights
from tests.fsm.soundness import compare, summary
from tests.fsm.toy import graph_of

FLY = "states:\n  up: {do: takeoff, on: {done: a}}\n  a: {do: hover, on: {operator.abort: %s}}\n"
LAND = "  land: {do: land, on: {done: finish}}\n  finish: {type: final}\n"


def stays_up(target: str, states: str) -> bool:
    text = FLY % target + states + LAND
    return Flights(graph_of(text, VOCABULARY), text).can_stay_up()


@pytest.mark.parametrize(
    ("target", "states", "stays"),
    [
        ("land", "", False),
        ("b", "  b: {do: hover, after: {5 s: land}}\n", False),
        ("b", "  b: {do: hover, when: {see.a: land}}\n", True),
        ("b", "  b: {after: {9 s: land}, states: {c: {do: hover, after: {5 s: b}}}}\n", True),
        ("b", "  b: {after: {9 s: land}, states: {c: {do: goto, on: {done: {}, blocked: {}}}}}\n",
         False),
        ("b", "  b: {do: goto, on: {done: land, blocked: land}, after: {5 s: b}}\n", True),
        ("b", "  b: {do: land, on: {done: up}}\n", True),
        ("b", "  b: {do: land, on: {done: finish, failed: a}}\n", True),
        ("b", "  b: {do: land, on: {done: look}}\n  look: {do: look, after: {5 s: b}}\n", False),
    ],
)  # fmt: skip
def test_all_flights(target: str, states: str, stays: bool) -> None:
    assert stays_up(target, states) == stays


def test_no_unsound_claim_of_a_few_missions() -> None:
    found = summary(map(compare, range(30)))
    assert found.unsound == ()
    assert found.stays_up >= 8 and found.sound >= 8


@pytest.mark.slow
def test_no_unsound_claim_and_few_false_alarms() -> None:
    found = summary(map(compare, range(10_000, 10_300)))
    assert found.unsound == ()
    assert found.alarm_share <= 0.03, found.false_alarms
    assert found.stays_up >= 60 and found.sound_and_handled >= 60
    assert found.too_large <= 15
