# ruff: noqa: E501  (a mission stands in few lines, so that columns can be counted)
"""The way through a mission: motion on the ground, ends in the air, landings without end."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.fsm.toy import BEHAVIORS, VOCABULARY, graph_of, shown

HOST = replace(
    VOCABULARY,
    behaviors={
        **BEHAVIORS,
        "rise": replace(BEHAVIORS["rise"], parameters={}, takes_off=True),
        "go": replace(BEHAVIORS["go"], needs_flight=True),
        "own": replace(BEHAVIORS["wait"], name="own", controls=("motion",)),
    },
)
RISE = "  rise: {do: rise, on: {done: go}}\n"
LAND = "  land: {do: settle, on: {done: end}}\n  end: {type: final}\n"


def states(*lines: str) -> str:
    return "states:\n" + "".join(f"  {line}\n" for line in lines)


def warnings(text: str) -> list[str]:
    return [shown(fault) for fault in graph_of(text, HOST).warnings]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # nothing takes off
        (states("go: {do: go, on: {done: land, blocked: land}}") + LAND, ["2:3 not-flying"]),
        (states("wait: {do: wait, on: {done: go}}", "go: {do: go, on: {done: land, blocked: land}}") + LAND, ["3:3 not-flying"]),
        (states("go: {do: go, on: {done: more, blocked: land}}", "more: {do: go, on: {done: land, blocked: land}}") + LAND, ["2:3 not-flying"]),
        (states("out: {states: {go: {do: go, on: {done: land, blocked: land}}}}") + LAND, ["2:18 not-flying"]),
        # a branch without a take-off
        (states("pick: {always: [{guard: n > 1, target: go}, rise]}") + RISE + "  go: {do: go, on: {done: land, blocked: land}}\n" + LAND + "data: {n: 0}\n", ["4:3 not-flying"]),
        # on after a landing
        (states("rise: {do: rise, on: {done: land}}", "land: {do: settle, on: {done: go}}", "go: {do: go, on: {done: last, blocked: last}}", "last: {do: settle, on: {done: end}}", "end: {type: final}"), ["4:3 not-flying"]),
        # ends in the air
        (states() + RISE + "  go: {do: go, on: {done: end, blocked: land}}\n" + LAND, ["3:27 ends-in-air"]),
        (states() + RISE + "  go: {do: go, on: {done: end, blocked: end}}\n  end: {type: final}\n", ["3:27 ends-in-air"]),
        (states("rise: {do: rise, on: {done: end}}", "end: {type: final}"), ["2:31 ends-in-air"]),
        (states() + RISE + "  go: {do: go, on: {done: {}, blocked: land}, after: {9 s: end}}\n" + LAND, ["3:60 ends-in-air"]),
        (states() + RISE + "  go: {on: {done: end}, states: {a: {do: go, on: {done: b, blocked: land}}, b: {type: final}}}\n" + LAND, ["3:19 ends-in-air"]),
        # what is only advice changes nothing
        (states() + RISE + "  go: {do: go, on: {done: land, blocked: land, battery.low: end}}\n" + LAND, ["3:61 ends-in-air"]),
        # landings without end
        (states("rise: {do: rise, on: {done: land, failed: end}}", "land: {do: settle, on: {done: rise}}", "end: {type: final}"), ["3:3 endless-landings"]),
        (states("rise: {do: rise, on: {done: go}}", "go: {do: go, on: {done: land, blocked: land, operator.abort: end}}", "land: {do: settle, on: {done: rest}}", "rest: {after: {9 s: rise}}", "end: {type: final}"), ["4:3 endless-landings"]),
        (states("rise: {do: rise, on: {done: land}}", "land: {do: settle, on: {done: rise}}"), ["1:1 never-ends"]),
    ],
)  # fmt: skip
def test_what_is_told(text: str, expected: list[str]) -> None:
    assert warnings(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        states() + RISE + "  go: {do: go, on: {done: land, blocked: land}}\n" + LAND,
        # what a fault or the operator does is the host's
        states() + RISE + "  go: {do: go, on: {done: land, blocked: land, failed: end, operator.abort: end}}\n" + LAND,
        states() + RISE.replace("done: go", "done: go, failed: land") + "  go: {do: go, on: {done: land, blocked: land}}\n" + LAND,
        states("wait: {on: {operator.abort: go}}", "go: {do: go, on: {done: land, blocked: land}}") + LAND,
        # it may fly already, and the mission asks
        states("pick: {after: {1 s: [{guard: vehicle.altitude > 1 m, target: go}, rise]}}") + RISE + "  go: {do: go, on: {done: land, blocked: land}}\n" + LAND,
        states("wait: {when: {vehicle.altitude > 1 m: go}}", "go: {do: go, on: {done: land, blocked: land}}") + LAND,
        # another end than `done` says that something went wrong
        states() + RISE + "  go: {do: go, on: {done: land, blocked: lost}}\n  lost: {type: final, outcome: lost}\n" + LAND,
        # a behaviour of one's own may take off and land by itself
        states("own: {do: own, on: {done: go}}", "go: {do: go, on: {done: own2, blocked: own2}}", "own2: {do: own, on: {done: end}}", "end: {type: final}"),
        # nothing flies at all
        states("wait: {do: wait, on: {done: end}}", "end: {type: final}"),
        # three rounds
        "data: {n: 0}\n" + states("rise: {do: rise, on: {done: land}}", "land: {do: settle, on: {done: [{guard: n < 3, target: rise, actions: {set: {n: '${n + 1}'}}}, end]}}", "end: {type: final}"),
        # as long as somebody wants
        "events: {work.over: {}}\n" + states("rise: {do: rise, on: {done: land}}", "land: {do: settle, on: {done: rest}}", "rest: {after: {9 s: rise}, on: {work.over: end}}", "end: {type: final}"),
        # one region watches while another takes off
        states("work:", "  type: parallel", "  on: {my.seen: go}", "  states:", "    up: {do: rise, on: {done: {}}}", "    eye: {do: look, after: {1 s: {actions: {raise: my.seen}}}}", "go: {do: go, on: {done: land, blocked: land}}") + LAND,
        # back to where it was, in the air again
        states("rise: {do: rise, on: {done: work.back}}", "work: {on: {battery.low: land}, states: {go: {do: go, on: {done: more, blocked: more}}, more: {do: go, on: {done: last, blocked: last}}, back: {type: history, target: go}}}", "land: {do: settle, on: {done: rise}}", "last: {do: settle, on: {done: end}}", "end: {type: final}").replace("battery.low: land", "my.low: land") + "events: {my.low: {}}\n",
    ],
)  # fmt: skip
def test_what_is_right_is_not_told(text: str) -> None:
    assert warnings(text) == []


def test_the_way_is_shown() -> None:
    text = states() + RISE + "  go: {do: go, on: {done: end, blocked: land}}\n" + LAND
    (fault,) = graph_of(text, HOST).warnings
    assert fault.message == "the mission ends in the air: rise → go → end"
    assert fault.severity == "warning"


def test_what_an_error_may_hide_is_not_told() -> None:
    text = states("up: {do: rize, on: {done: go}}", "go: {do: go, on: {done: land, blocked: land}}")
    with pytest.raises(Exception, match="rize") as raised:
        graph_of(text + LAND, HOST)
    assert [shown(fault) for fault in raised.value.faults] == ["2:12 unknown-behaviour"]  # type: ignore[attr-defined]


def test_a_graph_in_the_air_may_include_one_that_takes_off_nowhere() -> None:
    text = (
        "graphs: {leg: {states: {go: {do: go, on: {done: end, blocked: end}}, end: {type: final}}}}\n"
        + states("rise: {do: rise, on: {done: leg}}", "leg: {include: leg, on: {done: land}}")
        + LAND
    )
    assert warnings(text) == []
    on_ground = text.replace("  rise: {do: rise, on: {done: leg}}\n", "")
    assert warnings(on_ground) == ["1:25 not-flying"]
