"""Plans: where behaviours say that they will fly, and that they fly there."""

from __future__ import annotations

import copy
import operator
from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import pytest

from behaviors import UNKNOWN, Face, Legs, PlanStart, Point, Registry, Waypoint, load_all
from behaviors.plan import NotKnown
from tests.behaviors.flying import Solo
from vencejo.errors import UserError, Where
from vencejo.nodes import Scalar

UP = PlanStart(Point(0.0, 0.0, 3.0), 0.0, True, 0.0, 5.0)
"""In the air above home, facing east."""


def planned(name: str, start: PlanStart = UP, **given: Any) -> Legs | None:
    behavior = Registry()[name].implementation
    legs: Legs | None = behavior.plan(behavior.Params(**given), start)
    return legs


def corners(name: str, start: PlanStart = UP, **given: Any) -> list[Point]:
    return [leg.to for leg in planned(name, start, **given) or ()]


def test_a_take_off_rises_above_where_it_stands_and_in_the_air_it_does_nothing() -> None:
    ground = PlanStart(Point(1.0, 2.0, 0.8), pi / 2, False, 0.8, 5.0)
    assert corners("takeoff", ground, altitude=2.0) == [Point(1.0, 2.0, 2.8)]
    assert planned("takeoff", altitude=2.0) == []


def test_a_landing_goes_straight_down_to_what_lies_there() -> None:
    assert corners("land", replace(UP, ground=0.8)) == [Point(0.0, 0.0, 0.8)]


def test_a_return_climbs_flies_level_and_comes_down_at_home() -> None:
    away = replace(UP, position=Point(8.0, 6.0, 3.0))
    assert corners("return_home", away) == [Point(8, 6, 5), Point(0, 0, 5), Point(0, 0, 0)]
    high = replace(UP, position=Point(8.0, 6.0, 9.0))
    assert corners("return_home", high) == [Point(8, 6, 9), Point(0, 0, 9), Point(0, 0, 0)]
    with pytest.raises(NotKnown):
        planned("return_home", replace(UP, return_height=UNKNOWN))


def test_a_goto_is_one_leg_with_its_speed_and_the_heading_at_its_end() -> None:
    (leg,) = planned("goto", to=Point(0.0, 4.0, 3.0), speed=1.5, heading="travel") or ()
    assert (leg.to, leg.speed, leg.yaw) == (Point(0, 4, 3), 1.5, pytest.approx(pi / 2))
    (leg,) = planned("goto", to=Point(0.0, 4.0, 3.0)) or ()
    assert (leg.speed, leg.yaw) == (2.0, 0.0)  # the heading is kept
    (leg,) = planned("goto", to=Point(0.0, 4.0, 3.0), heading=Face(Point(5.0, 4.0, 0.0))) or ()
    assert leg.yaw == 0.0


def test_a_speed_or_heading_that_is_not_known_leaves_the_place_known() -> None:
    (leg,) = planned("goto", to=Point(4.0, 0.0, 3.0), speed=UNKNOWN, heading=UNKNOWN) or ()
    assert (leg.to, leg.speed, leg.yaw) == (Point(4, 0, 3), None, None)
    lost = replace(UP, position=UNKNOWN, yaw=UNKNOWN)
    for heading in ("keep", "travel"):
        (leg,) = planned("goto", lost, to=Point(4.0, 0.0, 3.0), heading=heading) or ()
        assert (leg.to, leg.yaw) == (Point(4, 0, 3), None)


def test_a_route_has_a_leg_for_each_point_with_its_own_settings() -> None:
    first, second = Point(4.0, 0.0, 3.0), Point(4.0, 4.0, 3.0)
    points = [Waypoint(first), Waypoint(second, heading=pi, speed=0.5, dwell=2.0)]
    one, two = planned("route", points=points, speed=1.0) or ()
    assert (one.to, one.speed, one.dwell, one.yaw) == (first, 1.0, 0.0, 0.0)
    assert (two.to, two.speed, two.dwell, two.yaw) == (second, 0.5, 2.0, pi)


def test_a_hover_stays_or_flies_to_its_point() -> None:
    assert corners("hover") == [UP.position]
    assert corners("hover", at=Point(2.0, 0.0, 3.0)) == [Point(2, 0, 3)]


def test_where_a_move_leads_is_not_known_and_the_ground_s_behaviours_stay() -> None:
    assert planned("move", forward=1.0) is None
    assert planned("reset") == [] and planned("trim") == []


@pytest.mark.parametrize(
    ("name", "given", "grounded"),
    [
        ("takeoff", {"altitude": 2.0}, True),
        ("land", {}, False),
        ("goto", {"to": Point(3.0, 1.0, 2.0)}, False),
        ("route", {"points": [Point(2.0, 0.0, 3.0), Point(2.0, 2.0, 3.0)]}, False),
        ("return_home", {}, False),
    ],
)
def test_a_behaviour_ends_where_its_plan_does(
    name: str, given: dict[str, Any], grounded: bool
) -> None:
    solo = Solo(name, given, grounded=grounded)
    seen = solo.vehicle.observe()
    start = PlanStart(seen.position, seen.yaw, seen.flying, 0.0, 5.0)
    resolved = {**given, "points": [Waypoint(point) for point in given.get("points", ())]}
    legs = planned(name, start, **resolved) or ()
    assert solo.run(60) is not None and solo.word == "done"
    assert solo.vehicle.position == pytest.approx(legs[-1].to, abs=0.5)


@pytest.mark.parametrize(
    "use",
    [
        bool, float, int, len, iter, operator.neg, abs,
        lambda u: u + 1, lambda u: 1 - u, lambda u: u * 2, lambda u: 2 / u, lambda u: u**2,
        lambda u: u == 1, lambda u: u < 1, lambda u: u[0], lambda u: u.x, lambda u: u(),
        lambda u: u in [1], lambda u: max(u, 1), lambda u: Point(1, 2, 3).plus((u, 0, 0)),
    ],
)  # fmt: skip
def test_nothing_can_be_made_of_what_is_not_known(use: Callable[[Any], Any]) -> None:
    with pytest.raises(NotKnown):
        use(UNKNOWN)


def test_a_copy_of_the_unknown_is_the_unknown() -> None:
    assert copy.deepcopy([UNKNOWN])[0] is UNKNOWN and repr(UNKNOWN) == "unknown"


BODY = "    def step(self, flight): return 'done'\n"


@pytest.mark.parametrize(
    ("plan", "told"),
    [
        ("    def plan(self, params, start): ...\n", "is no class method"),
        ("    @classmethod\n    def plan(cls, params): ...\n", "does not take the argument"),
        ("    plan = 3\n", "is no method"),
    ],
)
def test_a_plan_that_cannot_be_asked_for_is_told_with_its_line(
    tmp_path: Path, plan: str, told: str
) -> None:
    text = f"from behaviors import Behavior\nclass Mine(Behavior):\n{plan}{BODY}"
    (tmp_path / "mine.py").write_text(text)
    with pytest.raises(UserError) as refused:
        load_all([(Scalar("mine.py", Where("m.yaml", 1, 1)), tmp_path)])
    (fault,) = refused.value.faults
    assert fault.code == "bad-behaviour" and told in fault.message
    assert fault.hint is not None and "@classmethod" in fault.hint
