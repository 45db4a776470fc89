# ruff: noqa: E501  (a mission stands in one line with what becomes of it)
"""Suspending a mission, and parameters that change in flight."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.fsm.toy import VOCABULARY, Run, graph_of
from vencejo.errors import UserError

HELD = replace(
    VOCABULARY,
    events={**VOCABULARY.events, "operator.takeover": {}, "operator.release": {}},
    reactions={
        **VOCABULARY.reactions,
        "operator.takeover": "suspend",
        "operator.release": "resume",
    },
)
WAITS = """\
states:
  a:
    do: go
    with: {to: home}
    entry: {send: {event: my.own, delay: 100 ms}}
    after: {100 ms: b}
    when: {vehicle.altitude > 1 m: {for: 50 ms, actions: {log: "high after ${time_in_state:.3f}"}}}
    on: {my.own: {actions: {log: sent}}, done: b, blocked: b, battery.low: {actions: {log: low}}}
  b: {entry: {log: "b after ${time:.3f}"}, on: {operator.abort: c}}
  c: {type: final}
"""


def test_a_suspended_mission_stands_still_and_goes_on() -> None:
    run = Run("", graph=graph_of(WAITS, HELD))
    run.run(2, altitude=2.0)
    run.post("operator.takeover").run()
    assert run.instance.reactions == [("operator.takeover", {})]
    run.instance.suspend()
    run.take()
    assert run.log == ["begin a", "step a", "step a", "step a", "stop a"]
    assert run.post("battery.low").run(20) == ["a"]
    assert run.take() == []
    run.post("operator.release").run()
    assert run.activities[1].resumed == {"steps": 3}
    assert run.log[5:] == ["begin a", "step a"]
    assert run.logged() == ["low"]
    # Three periods had passed before it, and this one: the clocks stood still meanwhile.
    run.run(3)
    assert run.logged() == ["high after 0.075", "sent", "b after 0.625"]


def test_what_cannot_wait_ends_a_suspension() -> None:
    run = Run("", graph=graph_of(WAITS, HELD))
    run.run()
    run.instance.suspend()
    run.post("operator.abort").run()
    assert run.instance.suspended_at is None
    assert run.instance.reactions == [("operator.abort", {})]


def test_a_mission_that_handles_a_takeover_is_not_suspended() -> None:
    text = "states: {a: {on: {operator.takeover: b}}, b: {on: {operator.release: a, link.lost: c}}, c: {type: final}}"
    run = Run("", graph=graph_of(text, HELD))
    run.run()
    assert run.post("operator.takeover").run() == ["b"]
    assert run.instance.reactions == []


TUNED = """\
parameters: {level: {default: 1 m, min: 0 m, max: 5 m}}
states:
  a: {throughout: {log: "${level:.1f}"}, on: {operator.abort: b}}
  b: {type: final}
"""


def test_a_parameter_changes_in_flight() -> None:
    run = Run(TUNED)
    run.run()
    run.instance.set_parameter("level", 2.5)
    run.run()
    assert run.instance.records[-2:] == [
        ("parameter", {"name": "level", "value": 2.5}),
        ("log", {"text": "2.5"}),
    ]


@pytest.mark.parametrize(
    ("name", "value", "code"),
    [("level", 6.0, "wrong-value"), ("level", "x", "wrong-value"), ("levle", 1.0, "unknown-parameter")],
)  # fmt: skip
def test_a_parameter_keeps_its_bounds(name: str, value: object, code: str) -> None:
    run = Run(TUNED)
    with pytest.raises(UserError) as error:
        run.instance.set_parameter(name, value)
    assert error.value.code == code
    run.run()
    assert run.logged() == ["1.0"]
