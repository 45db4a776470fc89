"""A small host without drones: behaviours that do what a script says, and a trace of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

from fsm import (
    BehaviorInfo,
    Graph,
    Instance,
    Outcome,
    Parameter,
    Vocabulary,
    compile_mission,
    read_mission_text,
)
from fsm.values.types import ANY, BOOL, HEADING, POINT, ROUTE, TEXT, ListOf, MapOf, Number, Text
from vencejo.errors import Fault, UserError
from vencejo.geometry import Point
from vencejo.units import ANGLE, LENGTH, RATIO, SPEED, TIME

PERIOD = 0.025
ORIGIN = Point(0.0, 0.0, 0.0)
END = "  end: {type: final}\n"
"""A state for the end of a mission that needs one."""


@dataclass(frozen=True)
class Vehicle:
    battery: float = 1.0
    altitude: float = 0.0
    position: Point = ORIGIN
    mode: str = "auto"


VEHICLE = {
    "battery": Number(RATIO),
    "altitude": Number(LENGTH),
    "position": POINT,
    "mode": Text(("auto", "manual")),
}


def _parameters(*parameters: Parameter) -> dict[str, Parameter]:
    return {parameter.name: parameter for parameter in parameters}


BEHAVIORS = {
    behavior.name: behavior
    for behavior in (
        BehaviorInfo(
            "go",
            parameters=_parameters(
                Parameter("to", POINT, live=True),
                Parameter("speed", Number(SPEED, min=0.1, max=10.0), default=2.0, live=True),
                Parameter("height", Number(LENGTH), default=1.0),
                Parameter("heading", HEADING, default="keep"),
                Parameter("loud", BOOL, default=False),
                Parameter("times", Number(whole=True), default=1),
                Parameter("color", Text(("red", "blue")), default="red"),
            ),
            outcomes={"done": {}, "blocked": {"by": TEXT}},
            controls=("motion",),
        ),
        BehaviorInfo(
            "rise",
            parameters=_parameters(Parameter("height", Number(LENGTH), required=True)),
            outcomes={"done": {}},
            controls=("motion",),
            requires=("takeoff",),
        ),
        BehaviorInfo(
            "fly",
            parameters=_parameters(Parameter("route", ROUTE, required=True)),
            outcomes={"done": {}},
            controls=("motion",),
        ),
        BehaviorInfo(
            "look",
            events={"tag.seen": {"id": Number(), "at": POINT}},
            publishes={
                "visible": BOOL,
                "x": Number(ANGLE),
                "tags": ListOf(MapOf({"id": Number()})),
            },
            blank=SimpleNamespace(visible=False, x=0.0, tags=[]),
        ),
        BehaviorInfo("wait", outcomes={"done": {}}),
        BehaviorInfo("blink", controls=("lights",)),
        BehaviorInfo("settle", outcomes={"done": {}}, controls=("motion",), ends_landed=True),
    )
}
VOCABULARY = Vocabulary(
    behaviors=BEHAVIORS,
    names={"vehicle": MapOf(VEHICLE)},
    events={
        "battery.low": {"level": Number(RATIO)},
        "link.lost": {"age": Number(TIME)},
        "operator.abort": {},
        "word.said": {"word": TEXT, "more": ANY},
    },
    urgent=("operator.*", "battery.*", "link.*"),
    reactions={"battery.low": "none"},
    places=frozenset({"pond"}),
)


def graph_of(text: str, vocabulary: Vocabulary = VOCABULARY) -> Graph:
    return compile_mission(read_mission_text(text, "m.yaml"), vocabulary)


def faults_of(text: str) -> list[Fault]:
    """The faults of a mission, warnings included."""
    try:
        return list(graph_of(text).warnings)
    except UserError as error:
        return list(error.faults)


def shown(fault: Fault) -> str:
    where = fault.where
    return f"{where.line}:{where.column} {fault.code}" if where else fault.code


@dataclass
class ToyActivity:
    """Ends when its script says so; remembers what it was given."""

    state: str
    parameters: Mapping[str, Any]
    resumed: Mapping[str, Any] | None
    log: list[str]
    script: dict[str, list[Any]]
    published: Any = None
    steps: int = 0
    seen: list[Mapping[str, Any]] = field(default_factory=list)

    def step(self, live: Mapping[str, Any]) -> Outcome | None:
        self.steps += 1
        self.seen.append(dict(live))
        self.log.append(f"step {self.state}")
        script = self.script.get(self.state, [])
        said = script.pop(0) if script else None
        if isinstance(said, SimpleNamespace):
            self.published = said
            return None
        if isinstance(said, Callable):  # type: ignore[arg-type]
            said = said()
        return Outcome(said) if isinstance(said, str) else said

    def progress(self) -> Mapping[str, Any] | None:
        return {"steps": self.steps}

    def saved(self) -> Mapping[str, Any]:
        return {"with": dict(self.parameters), "steps": self.steps, "published": self.published}

    def stop(self) -> None:
        self.log.append(f"stop {self.state}")


class Run:
    """A graph with a toy host; ``script`` gives per state what each step ends with or publishes."""

    def __init__(
        self,
        text: str,
        script: Mapping[str, Sequence[Any]] | None = None,
        parameters: Mapping[str, Any] | None = None,
        *,
        graph: Graph | None = None,
        model: type[Instance] = Instance,
    ) -> None:
        self.script = {state: list(steps) for state, steps in (script or {}).items()}
        self.log: list[str] = []
        self.activities: list[ToyActivity] = []
        self.vehicle = Vehicle()
        self.graph = graph or graph_of(text)
        self.instance = model(self.graph, self, parameters)
        self.now = 0.0

    def begin(
        self,
        behavior: BehaviorInfo,
        state: str,
        parameters: Mapping[str, Any],
        progress: Mapping[str, Any] | None,
    ) -> ToyActivity:
        self.log.append(f"begin {state}")
        activity = ToyActivity(state, parameters, progress, self.log, self.script, behavior.blank)
        self.activities.append(activity)
        return activity

    def send(self, event: str, fields: Mapping[str, Any], to: str) -> None:
        self.log.append(f"send {event} to {to}: {dict(fields)}")

    def resume(self, behavior: BehaviorInfo, state: str, saved: Mapping[str, Any]) -> ToyActivity:
        self.log.append(f"resume {state}")
        resumed = {"steps": saved["steps"]}
        activity = ToyActivity(state, saved["with"], resumed, self.log, self.script)
        activity.steps, activity.published = saved["steps"], saved["published"]
        self.activities.append(activity)
        return activity

    def call(self, name: str, arguments: Mapping[str, Any]) -> None:
        raise LookupError(name)

    def run(self, periods: int = 1, **vehicle: Any) -> list[str]:
        """Some periods of 25 ms; the active leaf states afterwards."""
        self.vehicle = replace(self.vehicle, **vehicle)
        for _ in range(periods):
            self.instance.period(self.now, (self.vehicle,))
            self.now += PERIOD
        return self.instance.paths()

    def post(self, name: str, **fields: Any) -> Run:
        self.instance.post(name, fields)
        return self

    def take(self) -> list[str]:
        """The records since the last call, one short line each."""
        records, self.instance.records = self.instance.records, []
        return [_line(what, fields) for what, fields in records]

    def logged(self) -> list[str]:
        """The texts of the `log` actions since the last call."""
        return [line.removeprefix("log ") for line in self.take() if line.startswith("log ")]

    def value(self, name: str) -> Any:
        """The value of a data variable, anywhere in the graph."""
        slots = [data.slot for node in self.graph.nodes for data in node.data if data.name == name]
        return self.instance.slots[slots[0]]


def _line(what: str, fields: Mapping[str, Any]) -> str:
    match what:
        case "log":
            return f"log {fields['text']}"
        case "event":
            owner = f"{fields['state'] or '/'}:" if "state" in fields else ""
            return f"event {owner}{fields['name']}{'' if fields['taken'] else ' unheard'}"
        case "transition":
            return f"{fields['from'] or '/'} -> {', '.join(fields['to'])} by {fields['by']}"
        case "enter" | "exit" | "start" | "stop":
            return f"{what} {fields['state'] or '/'}"
        case "set" | "append":
            return f"{what} {fields['name']} {fields['value']}"
        case _:
            return f"{what} {fields.get('message', '')}"
