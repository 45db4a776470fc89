"""Where missions may fly, held against their worlds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import pytest

from behaviors import drone_vocabulary, load_all
from fsm import compile_mission, read_mission_text
from hal import Limits, flight_model
from runner import missions, prepare, prepare_fleet
from runner.fleets import check_ways
from runner.geometry import Findings, Terms, check_geometry
from tests.missions.shipped import FLEETS, MISSIONS
from vencejo.errors import UserError, Where
from vencejo.nodes import Scalar
from worlds import World, find_world
from worlds.loader import read_world

SIM = Terms(flight_model("sim"))
PLANNED = {"beacon_route", "figure_eight", "first_flight", "inspect_tower", "survey_square"}
"""Shipped missions whose ways are all known before the flight."""
FLIGHT = """
mission: flight
{top}
states:
  takeoff: {{do: takeoff, with: {{altitude: 2 m}}, on: {{done: go}}}}
  {go}
  home: {{do: goto, with: {{to: home}}, on: {{done: land, blocked: land}}}}
  land: {{do: land, on: {{done: finish}}}}
  finish: {{type: final}}
"""
GO = "go: {{do: goto, with: {{to: {to}}}, on: {{done: home, blocked: land}}}}"


def checked(
    text: str, world: World | str = "empty", terms: Terms = SIM, own: Any = None, **parameters: Any
) -> Findings:
    place = find_world(world) if isinstance(world, str) else world
    graph = compile_mission(read_mission_text(text, "m.yaml"), drone_vocabulary(own, place.places))
    return check_geometry(graph, place, terms, parameters)


def flight(go: str, top: str = "") -> str:
    return FLIGHT.format(go=go, top=top)


def to(point: str) -> str:
    return flight(GO.format(to=point))


def told(findings: Findings) -> list[tuple[str, str]]:
    return [(fault.code, str(fault.where)) for fault in findings.faults]


def codes(findings: Findings) -> list[str]:
    return [fault.code for fault in findings.faults]


def only(findings: Findings) -> str:
    (fault,) = findings.faults
    assert fault.severity == "warning" and fault.hint
    return fault.message


def test_a_point_below_the_ground_is_told_with_its_place_and_the_way() -> None:
    findings = checked(to("[5, 0, -3]"))
    assert told(findings) == [("below-ground", "m.yaml:6:29")]
    assert "ends 3 m below the ground: takeoff → go" in only(findings)


def test_a_start_above_the_ground_counts_from_there() -> None:
    world = read_world("world: w\nstart: {at: [3, -4, 0.8]}\n", "w.yaml")
    assert codes(checked(to("[9, 0, -0.5]"), world)) == []
    assert "ends 0.2 m below" in only(checked(to("[9, 0, -1]"), world))


def test_a_leg_through_a_hill_is_told_where() -> None:
    world = read_world(
        "world: w\nstart: {at: [-25, 0]}\nground: {terrain: {size: 40 m, heights: "
        "[[0, 0, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 6, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]}}",
        "w.yaml",
    )
    findings = checked(to("[50, 0, 2]"), world)
    assert set(codes(findings)) == {"below-ground"}
    assert "leads through the ground near [25, 0, 2]" in findings.faults[0].message
    assert codes(checked(to("[25, 0, 7]"), world)) == []


def test_a_leg_through_the_wall_of_the_yard_is_told_with_its_name() -> None:
    findings = checked(to("[0, 20, 1]"), "yard")
    assert told(findings)[0] == ("hits-thing", "m.yaml:6:29")
    message = findings.faults[0].message
    assert "leads through the box 'wall' near [0, 11.85, 1.41]: takeoff → go" in message
    assert codes(checked(to("[0, 20, 5]"), "yard")) == []


def test_what_leads_out_of_a_thing_is_not_told_again() -> None:
    text = flight(
        "go: {do: goto, with: {to: [6, 2, 1]}, on: {done: on, blocked: land}}\n"
        "  on: {do: goto, with: {to: [12, 2, 1]}, on: {done: land, blocked: land}}"
    )
    assert told(checked(text, "yard")) == [("hits-thing", "m.yaml:6:29")]


def test_an_end_inside_a_thing_is_into_it() -> None:
    assert "into the box 'wall'" in checked(to("[0, 12, 1]"), "yard").faults[0].message


@pytest.mark.parametrize(
    ("height", "distance"), [(2.3, "0.30"), (2.45, "0.45"), (2.498, "0.49"), (2.55, None)]
)
def test_a_leg_that_passes_nearer_than_the_clearance_is_told_with_the_distance(
    height: float, distance: str | None
) -> None:
    text = to(f"[0, 20, {height}]").replace("altitude: 2 m", f"altitude: {height} m")
    findings = checked(text, "yard")
    if distance is None:
        assert codes(findings) == []
        return
    assert set(codes(findings)) == {"near-thing"}
    assert f"passes {distance} m from the box 'wall'" in findings.faults[0].message
    assert codes(checked(text, "yard", replace(SIM, clearance=0.1))) == []


def test_of_many_things_in_the_way_of_one_state_five_are_told() -> None:
    boxes = "\n".join(f"  b{k}: {{at: [{3 * k}, 0], size: [1, 1, 4]}}" for k in range(1, 9))
    findings = checked(to("[30, 0, 2]"), read_world(f"world: w\nboxes:\n{boxes}\n", "w.yaml"))
    there = [fault for fault in findings.faults if str(fault.where) == "m.yaml:6:29"]
    assert [fault.code for fault in there] == ["hits-thing"] * 5
    assert there[-1].hint == "fly over it or around it; 3 more things are as near"


def test_a_landing_on_a_thing_and_a_take_off_from_it_are_meant() -> None:
    assert codes(checked(to("[3, -4, 2]").replace("done: home", "done: land"), "yard")) == []
    world = read_world(
        "world: w\nstart: {at: [3, -4, 0.8]}\nboxes: {table: {at: [3, -4], size: [2, 2, 0.8]}}\n",
        "w.yaml",
    )
    assert codes(checked(to("[9, 0, 2]"), world)) == []


def test_a_landing_beside_a_thing_is_told() -> None:
    world = read_world("world: w\nboxes: {box: {at: [5.8, 0], size: [1, 1, 1]}}\n", "w.yaml")
    findings = checked(to("[5, 0, 3]").replace("done: home", "done: land"), world)
    assert [(f.code, str(f.where)) for f in findings.faults] == [("near-thing", "m.yaml:8:3")]
    assert "0.30 m from the box 'box'" in only(findings)


ROUTE = (
    "go: {do: route, with: {points: [[0, 6, 2], [9, 6, 2], [9, -6, 2]]}, "
    "on: {done: land, blocked: land%s}}"
)


def test_the_way_home_is_looked_at_from_wherever_it_can_begin() -> None:
    # The route goes round the shed, the way home from half of it leads through.
    assert codes(checked(flight(ROUTE % ""), "yard")) == []
    findings = checked(flight(ROUTE % ", battery.low: home"), "yard")
    assert [(f.code, str(f.where)) for f in findings.faults] == [("hits-thing", "m.yaml:7:31")]
    assert "the box 'shed'" in only(findings) and only(findings).endswith("takeoff → go → home")


def test_return_home_flies_as_high_as_the_vehicle_returns() -> None:
    text = flight(ROUTE % ", battery.low: home").replace(
        "do: goto, with: {to: home}", "do: return_home"
    )
    text = text.replace("on: {done: land, blocked: land}}\n  land", "on: {done: finish}}\n  land")
    assert codes(checked(text, "yard")) == []
    unknown = checked(text, "yard", Terms()).unknown
    assert unknown == ("home",), "without a model of the vehicle its height is not known"


def test_a_loop_over_data_is_flown_point_by_point() -> None:
    text = """
