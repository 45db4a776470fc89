"""The safety proof: what it proves, what it finds, and when it says that it does not know."""

from __future__ import annotations

from dataclasses import replace

import pytest

from behaviors import drone_vocabulary
from fsm import compile_mission, prove, read_mission, warnings_with_proof
from fsm.checks import macrosteps
from runner.missions import SHIPPED
from tests.fsm.toy import VOCABULARY, graph_of, shown
from tests.missions.shipped import MISSIONS

HOST = replace(VOCABULARY, must_land=("link.lost",))
LAND = "  land: {do: settle, on: {done: end}}\n  end: {type: final}\n"
START = "states:\n  fly: {do: go, on: {done: land, blocked: land, link.lost: %s}}\n"
WAIT = "  wait: {do: look, when: {vehicle.battery < 0.2: land}, %s}\n"


def proof_of(text: str) -> list[str]:
    """The faults, each as place, code and path."""
    found = prove(graph_of(text, HOST))
    assert all(fault.severity == "warning" and fault.hint for fault in found)
    return [
        f"{shown(fault)} {fault.message.partition('for ever: ')[2] or fault.message}"
        for fault in found
    ]


@pytest.mark.parametrize("name", MISSIONS)
def test_every_shipped_mission_is_proven(name: str) -> None:
    assert prove(compile_mission(read_mission(SHIPPED / f"{name}.yaml"), drone_vocabulary())) == []


PROVEN = {
    "left to the host": START.replace("link.lost: %s", "operator.abort: land"),
    "handled by landing": START % "land",
    "the host takes what a guard refuses": START % "{guard: 1 > 2, target: land}",
    "an end in the air is landed by the host": START % "end",
    "a wait with a limit": START % "wait" + WAIT % "after: {5 s: land}",
    "a limit whose last alternative has no guard": START % "wait"
    + WAIT % "after: {5 s: [{guard: 1 > 2, target: land}, end]}",
    "an expression that fails is noted": START % "wait"
    + WAIT % "after: {5 s: land}, on: {error.*: {actions: {log: failed}}}",
    "through a choice": START % "choose"
    + "  choose: {always: [{guard: 1 > 2, target: land}, end]}\n",
    "a behaviour that fails is landed by the host": START % "home"
    + "  home: {do: go, on: {done: land, blocked: land}}\n",
    "the outcome of a final child": START % "home"
    + "  home: {on: {done: land}, states: {a: {do: wait, on: {done: b}}, b: {type: final}}}\n",
    "a loop of the other region": """
states:
  fly:
    type: parallel
    on: {link.lost: home}
    states: {a: {do: wait}, b: {do: blink, after: {1 s: {target: b, reenter: true}}}}
  home:
    type: parallel
    on: {operator.abort: land}
    states:
      motion: {states: {back: {do: go, on: {done: land, blocked: land}}}}
      lights:
        states:
          on: {do: blink, after: {1 s: off}}
          off: {after: {1 s: on}}
""",
    "history gives back what lands in time": """
states:
  fly:
    on: {link.lost: pause}
    states:
      one: {do: go, on: {done: two, blocked: land}}
      two: {do: go, on: {done: land, blocked: land}}
      back: {type: history, target: one}
  pause: {after: {5 s: fly.back}}
""",
}  # fmt: skip


@pytest.mark.parametrize("text", PROVEN.values(), ids=PROVEN)
def test_proven(text: str) -> None:
    assert proof_of(text + LAND) == []


