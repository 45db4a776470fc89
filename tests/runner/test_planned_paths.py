"""The ways that a mission may fly, followed over its graph."""

from __future__ import annotations

from typing import Any

import pytest

from behaviors import MissionFrame, drone_vocabulary
from fsm import compile_mission, read_mission_text
from hal import flight_model
from runner.planned_motion import Setting
from runner.planned_paths import PossiblePaths, possible_paths
from vencejo.geometry import Point

END = """
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


def paths(states: str, top: str = "", **parameters: Any) -> PossiblePaths:
    up = "  up: {do: takeoff, with: {altitude: 2 m}, on: {done: a}}"
    text = f"mission: m\n{top}\nstates:\n{up}\n"
    graph = compile_mission(read_mission_text(text + states + END, "m.yaml"), drone_vocabulary())
    frame = MissionFrame(Point(0.0, 0.0, 0.0), {"gate": Point(7.0, 7.0, 2.0)})
    setting = Setting(frame, 0.0, lambda place: 0.0, model=flight_model("sim"))
    return possible_paths(graph, parameters, setting)


def legs(found: PossiblePaths, state: str) -> list[tuple[Any, Any]]:
    """The begins and ends of a state's legs, as whole numbers, those that are sure."""
    return [
        (leg.begin and tuple(round(v) for v in leg.begin), tuple(round(v) for v in leg.leg.to))
        for leg in found.legs
        if leg.node.path == state and leg.sure
    ]


def goto(name: str, to: str, then: str) -> str:
    return f"  {name}: {{do: goto, with: {{to: {to}}}, on: {{done: {then}, blocked: land}}}}\n"


def test_legs_follow_each_other() -> None:
    found = paths(goto("a", "[4, 0, 2]", "b") + goto("b", "[4, 4, 3]", "land"))
    assert legs(found, "up") == [((0, 0, 0), (0, 0, 2))]
    assert legs(found, "a") == [((0, 0, 2), (4, 0, 2))]
    assert legs(found, "b") == [((4, 0, 2), (4, 4, 3))]
    assert ((4, 4, 3), (4, 4, 0)) in legs(found, "land")
    assert found.unknown == {} and found.complete
    (last,) = [leg for leg in found.legs if leg.node.path == "b"]
    assert last.way == "up → a → b" and last.charge > 0


def test_what_interrupts_begins_anywhere_along_the_leg() -> None:
    found = paths(
        "  a: {do: goto, with: {to: [8, 0, 2]}, on: {done: land, blocked: land, battery.low: b}}\n"
        + goto("b", "[0, 8, 2]", "land")
    )
    begins = sorted(leg.begin.x for leg in found.legs if leg.node.path == "b" and leg.begin)
    assert begins[0] == 0 and begins[-1] == 8 and len(begins) == 6
    assert not any(leg.sure for leg in found.legs if leg.node.path == "b")


def test_an_inner_handler_keeps_the_outer_one_from_an_event() -> None:
    text = (
        "  a:\n    on: {battery.low: b}\n    states:\n"
        "      in: {do: goto, with: {to: [8, 0, 2]}, "
        "on: {done: land, blocked: land%s}}\n" + goto("b", "[0, 8, 2]", "land")
    )
    assert [leg.node.path for leg in paths(text % "").legs].count("b") == 6
    assert "b" not in [leg.node.path for leg in paths(text % ", battery.low: land").legs]


@pytest.mark.parametrize(("n", "expected"), [(1, ["b"]), (2, ["c"])])
def test_guards_of_known_values_decide(n: int, expected: list[str]) -> None:
    states = (
        "  a: {always: [{guard: n == 1, target: b}, c]}\n"
        + goto("b", "[8, 0, 2]", "land")
        + goto("c", "[0, 8, 2]", "land")
    )
    found = paths(states, f"parameters: {{n: {n}}}")
    assert [leg.node.path for leg in found.legs if leg.node.path in "abc"] == expected
    other = paths(states, "parameters: {n: 5}", n=n)
    assert [leg.node.path for leg in other.legs if leg.node.path in "abc"] == expected


def test_guards_of_the_flight_both_pass_and_do_not() -> None:
    found = paths(
        "  a: {always: [{guard: vehicle.battery > 50 %, target: b}, c]}\n"
        + goto("b", "[8, 0, 2]", "land")
        + goto("c", "[0, 8, 2]", "land")
    )
    assert {leg.node.path for leg in found.legs} == {"up", "b", "c", "land"}


def test_a_condition_that_must_last_is_not_sure_to() -> None:
    found = paths(
        "  a: {do: hover, when: {vehicle.altitude > 1 m: [{for: 3 s, target: b}, c]}}\n"
        + goto("b", "[8, 0, 2]", "land")
        + goto("c", "[0, 8, 2]", "land")
    )
    assert {leg.node.path for leg in found.legs} == {"up", "a", "b", "c", "land"}