mission: rounds
world: yard
parameters: {stops: {type: [point], default: [[0, 6, 2], [9, 6, 2], [9, -6, 2], [0, 0, 2]]}}
data: {n: 0}
states:
  takeoff: {do: takeoff, with: {altitude: 2 m}, on: {done: choose}}
  choose: {always: [{guard: n < len(stops), target: leg}, land]}
  leg:
    do: goto
    with: {to: "${stops[n]}"}
    on: {done: {target: choose, actions: {set: {n: "${n + 1}"}}}, blocked: land}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""
    assert codes(checked(text, "yard")) == []
    crossing = text.replace("[9, -6, 2], [0, 0, 2]", "[0, 0, 2]")
    findings = checked(crossing, "yard")
    assert "from [9, 6, 2] to [0, 0, 2] leads through the box 'shed'" in only(findings)
    assert findings.unknown == () and findings.complete


def test_parameters_of_a_run_count() -> None:
    text = flight(GO.format(to="$where"), "parameters: {where: {type: point, default: [0, 9, 2]}}")
    assert codes(checked(text, "yard")) == []
    assert codes(checked(text, "yard", where={"x": 0.0, "y": 14.0}))[0] == "hits-thing"
    assert codes(checked(text, "yard", where="table_top"))[0] in ("hits-thing", "near-thing")


