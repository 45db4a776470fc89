"""`show --plan`: where a mission may fly, drawn over its world before the flight."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import pytest

from cli.plot import plan
from cli.plot.axes import Axes, axes_from_above
from cli.plot.canvas import Canvas
from cli.plot.flight import COLORS
from tests.cli.run_cli import Result, run_cli

Write = Callable[[str, str], str]

MISSION = """\
mission: tour
world: yard.yaml
parameters: {height: {default: 3 m, min: 1 m, max: 9 m}}
uses: [own.py]
states:
  rise: {do: takeoff, with: {altitude: $height}, on: {done: out}}
  out: {do: goto, with: {to: [6, 0, 3], speed: 1 m/s}, on: {done: mow, blocked: back}}
  mow:
    do: survey
    with: {area: [[6, 0], [12, 0], [12, 6], [6, 6]], height: 5 m, spacing: 2 m, speed: 2 m/s}
    on: {done: look, blocked: back, battery.low: back}
  look: {do: wander, with: {about: [3, 8, 0], ways: [[1, 1, 2], [2, 1, 2]]}, on: {done: back}}
  back: {do: goto, with: {to: home}, on: {done: down, blocked: down}}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""
OWN = """\
from behaviors import Behavior, BehaviorParams, Point, Route, param

class Wander(Behavior):
    '''Fly about, nobody knows where.'''

    class Params(BehaviorParams):
        about: Point = param(help="where")
        ways: Route = param(help="by which ways")

    outcomes = {"done": None}
    controls = ("motion",)
    needs_flight = True

    def step(self, flight):
        return "done"
"""
WORLD = """\
world: yard
fence: {through: [[-4, -4], [16, -4], [16, 16], [-4, 16]]}
boxes:
  crate: {at: [9, 9], size: [2, 2, 1]}
  in_the_area: {at: [8, 2], size: [1, 1, 1]}
"""
FLEET = """\
fleet: pair
world: yard.yaml
vehicles:
  ada: {mission: tour.yaml, start: {at: [0, 0]}}
  bo: {mission: hop.yaml, start: {at: [-2, 3]}}
"""


class Drawn:
    """A picture of a plan, and what was written on it."""

    def __init__(self) -> None:
        self.texts: list[tuple[tuple[float, float], str]] = []
        self.axes: Axes | None = None
        self.result = Result(0, "", "")

    def show(self, *arguments: str) -> Drawn:
        self.result = run_cli("show", *arguments, "--plan", "plan.png")
        assert (self.result.code, self.result.err) == (0, ""), self.result.err
        assert self.result.out == "plan.png\n"
        self.image: Any = cv2.imread("plan.png")
        return self

    @property
    def told(self) -> list[str]:
        """The texts beside the map."""
        return [text for (x, _), text in self.texts if x >= 890]

    @property
    def names(self) -> list[str]:
        """The texts on the map."""
        return [text for (x, y), text in self.texts if 58 < x < 858 and 62 < y < 862]

    def colors_at(self, east: float, north: float) -> set[tuple[int, ...]]:
        """The colours, red first, in and around the pixel of a place."""
        assert self.axes is not None
        x, y = map(round, self.axes.place(east, north))
        near = self.image[y - 2 : y + 3, x - 2 : x + 3, ::-1].reshape(-1, 3)
        return {tuple(color) for color in near.tolist()}


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Iterator[Drawn]:
    found = Drawn()

    def axes(*given: Any) -> Axes:
        found.axes = axes_from_above(*given)
        return found.axes

    write = Canvas.text

    def text(self: Canvas, place: tuple[float, float], words: str, *more: Any) -> None:
        found.texts.append((place, words))
        write(self, place, words, *more)

    monkeypatch.setattr(plan, "axes_from_above", axes)
    monkeypatch.setattr(Canvas, "text", text)
    return found


@pytest.fixture
def tour(write: Write) -> str:
    write("yard.yaml", WORLD)
    write("own.py", OWN)
    return write("tour.yaml", MISSION)


RISE, OUT, MOW, LOOK, BACK = COLORS[:5]


def test_every_leg_area_route_and_point_is_drawn(tour: str, drawn: Drawn) -> None:
    drawn.show(tour)
    assert OUT in drawn.colors_at(2.0, 0.0)
    # The area with its lanes, and the edge of what was not mown.
    assert MOW in drawn.colors_at(9.0, 6.0) and MOW in drawn.colors_at(12.0, 3.0)
    pale = tuple(round(part + (255 - part) * 0.85) for part in MOW)
    assert pale in drawn.colors_at(6.5, 0.4)
    assert LOOK in drawn.colors_at(3.0, 8.0)
    assert LOOK in drawn.colors_at(1.0, 1.0) and LOOK in drawn.colors_at(2.0, 1.0)
    crate, fence = (226, 226, 222), (214, 120, 120)
    assert crate in drawn.colors_at(9.0, 9.0) and crate in drawn.colors_at(8.0, 2.0)
    assert drawn.axes is not None and fence not in drawn.colors_at(8.0, 12.0)