def test_data_that_an_event_of_the_flight_sets_are_unknown() -> None:
    found = paths(
        "  a: {do: hover, on: {seen.it: {target: b, actions: {set: {spot: $event.at}}}}}\n"
        "  b: {do: goto, with: {to: $spot}, on: {done: c, blocked: land}}\n"
        + goto("c", "[0, 8, 2]", "land"),
        "events: {seen.it: {at: point}}\ndata: {spot: {type: point, default: [1, 1, 2]}}",
    )
    assert {node.path for node in found.unknown} == {"b"}
    assert [leg.begin for leg in found.legs if leg.node.path == "c"] == [None]


def test_what_raises_is_heard_at_once_and_only_then() -> None:
    found = paths(
        "  a:\n    on: {go.now: c}\n    states:\n"
        "      in: {do: goto, with: {to: [8, 0, 2]}, on: {done: {actions: {raise: go.now}}, "
        "blocked: land}}\n" + goto("c", "[0, 8, 2]", "land")
    )
    assert legs(found, "c") == [((8, 0, 2), (0, 8, 2))]
    assert [leg.node.path for leg in found.legs].count("c") == 1


def test_a_parallel_state_is_done_when_all_its_regions_are() -> None:
    found = paths(
        "  a:\n    type: parallel\n    states:\n"
        "      fly: {states: {go: {do: goto, with: {to: [8, 0, 2]}, on: {done: there, "
        "blocked: land}}, there: {type: final}}}\n"
        "      look: {states: {wait: {after: {3 s: seen}}, seen: {type: final}}}\n"
        "    on: {done: b}\n" + goto("b", "[0, 8, 2]", "land")
    )
    assert legs(found, "b") == [((8, 0, 2), (0, 8, 2))]


def test_another_region_moves_on_while_one_flies() -> None:
    found = paths(
        "  a:\n    type: parallel\n    states:\n"
        "      fly: {do: goto, with: {to: [8, 0, 2]}}\n"
        "      look: {states: {wait: {after: {1 s: leave}}, leave: {always: b}}}\n"
        "    on: {blocked: land}\n" + goto("b", "[0, 8, 2]", "land")
    )
    begins = [leg.begin.x for leg in found.legs if leg.node.path == "b" and leg.begin]
    assert len(begins) > 1 and max(begins) <= 8


def test_history_leads_back_to_where_it_was_left() -> None:
    found = paths(
        "  a:\n    on: {battery.low: pause}\n    states:\n"
        "      one: {do: goto, with: {to: [8, 0, 2]}, on: {done: two, blocked: land}}\n"
        "      two: {do: goto, with: {to: [8, 8, 2]}, on: {done: land, blocked: land}}\n"
        "      back: {type: history, target: one}\n"
        "  pause: {do: goto, with: {to: [0, 0, 2]}, on: {done: a.back, blocked: land}}\n"
    )
    assert ((0, 0, 2), (8, 8, 2)) in legs(found, "a.two")
    assert found.complete


def test_a_route_that_goes_on_in_its_midst_is_unknown() -> None:
    found = paths(
        "  a:\n    on: {battery.low: pause}\n    states:\n"
        "      one: {do: route, with: {points: [[8, 0, 2], [8, 8, 2]]}, "
        "on: {done: land, blocked: land}}\n"
        "      back: {type: history, target: one}\n"
        "  pause: {do: goto, with: {to: [0, 0, 2]}, on: {done: a.back, blocked: land}}\n"
    )
    assert next(node.path for node in found.unknown) == "a.one"


def test_places_of_the_world_and_points_ahead_are_known() -> None:
    found = paths(goto("a", "gate", "b") + goto("b", "{forward: 3 m, up: 1 m}", "land"))
    assert legs(found, "a") == [((0, 0, 2), (7, 7, 2))]
    assert legs(found, "b") == [((7, 7, 2), (10, 7, 3))]  # the heading was kept: east


def test_an_included_graph_is_followed_with_what_it_is_given() -> None:
    found = paths(
        "  a: {include: visit, with: {at: [8, 0, 2]}, on: {done: land, blocked: land}}\n",
        "graphs:\n  visit:\n    parameters: {at: {type: point}}\n    states:\n"
        "      go: {do: goto, with: {to: $at}, on: {done: over, blocked: lost}}\n"
        "      over: {type: final}\n      lost: {type: final, outcome: blocked}\n",
    )
    assert ((8, 0, 2), (8, 0, 0)) in legs(found, "land")
    assert next(leg.leg.to for leg in found.legs if leg.begin == (0, 0, 2)) == (8, 0, 2)


def test_a_loop_without_end_becomes_unknown_and_comes_to_an_end() -> None:
    found = paths(
        '  a: {do: goto, with: {to: ["${n}", 0, 2]}, on: {done: {target: a, reenter: true, '
        'actions: {set: {n: "${n + 1}"}}}, blocked: land}}\n',
        "data: {n: 0}",
    )
    assert found.complete and "a" in {node.path for node in found.unknown}
    assert len(legs(found, "a")) > 20


def test_nothing_flies_before_a_take_off() -> None:
    text = "mission: m\nstates:\n" + goto("a", "[8, 0, 2]", "land") + END
    graph = compile_mission(read_mission_text(text, "m.yaml"), drone_vocabulary())
    setting = Setting(MissionFrame(Point(0.0, 0.0, 0.0)), 0.0, lambda place: 0.0)
    assert [leg.node.path for leg in possible_paths(graph, {}, setting).legs] == ["land"]