def test_what_a_timer_interrupts_is_flown_no_farther() -> None:
    late = (
        "go: {do: goto, with: {to: [0, 20, 1], speed: 1 m/s}, "
        "on: {done: home, blocked: land}, after: {%s: home}}"
    )
    assert codes(checked(flight(late % "5 s"), "yard")) == []
    assert "hits-thing" in codes(checked(flight(late % "15 s"), "yard"))


def test_limits_above_home() -> None:
    terms = replace(SIM, limits=Limits(max_altitude=3.0, min_altitude=1.0))
    assert codes(checked(to("[5, 0, 3]"), terms=terms)) == []
    assert "above the limit of 3 m" in only(checked(to("[5, 0, 3.5]"), terms=terms))
    assert "below the limit of 1 m" in checked(to("[5, 0, 0.5]"), terms=terms).faults[0].message


FENCED = "world: w\nfence: {through: [[-5, -5], [9, -5], [9, 5], [-5, 5]], floor: 1, ceiling: 4}\n"


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ("[8, 0, 2]", None),
        ("[10, 0, 2]", "out of the fence"),
        ("[8, 0, 5]", "above the ceiling of the fence, 4 m"),
        ("[8, 0, 0.5]", "below the floor of the fence, 1 m"),
    ],
)
def test_the_fence_of_the_world(point: str, expected: str | None) -> None:
    findings = checked(to(point), read_world(FENCED, "w.yaml"))
    assert set(codes(findings)) == ({"outside-fence"} if expected else set())
    assert expected is None or expected in findings.faults[0].message


def test_a_leg_farther_than_the_battery_lasts_is_told_with_the_point_of_no_return() -> None:
    findings = checked(to("[2000, 20, 400]"))
    (fault,) = findings.faults
    assert (fault.code, str(fault.where)) == ("beyond-battery", "m.yaml:6:29")
    assert "critical after 1217 m of 2039 m" in fault.message
    assert fault.hint is not None and fault.hint.startswith("the point of no return is [7")


def test_a_leg_from_which_nothing_brings_it_home_is_told() -> None:
    assert codes(checked(to("[500, 0, 2]"))) == []
    there = checked(to("[1000, 0, 2]").replace("done: home", "done: land"))
    assert codes(there) == ["no-return"]
    assert codes(checked(to("[1000, 0, 2]"), terms=Terms())) == [], (
        "without a model nothing is known"
    )


def test_what_was_used_before_counts_and_so_does_the_world_s_battery() -> None:
    hover = flight(
        "go: {do: hover, after: {8 min: far}}\n"
        "  far: {do: goto, with: {to: [300, 0, 2]}, on: {done: land, blocked: land}}"
    )
    assert codes(checked(hover)) == ["beyond-battery"]
    assert codes(checked(hover.replace("8 min", "1 min"))) == []
    assert codes(checked(to("[150, 0, 2]"), read_world("world: w\nbattery: 25 %\n", "w"))) == [
        "beyond-battery"
    ]


@pytest.mark.parametrize("call", ["call: swap_battery", "call: {swap_battery: {}}"])
def test_how_full_the_battery_is_after_a_swap_or_on_a_charger_is_unknown(call: str) -> None:
    far = (
        "go: {do: goto, with: {to: [1200, 0, 2]}, on: {done: down, blocked: down}}\n"
        "  down: {do: land, on: {done: fresh}}\n"
        "  fresh: {entry: [call], after: {1 s: up_again}}\n"
        "  up_again: {do: takeoff, with: {altitude: 2 m}, on: {done: home}}"
    )
    swapped, not_swapped = (flight(far.replace("call", each)) for each in (call, "log: no"))
    assert {"beyond-battery", "no-return"} & set(codes(checked(not_swapped)))
    assert codes(checked(swapped)) == []
    pad = "world: w\nboxes: {pad: {at: [900, 9], size: [2, 2, 0.2], charges: 60 W}}\n"
    assert codes(checked(not_swapped, read_world(pad, "w"))) == []
    # No battery lasts for this one, however full it is.
    assert set(codes(checked(swapped.replace("1200", "20000")))) == {"beyond-battery"}


