# ruff: noqa: E501  (a mission stands in one line with what becomes of it)
"""Live Robot Programming's example programs, as graphs: every construct of it can be said."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from fsm import BehaviorInfo, Graph, Parameter, Vocabulary, compile_mission, read_mission
from fsm.host import Function
from fsm.values.types import BOOL, TEXT, MapOf, Number
from tests.fsm.toy import Run
from vencejo.units import ANGLE, FREQUENCY, LENGTH, RATIO, SPEED, TURN_RATE

FOLDER = Path(__file__).parent / "lrp"
NAMES = sorted(path.stem for path in FOLDER.glob("*.yaml"))


def _parameters(**types: Any) -> dict[str, Parameter]:
    return {name: Parameter(name, type_, live=True) for name, type_ in types.items()}


NUMBER, METRES, SPEEDS = Number(), Number(LENGTH), Number(SPEED)
GROUND = {"light": NUMBER, "bumper": BOOL}
TAG = {"visible": BOOL, "count": NUMBER, "x": NUMBER, "y": NUMBER, "distance": METRES,
       "oriented": BOOL}  # fmt: skip
MOTION = {"forward": SPEEDS, "left": SPEEDS, "up": SPEEDS, "yaw_rate": Number(TURN_RATE)}
HOVER = {"target": TEXT}
BEHAVIORS = (
    BehaviorInfo("ground_sensors", publishes=GROUND, blank=SimpleNamespace(light=128, bumper=False)),
    BehaviorInfo("detect_tags", parameters=_parameters(camera=TEXT), publishes=TAG,
             blank=SimpleNamespace(visible=False, count=0, x=0.0, y=0.0, distance=0.0, oriented=False)),
    BehaviorInfo("move", parameters=_parameters(**MOTION), controls=("motion",)),
    BehaviorInfo("wheels", parameters=_parameters(left=NUMBER, right=NUMBER), controls=("motion",)),
    BehaviorInfo("hover_over", parameters=_parameters(**HOVER), controls=("motion",)),
    BehaviorInfo("takeoff", parameters=_parameters(altitude=METRES), outcomes={"done": {}}, controls=("motion",)),
    BehaviorInfo("land", outcomes={"done": {}}, controls=("motion",), ends_landed=True),
)  # fmt: skip
LEDS = Function("leds", parameters={"color": Parameter("color", TEXT, required=True),
                                    "rate": Parameter("rate", Number(FREQUENCY))})  # fmt: skip
VOCABULARY = Vocabulary(
    behaviors={behavior.name: behavior for behavior in BEHAVIORS},
    names={"vehicle": MapOf({"altitude": METRES, "yaw": Number(ANGLE), "battery": Number(RATIO)})},
    events={"battery.low": {}, "link.lost": {}},
    urgent=("battery.*", "link.*"),
    functions={"leds": LEDS},
)


def graph_of(name: str) -> Graph:
    path = FOLDER / f"{name}.yaml"
    return compile_mission(read_mission(path, path.name), VOCABULARY)


class Robot(Run):
    """A run whose host values are set by name, and whose sensors publish what they are told."""

    def __init__(self, name: str, script: Mapping[str, Sequence[Any]] | None = None) -> None:
        super().__init__("", script, graph=graph_of(name))
        self.values = {"altitude": 0.0, "yaw": 0.0, "battery": 1.0}
        self.sensor = ""

    def call(self, name: str, arguments: Mapping[str, Any]) -> None:
        self.log.append(f"{name} {arguments}")

    def sees(self, **values: Any) -> Robot:
        """From its next step on, the sensor publishes this."""
        sensor = self.activities[[a.published is not None for a in self.activities].index(True)]
        known = {**vars(sensor.published), **values}
        self.script.setdefault(sensor.state, []).append(SimpleNamespace(**known))
        return self

    def run(self, periods: int = 1, **vehicle: Any) -> list[str]:
        self.values.update(vehicle)
        for _ in range(periods):
            self.instance.period(self.now, (SimpleNamespace(**self.values),))
            self.now += 0.025
        return self.instance.paths()

    def commanded(self) -> dict[str, float]:
        """The parameters that the last behaviour was started with."""
        return {n: round(v, 6) for n, v in self.activities[-1].parameters.items() if v is not None}

    def path(self, periods: int) -> list[str]:
        """The states of so many periods, each once while it lasts."""
        found: list[str] = []
        for _ in range(periods):
            (state,) = self.run()
            if found[-1:] != [state]:
                found.append(state)
        return found


@pytest.mark.parametrize("name", NAMES)
def test_all_are_without_fault(name: str) -> None:
    endless = name in ("leftright", "linecross", "tag_leds")
    assert [w.code for w in graph_of(name).warnings] == ["never-ends"] * endless


def test_a_search_widens_by_a_variable_of_its_own_state() -> None:
    """A timeout that is a variable, doubled by an exit action, and new at each entry."""
    robot = Robot("follower")
    robot.run()
    states = [robot.run()[0].removeprefix("looking.") for _ in range(44)]
    assert states[:16] == ["lookleft"] * 3 + ["returnleft"] * 4 + ["lookright"] * 4 + [
        "returnright"
    ] * 4 + ["lookleft"]
    assert (
        states[15:44]
        == ["lookleft"] * 8 + ["returnleft"] * 8 + ["lookright"] * 8 + ["returnright"] * 5
    )
    assert robot.value("span") == 0.2
    robot.sees(light=20)
    assert robot.run(2) == ["moving"]
    robot.sees(light=200)
    assert robot.run(2) == ["looking.lookleft"]
    assert robot.value("span") == 0.1


def test_a_wildcard_pre_empts_and_its_second_time_ends_it() -> None:
    robot = Robot("follower")
    robot.run()
    robot.sees(bumper=True)
    assert robot.run(2) == ["bumpback"]
    assert robot.commanded() == {"forward": -0.2}
    assert robot.run(39) == ["bumpback"]
    assert robot.run(2) == ["bumpturn"]
    robot.sees(bumper=False)
    robot.run(2)
    robot.sees(bumper=True)
    robot.run(2)
    assert robot.instance.outcome == "done"


def test_a_machine_begins_at_a_chosen_state() -> None:
    robot = Robot("leftright")
    assert robot.run(2) == ["turnright"]
    assert robot.commanded() == {"yaw_rate": -0.2}
    assert robot.run(yaw=-0.3) == ["turnleft"]
    assert robot.run(2, yaw=0.1) == ["turnleft"]
    assert robot.run(yaw=0.3) == ["turnright"]


def test_one_event_in_two_places() -> None:
    robot = Robot("linecross")
    seen = robot.run()
    for light in (20, 128, 250, 128, 10, 255):
        robot.sees(light=light)
        seen += robot.run(2)
    assert seen == ["left", "crossfl", "crossfl", "right", "right", "crossfr", "left"]


def test_a_timeout_that_is_an_expression_inside_one_that_ends_it() -> None:
    robot = Robot("square", {"landing": [None, "done"]})
    assert robot.run(201) == ["flying.flyforward"]
    assert robot.commanded() == {"forward": 0.51}
    assert [state.removeprefix("flying.") for state in robot.path(319)] == [
        "flyforward", "stopforward", "flyright", "stopright", "flybackwards", "stopbackwards",
        "flyleft", "stopleft", "flyforward", "stopforward",
    ]  # fmt: skip
    # Both are due: the inner one goes first, and the other is not lost.
    assert robot.run() == ["flying.flyright"]
    assert robot.run() == ["landing"]
    robot.run(2)
    assert robot.instance.outcome == "done"


def test_entry_actions_call_the_robot() -> None:
    robot = Robot("tag_leds")
    robot.run()
    robot.sees(count=1).run(2)
    robot.sees(count=0).run(2)
    leds = [line for line in robot.log if line.startswith("leds")]
    assert leds == [
        f"leds {{'color': '{color}', 'rate': 1.0}}" for color in ("red", "green", "red")
    ]


def test_values_followed_live_until_centred() -> None:
    robot = Robot("shell_follower", {"takeoff": ["done"]})
    robot.run(2)
    robot.sees(visible=True, x=0.5, y=0.0, distance=1.2)
    assert robot.run(2) == ["work.following.positioned"]
    assert robot.run() == ["work.following.moving"]
    robot.sees(x=0.4).run()
    moving = robot.activities[-1]
    assert [round(seen["left"], 3) for seen in moving.seen] == [-0.1, -0.08]
    assert robot.sees(x=0.1).run(2) == ["work.following.positioned"]
    assert robot.sees(visible=False).run(2) == ["work.waiting"]


@pytest.mark.parametrize(
    ("name", "centred", "go", "brake"),
    [
        ("shell_brake", "work.following.centered", "work.following.x.go", "work.following.x.brake"),
        ("shell_brake_include", "work.centered", "work.x.go", "work.x.brake"),
    ],
)
def test_a_counter_brake(name: str, centred: str, go: str, brake: str) -> None:
    """The speed is fixed on entry; half as much again the other way for 60 ms stops it."""
    robot = Robot(name, {"takeoff": ["done"]})
    robot.run(2)
    robot.sees(visible=True, x=0.5, y=0.0, distance=2.0)
    robot.run(2)
    while robot.instance.paths() != [go]:
        assert robot.run() != [brake]
    assert robot.commanded()["left"] == -0.15
    robot.sees(x=0.2)
    assert robot.run(2) == [brake]
    assert robot.commanded()["left"] == 0.225
    assert robot.path(4) == [brake, centred]


def test_an_outer_transition_pre_empts_an_inner_timeout() -> None:
    robot = Robot("tag_navigator", {"takingoff": ["done"]})
    robot.run(2)
    assert robot.run(2, altitude=0.7) == ["go.looking.hovering"]
    # The timeout of five seconds and the tag come together: the outer one wins.
    robot.run(197)
    assert robot.sees(visible=True).run(1) == ["go.looking.hovering"]
    assert robot.run() == ["go.looking.orienting"]
    assert robot.sees(oriented=True).run(2) == ["go.stabilizing"]
    robot.instance.set_parameter("tmove", 0.1)
    assert robot.run(202) == ["go.moving"]
    assert robot.run(2) == ["go.looking.hovering"]


def test_exit_actions_run_whoever_takes_over() -> None:
    robot = Robot("tag_navigator", {"takingoff": ["done"]})
    robot.run(2)
    robot.run(2, altitude=0.75)
    assert robot.run(altitude=0.6) == ["go.looking.elevating_normal"]
    robot.sees(visible=True, oriented=True)
    assert robot.run(2) == ["go.stabilizing"]
    leds = [line for line in robot.log if line.startswith("leds")]
    assert leds == ["leds {'color': 'orange'}", "leds {'color': 'standard'}"]