def test_states_heights_lengths_and_what_is_unknown_are_told(tour: str, drawn: Drawn) -> None:
    told = drawn.show(tour).told
    for name, words in {
        "rise  takeoff": "from 0 to 3 m, 3 m long",
        "out  goto": "at 3 m, 6 m long",
        "look  wander": "route of 2 points, about",
    }.items():
        assert told[told.index(name) + 1] == words
    mow = told[told.index("mow  survey") + 1]
    assert mow.startswith("between 3 and 5 m") or mow.startswith("from 3 to 5 m")
    assert mow.endswith("area of 4 corners")
    assert told[told.index("known in flight only:") + 1] == "look (wander)"
    assert "begins where something before it may be interrupted" in told
    assert {"rise", "out", "mow", "back", "look about"} <= {*drawn.names}
    assert any(text.endswith(" m") for text in drawn.names), "the bar of the scale"


def test_a_parameter_changes_the_plan(tour: str, drawn: Drawn) -> None:
    told = drawn.show(tour, "-p", "height=4.5 m").told
    assert told[told.index("rise  takeoff") + 1] == "from 0 to 4.5 m, 4.5 m long"


HOLED = """\
mission: holed
states:
  up: {do: takeoff, with: {altitude: 3 m}, on: {done: sweep}}
  sweep:
    do: sweep
    with: {area: OUTLINE, holes: [[[7, 7], [13, 7], [13, 13], [7, 13]]], step: 4 m}
    on: {done: down}
  down: {do: land, on: {done: over}}
  over: {type: final}
"""


def test_a_hole_is_left_out_of_its_area(write: Write, drawn: Drawn) -> None:
    text = HOLED.replace("OUTLINE", "[[2, 2], [18, 2], [18, 18], [2, 18]]")
    drawn.show(write("holed.yaml", text))
    sweep = COLORS[1]
    pale = tuple(round(part + (255 - part) * 0.85) for part in sweep)
    assert pale in drawn.colors_at(2.3, 2.3) and pale in drawn.colors_at(17.7, 17.7)
    assert drawn.colors_at(10.2, 10.3) == {(255, 255, 255)}
    assert sweep in drawn.colors_at(7.0, 10.3), "the edge of the hole"


def test_a_fleet_shows_each_vehicle_in_its_color(
    tour: str, hop: str, write: Write, drawn: Drawn
) -> None:
    drawn.show(write("pair.yaml", FLEET))
    assert "ada: out  goto" in drawn.told and "bo: takeoff" in drawn.told
    assert COLORS[0] in drawn.colors_at(2.0, 0.0)
    assert (drawn.image[:, :, ::-1] == COLORS[1]).all(2).any(), "the ring of its take-off"
    assert "known in flight only:" in drawn.told and "ada: look (wander)" in drawn.told
    drawn.texts.clear()
    drawn.show("pair.yaml", "--vehicle", "bo")
    assert "bo: takeoff" in drawn.told and "ada: out  goto" not in drawn.told


def test_a_mission_that_flies_nowhere_has_a_picture_too(write: Write, drawn: Drawn) -> None:
    stay = "mission: stay\nstates:\n  wait: {after: {1 s: over}}\n  over: {type: final}\n"
    assert drawn.show(write("stay.yaml", stay)).told == ["heights are above home"]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (["--plan", "plan.jpg"], "'plan.jpg' does not end in .png"),
        (["--plan", "plan.png", "-o", "x"], "leave out --format and -o"),
        (["--plan", "plan.png", "--format", "svg"], "leave out --format and -o"),
        (["--plan", "plan.png", "--vehicle", "ada"], "--vehicle names one of a fleet"),
        (["-p", "height=3m"], "-p is for where a mission flies: --plan FILE.png"),
        (["--plan", "plan.png", "-p", "hight=3m"], "height"),
        (["--plan", "nowhere/plan.png"], "nowhere/plan.png: error: this file cannot be written"),
    ],
)
def test_what_cannot_be_drawn_is_explained(given: list[str], told: str, tour: str) -> None:
    result = run_cli("show", tour, *given)
    assert result.code in (2, 4) and told in result.err
    assert not Path("plan.png").exists()


def test_a_plan_that_makes_no_flight_is_refused(tour: str, write: Write) -> None:
    write("tour.yaml", MISSION.replace("[12, 6], [6, 6]]", "[6, 6], [12, 6]]"))
    result = run_cli("show", tour, "--plan", "plan.png")
    assert result.code == 2 and "[unflyable]" in result.err