def test_what_depends_on_the_flight_is_unknown_until_the_next_known_place() -> None:
    text = flight(
        "go: {do: move, with: {forward: 1 m/s}, after: {5 s: back}}\n"
        "  back: {do: goto, with: {to: [0, 20, 1]}, on: {done: again, blocked: land}}\n"
        "  again: {do: goto, with: {to: [0, 0, 1]}, on: {done: land, blocked: land}}"
    )
    findings = checked(text, "yard")
    assert findings.unknown == ("go",)
    assert "from [0, 20, 1] to [0, 0, 1] leads through the box 'wall'" in str(findings.faults)


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ("[0, 12, 1]", "the leg to [0, 12, 1] leads into the box 'wall' near [0, 12, 1]"),
        ("[0, 20, -2]", "the leg to [0, 20, -2] ends 2 m below the ground"),
    ],
)
def test_where_a_leg_ends_counts_though_its_begin_is_unknown(point: str, expected: str) -> None:
    text = flight(
        "go: {do: move, with: {forward: 1 m/s}, after: {5 s: back}}\n"
        f"  back: {{do: goto, with: {{to: {point}}}, on: {{done: land, blocked: land}}}}"
    )
    assert checked(text, "yard").faults[0].message.startswith(expected)


def test_a_point_that_is_seen_is_unknown_and_nothing_is_told_of_it() -> None:
    text = to("$vehicle.position")
    findings = checked(text, "yard")
    assert codes(findings) == [] and "go" in findings.unknown


CONVERGING = """\
mission: flight
data: {{n: 0}}
states:
  takeoff: {{do: takeoff, with: {{altitude: 2 m}}, on: {{done: go}}}}
  go:
    do: goto
    with: {{to: [9, 0, 2], heading: travel}}
    on:
      done: turned
      blocked: turned
      operator.abort: {{target: turned, actions: {{set: {{n: 1}}}}}}
      battery.low: {{target: turned, actions: {{set: {{n: 2}}}}}}
  turned:
    do: {do}
    with: {{{given}}}
    on: {{battery.low: {{actions: {{set: {{n: 3}}}}}}, "*": home}}
  home: {{do: goto, with: {{to: home}}, on: {{done: land, blocked: land}}}}
  land: {{do: land, on: {{done: finish}}}}
  finish: {{type: final}}
"""
"""Ways to one moment, at which the heading is known of some only."""


@pytest.mark.parametrize(
    ("do", "given"),
    [
        ("takeoff", ""),
        ("land", ""),
        ("return_home", ""),
        ("hover", ""),
        ("goto", "to: [3, 3, 2]"),
        ("move", "forward: 1 m/s"),
        ("route", "points: [[3, 3, 2], [4, 4, 2]]"),
        ("orbit", "around: [3, 3, 2]"),
        ("follow_path", "shape: circle"),
        ("survey", "area: [[0, 0], [4, 0], [4, 4]], height: 3 m, spacing: 2 m"),
        ("search_spiral", "radius: 3 m, spacing: 2 m"),
    ],
)
def test_ways_that_meet_where_the_heading_is_unknown_are_followed(do: str, given: str) -> None:
    findings = checked(CONVERGING.format(do=do, given=given))
    assert codes(findings) == [] and findings.complete


def test_things_that_move_and_may_come_near_are_named() -> None:
    path = "{through: [[5, -9, 2], [5, 9, 2]], speed: 1}"
    ball = f"world: w\nspheres: {{ball: {{radius: 0.5, moves: {path}}}}}\n"
    findings = checked(to("[9, 0, 2]"), read_world(ball, "w.yaml"))
    assert codes(findings) == [] and findings.moving == ("ball",)
    assert checked(to("[-9, 0, 2]"), read_world(ball, "w.yaml")).moving == ()


