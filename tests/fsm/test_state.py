"""The running state: one value that is saved whole, copied whole and shifted in time."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import pytest

from fsm.engine.events import NOTHING, Delayed
from fsm.engine.saving import save
from fsm.engine.state import Running, State
from fsm.engine.waiting import Armed, Timer
from tests.fsm.test_saving import ROUND, SCRIPT
from tests.fsm.toy import Run

FIELDS = {field.name for field in fields(State)}


def begun(periods: int, text: str = ROUND) -> Run:
    run = Run(text, SCRIPT)
    for number in range(periods):
        if number == 13:
            run.post("turn.back")
        run.run(1, battery=0.4 if number % 16 > 6 else 0.9)
    return run


def test_every_field_of_the_state_is_saved() -> None:
    assert save(begun(1).instance).keys() - {"format", "version", "mission", "digest"} == FIELDS


def test_nothing_but_its_state_changes_in_a_running_instance() -> None:
    """A change anywhere else would not be saved."""
    run = begun(1)
    before = {name: id(value) for name, value in vars(run.instance).items()}
    for number in range(40):
        run.run(1, battery=0.4 if number % 16 > 6 else 0.9)
    assert {name: id(value) for name, value in vars(run.instance).items()} == before


def parts(value: Any) -> Iterator[Any]:
    """Everything in a field that changes in place."""
    if isinstance(value, (Armed, Timer, Delayed, Running)):
        yield value
        if isinstance(value, Armed):
            yield from (value.due, value.spent)
    elif isinstance(value, (list, dict, set, deque)):
        yield value
        for inner in value.values() if isinstance(value, dict) else value:
            yield from parts(inner)


@pytest.mark.parametrize("name", sorted(FIELDS - {"values"}))
def test_a_copy_shares_nothing_that_changes(name: str) -> None:
    state = begun(12).instance.state
    state.delayed.put(Delayed(9.0, "id", NOTHING))
    copy = state.copy()
    assert getattr(copy, name) == getattr(state, name)
    pairs = [*zip(parts(getattr(state, name)), parts(getattr(copy, name)), strict=True)]
    assert [one is other for one, other in pairs] == [False] * len(pairs)
    assert copy.values is not state.values
    assert bool(pairs) == isinstance(getattr(state, name), (list, dict, set, deque))


def without_progress(saved: dict[str, Any]) -> dict[str, Any]:
    """A save without what belongs to the host: of behaviours only whether they have ended."""
    return {**saved, "running": {path: kept is None for path, kept in saved["running"].items()}}


@pytest.mark.parametrize("periods", [1, 5, 9, 12, 14, 20])
def test_a_copy_stays_as_it_was_whatever_becomes_of_the_first(periods: int) -> None:
    run = begun(periods)
    copy, before = run.instance.state.copy(), save(run.instance)
    for _ in range(30):
        run.post("turn.late", k=1).run(1, battery=0.3)
    run.instance.suspend()
    run.run(3)
    run.instance.resume()
    run.instance.stop()
    assert save(run.instance) != before
    run.instance.go_on_from(copy)
    assert without_progress(save(run.instance)) == without_progress(before)


GUARDED = """
data: {n: 0}
states:
  a:
    on:
      word.said: {guard: 1 / n > 1, target: b}
      link.lost: {guard: event.age > 1, target: b}
      battery.low: b
    after: {1 s: b}
    entry: {send: {event: my.own, delay: 2 s}}
  b: {type: final}
"""


@pytest.mark.parametrize(
    ("event", "given", "possible"),
    [
        ("word.said", {"word": ""}, False),
        ("link.lost", {"age": 4.0}, True),
        ("link.lost", {}, False),
        ("battery.low", {"level": 0.1}, True),
        ("my.own", {}, False),
    ],
)
def test_what_may_be_triggered_leaves_state_and_records_alone(
    event: str, given: dict[str, object], possible: bool
) -> None:
    run = begun(3, GUARDED)
    state, records, before = run.instance.state, run.instance.records, save(run.instance)
    told = list(records)
    asked: list[object] = []
    for edge in run.graph.by_path["a"].edges():
        edge.add_callback("prepare", lambda data: asked.append(type(data.model)))
    assert run.instance.may_trigger(event, **given) is possible
    assert run.instance.state is state
    assert run.instance.records is records
    assert (save(run.instance), records) == (before, told)
    assert asked == ([] if event == "my.own" else [type(run.instance)])