VIOLATED = {
    "a hover for ever": (
        START % "wait" + WAIT % "description: x",
        ["2:60 never-lands fly, then 'link.lost' → wait, where it stays"],
    ),
    "taken, and nothing happens": (
        "states:\n  fly: {do: look, on: {link.lost: {}}, when: {vehicle.battery < 0.2: land}}\n",
        ["2:35 never-lands fly, then 'link.lost' → fly, where it stays"],
    ),
    "a loop of two states": (
        START % "there"
        + "  there: {do: go, on: {done: back, blocked: land}}\n"
        + "  back: {do: go, on: {done: there, blocked: land}}\n",
        ["2:60 never-lands fly, then 'link.lost' → there → back → there, and so on"],
    ),
    "a loop to itself": (
        START % "there" + "  there: {do: go, on: {done: land, blocked: there}}\n",
        ["2:60 never-lands fly, then 'link.lost' → there → there, and so on"],
    ),
    "only guarded": (
        START % "wait" + WAIT % "after: {5 s: {guard: 1 > 2, target: land}}",
        ["2:60 never-lands fly, then 'link.lost' → wait, where it stays"],
    ),
    "a guarded transition that may be taken": (
        START % "{guard: vehicle.altitude > 9, target: wait}" + WAIT % "description: x",
        ["2:60 never-lands fly, then 'link.lost' → wait, where it stays"],
    ),
    "an ended behaviour": (
        START % "home" + "  home: {do: go, on: {done: {}, blocked: land}, when: {1 > 2: land}}\n",
        ["2:60 never-lands fly, then 'link.lost' → home, where it stays"],
    ),
    "only after something else": (
        "states:\n  up: {do: wait, on: {done: fly}}\n"
        "  fly: {on: {link.lost: fly}, when: {1 > 2: land}}\n",
        ["3:25 never-lands up → fly, then 'link.lost' → fly, where it stays"],
    ),
    "a region that takes the event and does nothing": (
        """
states:
  fly:
    type: parallel
    on: {operator.abort: land}
    states:
      motion: {do: go, on: {blocked: {}}}
      watch: {do: look, on: {link.lost: {actions: {log: x}}}}
""",
        ["8:41 never-lands fly.watch, then 'link.lost' → fly.watch, where it stays"],
    ),
    "a loop of one region while the other has ended": (
        """
states:
  fly:
    type: parallel
    on: {link.lost: {}, failed: land, operator.abort: land}
    states:
      motion: {do: wait}
      lights: {states: {on: {do: blink, after: {1 s: off}}, off: {after: {1 s: on}}}}
""",
        ["5:21 never-lands fly.motion + fly.lights.on, then 'link.lost' → fly.motion + "
         "fly.lights.on → fly.motion + fly.lights.off → "
         "fly.motion + fly.lights.on, and so on"],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "faults"), VIOLATED.values(), ids=VIOLATED)
def test_violated(text: str, faults: list[str]) -> None:
    assert proof_of(text + LAND) == faults