CODE = '''
from behaviors import Behavior, PlannedLeg, Point

class Ahead(Behavior):
    """Flies ten metres ahead."""
    @classmethod
    def plan(cls, params, start):
        %s

    def step(self, flight):
        return "done"
'''


def own(tmp_path: Path, body: str) -> Any:
    (tmp_path / "ahead.py").write_text(CODE % body)
    return load_all([(Scalar("ahead.py", Where("m.yaml", 1, 1)), tmp_path)])


OWN = flight("go: {do: ahead, on: {done: home}}")


def test_a_behaviour_of_one_s_own_is_followed_by_its_plan(tmp_path: Path) -> None:
    world = read_world("world: w\nboxes: {box: {at: [5, 0], size: [1, 1, 4]}}\n", "w.yaml")
    body = "return [PlannedLeg(start.position.plus((10.0, 0.0, 0.0)), speed=1.0)]"
    findings = checked(OWN, world, own=own(tmp_path, body))
    assert told(findings)[0] == ("hits-thing", "m.yaml:6:3")
    assert "'box'" in findings.faults[0].message


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return 1 / 0", "the plan of 'ahead' failed: ZeroDivisionError"),
        ("return [(1, 2, 3)]", "not a list of PlannedLeg"),
        ("return [PlannedLeg(Point(1.0, 2.0, float('nan')))]", "has a leg that is none"),
        ("return 3", "not a list of PlannedLeg"),
        ("return [PlannedLeg(Point(1.0, 2.0, 3.0), speed='fast')]", "has a leg that is none"),
    ],
)
def test_a_plan_that_is_wrong_is_told_and_what_it_flies_unknown(
    tmp_path: Path, body: str, message: str
) -> None:
    findings = checked(OWN, own=own(tmp_path, body))
    assert codes(findings) == ["broken-plan"] and message in only(findings)
    assert findings.unknown[0] == "go"


SQUARE = "[[0, 0], [9, 0], [9, 9], [0, 9]]"


@pytest.mark.parametrize(
    ("do", "message", "place"),
    [
        ("follow_path, with: {}", "through 2 different points or more, not 0", ""),
        ("follow_path, with: {points: [[1, 2, 3], [1, 2, 3]]}", "or more, not 1", "points"),
        (
            "follow_path, with: {closed: true, points: [[1, 2, 3], [5, 2, 3], [1, 2, 3]]}",
            "a closed path leads through 3 different points or more, not 2",
            "points",
        ),
        (
            "follow_path, with: {points: [[0, 0, 3], [5, 0, 3], [0, 0, 3]]}",
            "turn back at",
            "points",
        ),
        (
            "follow_path, with: {closed: true, points: [[0, 0, 3], [5, 0, 3], [9, 0, 3]]}",
            "cannot turn back at [9, 0, 3]",
            "points",
        ),
        (
            "follow_path, with: {laps: 3, points: [[1, 2, 3], [5, 2, 3]]}",
            "3 laps of a path",
            "laps",
        ),
        ("follow_path, with: {shape: file}", "the shape file has no `file`", "shape"),
        (
            "follow_path, with: {shape: circle, points: [[1, 2, 3], [5, 2, 3]]}",
            "a circle leads through no `points`",
            "points",
        ),
        (f"survey, with: {{area: {SQUARE}}}", "nothing says how far", ""),
        (
            "survey, with: {spacing: 2 m, area: [[0, 0], [9, 9], [9, 0], [0, 9]]}",
            "the outline of this area crosses",
            "area",
        ),
        (
            "survey, with: {camera: ventral, area: [[0, 0], [9, 9], [9, 9]]}",
            "3 different corners",
            "area",
        ),
        (
            "survey, with: {spacing: 2 m, area: [[0, 0], [3, 3], [9, 9]]}",
            "crosses or touches",
            "area",
        ),
        (
            "sweep_detect, with: {detect: [people], area: [[0, 0], [3, 0], [3, 3]], "
            "holes: [[[-1, -1], [9, -1], [9, 9]]]}",
            "the holes leave nothing",
            "holes",
        ),
        (
            "sweep_detect, with: {detect: [people], area: [[0, 0], [1e-4, 0], [0, 1e-4]]}",
            "this area has no extent",
            "area",
        ),
        ("photo, with: {camera: front, name: a/b}", "'a/b' is no name of a picture", "name"),
        ("photo, with: {camera: front, heading: travel}", "it does not travel", "heading"),
    ],
)
def test_parameters_that_make_no_flight_are_an_error(do: str, message: str, place: str) -> None:
    blocked = "" if do.startswith(("photo", "sweep")) else ", blocked: land"
    ways = f"done: home, failed: land{blocked}"
    text = flight(f"go: {{do: {do}, on: {{{ways}}}}}")
    line = text.splitlines()[5]
    column = line.index(f"{place}: ") + len(place) + 3 if place else 3
    (fault,) = checked(text).faults
    assert (fault.code, fault.severity, fault.where) == (
        "unflyable",
        "error",
        Where("m.yaml", 6, column),
    )
    assert message in fault.message
    assert fault.message.startswith(f"'{do.partition(',')[0]}' cannot fly this: ")


@pytest.mark.parametrize(
    ("do", "message", "place"),
    [
        ("find_color, with: {color: rad}", "there is no colour 'rad'", "color"),
        ("find_color, with: {color: red, min_area_limit: 9, max_area_limit: 8}", "above", "limit"),
        ("find_road, with: {color: {hsv: 3}}", "hsv is the lowest and the highest", "color"),
        ("watch_traffic, with: {colors: [red, rad]}", "there is no colour 'rad'", "colors"),
        ("watch_traffic, with: {colors: []}", "name one or more", "colors"),
        ("watch_traffic, with: {min_size: 20}", "is above max_size (15)", "min_size"),
        ("detect_tags, with: {camera: ventral, ids: [50]}", "has the markers 0 to 49", "ids"),
        ("detect_tags, with: {camera: ventral, ids: ['3']}", "are whole numbers", "ids"),
        ("detect_tags, with: {camera: ventral, needed: 6}", "needed (6) is above of (5)", "needed"),
    ],
)
def test_a_companion_that_can_see_nothing_is_an_error(do: str, message: str, place: str) -> None:
    inside = "states: {stay: {do: hover, after: {5 s: land}}}"
    text = flight(f"go: {{do: {do}, on: {{failed: land}}, {inside}}}")
    (fault,) = checked(text).faults
    column = text.splitlines()[5].index(f"{place}: ") + len(place) + 3
    assert (fault.code, fault.where) == ("unflyable", Where("m.yaml", 6, column))
    assert message in fault.message


@pytest.mark.parametrize(
    "do",
    [
        "find_color, with: {color: $seen}",
        "find_road, with: {color: {hsv: [$low, [90, 255, 255]]}}",
        "watch_traffic, with: {colors: [red, $seen]}",
        "detect_tags, with: {camera: ventral, ids: $wanted}",
    ],
)
def test_what_a_companion_sees_may_be_decided_in_flight(do: str) -> None:
    data = "data: {seen: {type: any, default: 3}, low: [0, 0, 0], wanted: {type: any, default: 3}}"
    sets = "entry: {set: {seen: '${[vehicle.altitude]}', wanted: '${[vehicle.altitude]}'}}"
    inside = "states: {stay: {do: hover, after: {5 s: land}}}"
    text = flight(f"go: {{{sets}, do: {do}, on: {{failed: land}}, {inside}}}", data)
    assert checked(text).faults == ()


@pytest.mark.parametrize(
    ("do", "ends", "message"),
    [
        ("hover_over, with: {target: marker, id: 50}", "failed: land", "0 to 49, not 50"),
        ("follow_road, with: {min_width: 7 m}", "done: land, lost: land", "is above max_width (6)"),
    ],
)
def test_what_can_follow_nothing_is_an_error(do: str, ends: str, message: str) -> None:
    (fault,) = checked(flight(f"go: {{do: {do}, on: {{{ends}}}, after: {{9 s: land}}}}")).faults
    assert fault.code == "unflyable" and message in fault.message


def test_a_parameter_that_must_be_given_is_not_left_empty() -> None:
    text = flight("go: {do: track_object, with: {target: null}, on: {lost: land}}")
    with pytest.raises(UserError, match=r"m.yaml:6:41: error: a value is missing here"):
        checked(text)