AWAY = """
  away: {when: {vehicle.battery < 0.2: land}}
"""
GOES = {
    "passed through by `always`": (
        "  down: {do: settle, always: away, on: {done: end}}",
        ["2:60 never-lands fly, then 'link.lost' → away, where it stays"],
    ),
    "passed through by a choice that may pass": (
        "  down: {do: settle, always: {guard: vehicle.altitude > 9, target: away}, "
        "on: {done: end}}",
        ["3:30 left-landing fly, then 'link.lost' → down → away, where it stays",
         "2:60 never-lands fly, then 'link.lost' → away, where it stays"],
    ),
    "passed through by an event of its own": (
        "  down: {do: settle, entry: {raise: no.way}, on: {done: end, no.way: away}}",
        ["2:60 never-lands fly, then 'link.lost' → away, where it stays"],
    ),
    "left by its own timer": (
        "  down: {do: settle, on: {done: end}, after: {5 s: away}}",
        ["3:52 left-landing fly, then 'link.lost' → down → away, where it stays"],
    ),
    "left on a condition": (
        "  down: {do: settle, on: {done: end}, when: {vehicle.altitude > 9: away}}",
        ["3:68 left-landing fly, then 'link.lost' → down → away, where it stays"],
    ),
    "failed, and another state": (
        "  down: {do: settle, on: {done: end, failed: away}}",
        ["3:46 left-landing fly, then 'link.lost' → down → away, where it stays"],
    ),
    "failed, and nothing": (
        "  down: {do: settle, on: {done: end, failed: {}}}",
        ["3:46 left-landing fly, then 'link.lost' → down, where it stays"],
    ),
    "failed, and tried again for ever": (
        "  down: {do: settle, on: {done: end, failed: down}}",
        ["3:46 left-landing fly, then 'link.lost' → down → down, and so on"],
    ),
    "left when an expression fails": (
        "  down: {do: settle, on: {done: end, error.execution: away}}",
        ["3:55 left-landing fly, then 'link.lost' → down → away, where it stays"],
    ),
    "left by an event that was sent": (
        "  down: {do: settle, on: {done: end, no.way: away}, "
        "entry: {send: {event: no.way, delay: 1 s}}}",
        ["3:46 left-landing fly, then 'link.lost' → down → away, where it stays"],
    ),
    "left by an event of a behaviour": (
        "  down: {on: {tag.seen: away}, do: look, states: {a: {do: settle, on: {done: end}}}}",
        ["3:25 left-landing fly, then 'link.lost' → down.a → away, where it stays"],
    ),
    "left by a timer of another region": (
        "  down: {type: parallel, states: {a: {do: settle, on: {done: end}}, "
        "b: {after: {1 s: away}}}}",
        ["3:86 left-landing fly, then 'link.lost' → down.a + down.b → away, where it stays"],
    ),
    "left when the other regions have finished": (
        "  down: {type: parallel, on: {done: away}, states: {a: {do: settle}, b: {do: wait}}}",
        [],
    ),
    "begun anew by the state around it": (
        "  down: {after: {9 s: down}, states: {a: {do: settle, on: {done: end}}}}",
        ["3:23 left-landing fly, then 'link.lost' → down.a → down.a, and so on"],
    ),
    "left for another landing": (
        "  down: {do: settle, on: {done: end, failed: land}, after: {5 s: land}}",
        [],
    ),
    "landed, and waiting on the ground": (
        "  down: {do: settle, on: {done: away}}",
        [],
    ),
    "landed, and up again for ever": (
        "  down: {do: settle, on: {done: up}}\n"
        "  up: {do: rise, with: {height: 1}, on: {done: away}}",
        ["2:60 never-lands fly, then 'link.lost' → down → up → away, where it stays"],
    ),
    "landing again and again": (
        "  down: {do: settle, on: {done: up}}\n"
        "  up: {do: rise, with: {height: 1}, on: {done: down, failed: down}}",
        [],
    ),
    "a timer that is begun anew": (
        "  down: {after: {9 s: land}, states: {a: {do: look, after: {5 s: down}}}}",
        ["2:60 never-lands fly, then 'link.lost' → down.a → down.a, and so on"],
    ),
    "a behaviour that is begun anew": (
        "  down: {do: wait, on: {done: land}, after: {5 s: down}}",
        ["2:60 never-lands fly, then 'link.lost' → down → down, and so on"],
    ),
    "a timer that goes off once": (
        "  down: {after: {5 s: down.b}, states: {a: {do: look}, b: {do: wait, on: {done: land}}}}",
        [],
    ),
    "a timer that has gone off": (
        "  down: {after: {5 s: [{guard: vehicle.altitude > 9, target: land}, {}]}}",
        ["2:60 never-lands fly, then 'link.lost' → down, where it stays"],
    ),
    "a condition that is always true": ("  down: {do: look, when: {1 < 2: land}}", []),
    "a condition that is never true": (
        "  down: {do: wait, on: {done: land}, when: {1 > 2: away}}",
        [],
    ),
    "a condition that is always true, but never has its turn": (
        "  down: {when: {1 < 2: land}, states: "
        "{a: {do: look, when: {vehicle.altitude > 9: {target: down.a}}}}}",
        ["2:60 never-lands fly, then 'link.lost' → down.a → down.a, and so on"],
    ),
    "an event that the other region hears in time": (
        "  down: {type: parallel, states: {a: {do: wait, on: {done: {actions: {raise: go.on}}}}, "
        "b: {on: {go.on: land}}}}",
        [],
    ),
    "an event that another state hears first": (
        "  down: {type: parallel, states: {a: {do: wait, on: {done: {actions: {raise: go.on}}}}, "
        "b: {on: {go.on: land}, states: {c: {on: {go.on: {}}}}}}}",
        ["2:60 never-lands fly, then 'link.lost' → down.a + down.b.c, where it stays"],
    ),
    "a sent event that comes": (
        "  down: {entry: {send: {event: go.on, delay: 1 s}}, on: {go.on: land}}",
        [],
    ),
    "a sent event that is taken back": (
        "  down: {entry: {send: {event: go.on, delay: 1 s}}, on: {go.on: land}, "
        "states: {a: {after: {2 s: b}}, b: {entry: {cancel: go.on}}}}",
        ["2:60 never-lands fly, then 'link.lost' → down.a → down.b, where it stays"],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("state", "faults"), GOES.values(), ids=GOES)
def test_landings_and_waits(state: str, faults: list[str]) -> None:
    assert proof_of(START % "down" + state + AWAY + LAND) == faults


def test_what_a_behaviour_raised_last_is_heard_in_the_next_state() -> None:
    text = "states:\n  fly: {do: look, on: {link.lost: down}}\n"
    text += "  down: {do: settle, on: {done: end, tag.seen: away}}" + AWAY
    assert proof_of(text + LAND) == [
        "3:48 left-landing fly, then 'link.lost' → down → away, where it stays"
    ]
    # By then it has been heard.
    text = text.replace("link.lost: down", "link.lost: rest").replace(AWAY, "\n  rest: %s" + AWAY)
    assert proof_of(text % "{after: {5 s: down}, on: {tag.seen: {}}}" + LAND) == []


def test_a_landing_that_is_left_is_told_of_once() -> None:
    text = (
        START % "down"
        + "  down: {after: {9 s: wait}, states: {a: {do: settle, on: {done: end}}}}\n"
    )
    graph = graph_of(text + "  wait: {when: {1 > 2: land}}\n" + LAND, HOST)
    found = [shown(fault) for fault in warnings_with_proof(graph)]
    assert [line for line in found if "landing" in line] == ["3:23 left-landing"]


def test_each_event_is_reported_and_only_once_for_a_transition() -> None:
    host = replace(VOCABULARY, must_land=("link.lost", "operator.abort"))
    text = """
states:
  fly:
    on: {link.*: wait, operator.abort: wait}
    states: {a: {do: wait, on: {done: b}}, b: {do: wait, on: {done: land}}}
  wait: {when: {1 > 2: land}}
"""
    found = prove(graph_of(text + LAND, host))
    assert [(shown(fault), fault.message.split("'")[1]) for fault in found] == [
        ("4:18 never-lands", "link.lost"),
        ("4:40 never-lands", "operator.abort"),
    ]


def test_a_host_without_such_events_needs_no_proof() -> None:
    assert prove(graph_of(VIOLATED["a hover for ever"][0] + LAND)) == []


def regions(count: int, states: int) -> str:
    """Parallel regions, each a chain that leaves the parallel state at its end."""
    text = "states:\n  fly:\n    type: parallel\n    on: {link.lost: land}\n    states:\n"
    for region in range(count):
        text += f"      r{region}:\n        states:\n"
        for state in range(states):
            target = f"s{state + 1}" if state + 1 < states else "land"
            text += f"          s{state}: {{when: {{vehicle.altitude > {state}: {target}}}}}\n"
    return text + LAND


def test_what_was_not_looked_at_is_not_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    assert proof_of(regions(3, 4)) == []
    monkeypatch.setattr(macrosteps, "MAX_STEPS", 60)
    assert proof_of(regions(3, 4)) == [
        "1:1 not-proven it is not proven that this mission always lands: after 60 steps not "
        "everything had been looked at, such as what follows from fly.r0.s2 + fly.r1.s0 + fly.r2.s0"
    ]


def test_regions_that_touch_nothing_outside_cost_nothing() -> None:
    # 12 regions of 4 states would be 16 million configurations.
    text = regions(12, 4).replace(": land}}", ": s0}}")
    assert proof_of(text) == []


DEEP = """
states:
  fly:
    on: {link.lost: pause}
    states:
      both:
        type: parallel
        states:
          a: {states: {a1: {do: go, on: {blocked: {}, done: a2}}, a2: {%s}}}
          b: {do: look, when: {vehicle.altitude > 9: fly.wait}}
      wait: {do: wait, on: {done: land}}
      back: {type: history, deep: true, target: both}
  pause: {after: {5 s: fly.back}, on: {operator.abort: land}}
"""


def test_the_proof_follows_what_a_deep_history_remembers() -> None:
    assert [line.split()[1] for line in proof_of(DEEP % "do: look" + LAND)] == ["never-lands"]
    text = (DEEP % "after: {5 s: land}").replace("blocked: {}", "blocked: land")
    assert proof_of(text + LAND) == []


PART = """graphs:
  part:
    states:
      one: {do: go, on: {done: two, blocked: two, link.lost: %s}}
      two: {do: wait, on: {done: out}}
      hang: {when: {vehicle.battery < 0.2: out}}
      out: {type: final, outcome: over}
states:
  fly: {include: part, on: {over: %s, failed: land}}
  wait: {when: {vehicle.battery < 0.2: land}}
"""


def test_the_proof_follows_outcomes_out_of_included_graphs() -> None:
    assert proof_of(PART % ("two", "land") + LAND) == []
    assert proof_of(PART % ("hang", "land") + LAND) == [
        "4:62 never-lands fly.one, then 'link.lost' → fly.hang, where it stays"
    ]
    assert proof_of(PART % ("two", "wait") + LAND) == [
        "4:62 never-lands fly.one, then 'link.lost' → fly.two → wait, where it stays"
    ]


def test_an_outcome_handled_inside_leads_nowhere() -> None:
    text = """graphs:
  part:
    states:
      one: {do: wait, on: {done: two, link.lost: two}}
      two: {do: go, on: {done: {}, blocked: {}}, when: {1 > 2: out}}
      out: {type: final, outcome: over}
states:
  fly: {include: part, on: {over: land, failed: land}}
"""
    assert proof_of(text + LAND) == [
        "4:50 never-lands fly.one, then 'link.lost' → fly.two, where it stays"
    ]


def test_an_included_region_ends_its_parallel_state() -> None:
    text = """graphs:
  part: {states: {one: {do: wait, on: {done: out}}, out: {type: final}}}
states:
  up: {do: wait, on: {done: fly, link.lost: fly}}
  fly: {type: parallel, on: {done: %s}, states: {a: {include: part}, b: {do: wait}}}
  wait: {when: {1 > 2: land}}
"""
    assert proof_of(text % "land" + LAND) == []
    assert [line.split(" ")[1] for line in proof_of(text % "wait" + LAND)] == ["never-lands"]