def test_a_name_that_the_flight_decides_is_no_error() -> None:
    photo = "go: {do: photo, with: {camera: front, name: 'n_$n', heading: $way}, on: {done: home}}"
    assert checked(flight(photo, "data: {n: 1, way: {type: heading, default: 1 rad}}")).faults == ()


@pytest.mark.parametrize("name", MISSIONS)
def test_nothing_is_told_of_the_shipped_missions(name: str) -> None:
    prepared = prepare(missions.find(name))
    findings = check_geometry(prepared.graph, prepared.world, SIM)
    # What moves may be near: that is said, and is what some are for.
    assert replace(findings, unknown=(), moving=()) == Findings((), (), (), True)
    # Where it flies by what it sees is not known before.
    assert findings.unknown == () or name not in PLANNED


@pytest.mark.parametrize("name", FLEETS)
def test_nothing_is_told_of_the_shipped_fleets(name: str) -> None:
    fleet = prepare_fleet(missions.find(name))
    assert check_ways(fleet.assignments, dict.fromkeys(fleet.assignments, SIM)).faults == ()


REGION = (
    "      r{k}: {{initial: a, states: {{a: {{on: {{operator.land: b}}}}, "
    "b: {{after: {{{k} s: a}}}}}}}}"
)
GOTO = (
    "          g{k}: {{do: goto, with: {{to: [{k}, {y}, 3]}}, "
    "on: {{done: g{a}, blocked: g{b}, battery.low: g{c}}}}}"
)


def test_the_time_is_bounded_however_many_ways_there_are() -> None:
    regions = [REGION.format(k=k) for k in range(1, 10)]
    gotos = [
        GOTO.format(k=k, y=k * k % 17, a=(k + 1) % 60, b=(k * 7 + 3) % 60, c=(k * 5 + 1) % 60)
        for k in range(60)
    ]
    begin = "mission: many\nstates:\n  takeoff: {do: takeoff, on: {done: all}}"
    middle = ["  all:\n    type: parallel\n    states:", *regions, "      fly:\n        states:"]
    text = "\n".join([begin, *middle, *gotos, ""])
    began = process_time()
    findings = checked(text, find_world("forest:3"))
    assert process_time() - began < 4.0  # about one second on an idle machine
    assert not findings.complete


EIGHT = """go:
    do: follow_path
    with: {{shape: figure_eight, length: 4 m, width: 2 m, speed: {speed}}}
    on: {{done: home, blocked: land}}"""


def test_a_path_that_needs_more_tilt_than_the_vehicle_has_is_told() -> None:
    assert codes(checked(flight(EIGHT.format(speed="2 m/s")))) == []
    found = checked(flight(EIGHT.format(speed="3 m/s")))
    assert codes(found) == ["slower-than-asked"]
    assert "flies its path at 2.2 m/s, not at 3 m/s" in only(found)
    tilted = Terms(SIM.model, Limits(max_tilt=0.6))
    assert codes(checked(flight(EIGHT.format(speed="3 m/s")), terms=tilted)) == []
    slow = Terms(SIM.model, Limits(max_speed=1.0))
    assert codes(checked(flight(EIGHT.format(speed="2 m/s")), terms=slow)) == ["slower-than-asked"]


def test_points_above_ground_are_held_against_the_hill(tmp_path: Path) -> None:
    (tmp_path / "hill.yaml").write_text(
        "world: hill\nground: {terrain: {size: 40 m, heights: "
        "[[0, 0, 0, 0, 0], [0, 4, 4, 4, 0], [0, 4, 4, 4, 0], [0, 4, 4, 4, 0], [0, 0, 0, 0, 0]]}}\n"
        "start: {at: [-30, 0]}\n"
    )
    world = find_world(str(tmp_path / "hill.yaml"))
    assert codes(checked(to("{x: 30, y: 0, z: 3}"), world)) == ["below-ground"]
    assert codes(checked(to("{x: 30, y: 0, above_ground: -1}"), world)) == ["below-ground"]
    high = flight(
        "go: {do: goto, with: {to: {z: 7}}, on: {done: over, blocked: land}}\n"
        "  over: {do: goto, with: {to: {x: 30, y: 0, above_ground: 3}}, "
        "on: {done: finish, blocked: land}}"
    )
    assert codes(checked(high, world)) == []
