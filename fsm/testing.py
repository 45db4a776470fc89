"""Tests of graphs: a trial steps one without its host, with behaviours that end as scripted.

>>> trial = Trial(graph, {"goto": ends("blocked", after=2.0)})
>>> trial.until("survey").send("battery.low").assert_path("takeoff", "survey", "land")
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, Self

from fsm.chart.graph import Graph
from fsm.engine.instance import Instance, Record
from fsm.host import PERIOD, BehaviorInfo, Outcome
from fsm.values.types import Bool, ListOf, MapOf, Number, PointType, Text, Type
from vencejo.errors import nearest
from vencejo.geometry import Point


@dataclass(frozen=True)
class Ending:
    """The end of a scripted behaviour."""

    outcome: str
    after: float
    """Seconds since its state was entered."""
    fields: Mapping[str, Any] = field(default_factory=dict)


def ends(outcome: str = "done", after: float = 0.0, **fields: Any) -> Ending:
    """The end of a behaviour: an outcome after so many seconds, with the fields of its event."""
    return Ending(outcome, after, fields)


class Scripted:
    """A running behaviour that does nothing but end as scripted."""

    def __init__(self, behavior: BehaviorInfo, ending: Ending | None, steps: int = 0) -> None:
        self.published: Any = behavior.blank
        self.ending = ending
        self.steps = steps

    def step(self, live: Mapping[str, Any]) -> Outcome | None:
        self.steps += 1
        ending = self.ending
        if ending is None or self.steps * PERIOD < ending.after - 1e-9:
            return None
        return Outcome(ending.outcome, ending.fields)

    def progress(self) -> Mapping[str, Any] | None:
        return {"steps": self.steps}

    def saved(self) -> Mapping[str, Any]:
        return {"steps": self.steps}

    def stop(self) -> None:
        pass


class _TrialHost:
    """The host of a graph in a trial: scripted behaviours, and lists of calls and sent events."""

    def __init__(self, behaviors: Mapping[str, Ending]) -> None:
        self.behaviors = behaviors
        self.calls: list[tuple[str, Mapping[str, Any]]] = []
        self.sent: list[tuple[str, str, Mapping[str, Any]]] = []

    def begin(
        self,
        behavior: BehaviorInfo,
        state: str,
        parameters: Mapping[str, Any],
        progress: Mapping[str, Any] | None,
    ) -> Scripted:
        """See :class:`fsm.host.Host`."""
        ending = self.behaviors.get(state) or self.behaviors.get(behavior.name)
        return Scripted(behavior, ending, (progress or {}).get("steps", 0))

    def resume(self, behavior: BehaviorInfo, state: str, saved: Mapping[str, Any]) -> Scripted:
        """See :class:`fsm.host.Host`."""
        return self.begin(behavior, state, {}, saved)

    def call(self, name: str, arguments: Mapping[str, Any]) -> None:
        """See :class:`fsm.host.Host`."""
        self.calls.append((name, arguments))

    def send(self, event: str, fields: Mapping[str, Any], to: str) -> None:
        """See :class:`fsm.host.Host`."""
        self.sent.append((to, event, fields))


class Trial:
    """A running graph in a test. Its behaviours end only as ``behaviors`` says.

    ``behaviors`` gives endings by the path of a state or the name of a behaviour; a state's own
    goes first. Host values begin as 0, false, empty or the origin: see :meth:`set`.
    """

    def __init__(
        self,
        graph: Graph,
        behaviors: Mapping[str, Ending] | None = None,
        parameters: Mapping[str, Any] | None = None,
    ) -> None:
        self.graph = graph
        self.behaviors = dict(behaviors or {})
        self.path: list[str] = []
        """The leaf states in the order in which they were entered."""
        self.records: list[Record] = []
        """All records of the instance."""
        host = _TrialHost(self.behaviors)
        self.calls = host.calls
        """Registered actions that were called, with their arguments."""
        self.sent = host.sent
        """Events sent to other vehicles: the vehicle, the event, its fields."""
        self.time = 0.0
        """The time of the last period, seconds."""
        self._periods = 0
        self._values = {name: _blank(type_) for name, type_ in graph.vocabulary.names.items()}
        self._refuse_unknown(parameters or {})
        self.instance = Instance(graph, host, parameters)

    def _refuse_unknown(self, parameters: Mapping[str, Any]) -> None:
        for name in parameters.keys() - self.graph.parameters.keys():
            hint = nearest(name, self.graph.parameters)
            raise ValueError(f"this graph has no parameter '{name}': {hint}")
        invoked = {
            node.path: node.invocation.behavior for node in self.graph.nodes if node.invocation
        }
        known = {**{behavior.name: behavior for behavior in invoked.values()}, **invoked}
        for name, ending in self.behaviors.items():
            if name not in known:
                hint = nearest(name, known)
                raise ValueError(f"no state and no behaviour of this graph is '{name}': {hint}")
            words = {*known[name].outcomes, "failed"}
            if ending.outcome not in words:
                hint = nearest(ending.outcome, words)
                raise ValueError(f"'{name}' has no outcome '{ending.outcome}': {hint}")

    # -- what a test does -------------------------------------------------------------------

    def advance(self, seconds: float = PERIOD) -> Self:
        """Let time pass, in whole periods: at least one."""
        for _ in range(max(1, round(seconds / PERIOD))):
            self._period()
        return self

    def until(self, state: str, within: float = 60.0) -> Self:
        """Let time pass until a state is active. Fails when it is not ``within`` seconds."""
        if self._passes(within, lambda: self.is_active(state)):
            return self
        raise AssertionError(f"'{state}' was not reached within {within:g} s\n{self._story()}")

    def end(self, within: float = 600.0) -> str:
        """Let time pass until the mission ends; its outcome."""
        if self._passes(within, lambda: self.outcome is not None):
            return str(self.outcome)
        raise AssertionError(f"the mission did not end within {within:g} s\n{self._story()}")

    def send(self, event: str, **fields: Any) -> Self:
        """Post an event from outside; it is heard at once, in a period of its own."""
        self.instance.post(event, fields)
        return self.advance()

    def set(self, **values: Any) -> Self:
        """Change host values: ``set(vehicle={"battery": 0.2})`` leaves the other fields alone."""
        for name, value in values.items():
            if name not in self._values:
                raise ValueError(f"there is no '{name}' here: {nearest(name, self._values)}")
            old = self._values[name]
            if isinstance(value, Mapping) and isinstance(old, SimpleNamespace):
                for field in value.keys() - vars(old).keys():
                    hint = nearest(field, vars(old))
                    raise ValueError(f"there is no '{name}.{field}' here: {hint}")
                value = SimpleNamespace(**{**vars(old), **value})
            self._values[name] = value
        return self

    def assert_path(self, *states: str) -> Self:
        """Fail unless exactly these leaf states were entered, in this order."""
        assert self.path == list(states), f"it took {' → '.join(self.path)}"
        return self

    # -- what a test looks at ---------------------------------------------------------------

    @property
    def active(self) -> list[str]:
        """The active leaf states."""
        return self.instance.paths()

    @property
    def outcome(self) -> str | None:
        """The outcome of the mission; None while it runs."""
        return self.instance.outcome

    @property
    def logged(self) -> list[str]:
        """The texts of its ``log`` actions."""
        return [fields["text"] for kind, fields in self.records if kind == "log"]

    def is_active(self, state: str) -> bool:
        """Whether a state is active. Raises ValueError when there is none of that path."""
        if state not in self.graph.by_path:
            raise ValueError(f"there is no state '{state}': {nearest(state, self.graph.by_path)}")
        return self.instance.is_active(state)

    def value(self, name: str) -> Any:
        """A variable of the mission, or the first of that name further inside."""
        slots = (data.slot for node in self.graph.nodes for data in node.data if data.name == name)
        slot = next(slots, None)
        if slot is None:
            raise ValueError(f"there is no variable '{name}'")
        return self.instance.slots[slot]

    def _passes(self, within: float, reached: Callable[[], bool]) -> bool:
        """Let time pass until it is reached; whether it was, by periods that begin ``within``."""
        last = self.time + within + PERIOD / 2
        while not reached() and self._periods * PERIOD < last:
            self._period()
        return reached()

    def _period(self) -> None:
        self.time = self._periods * PERIOD
        self._periods += 1
        self.instance.period(self.time, tuple(self._values.values()))
        new, self.instance.records = self.instance.records, []
        self.records += new
        for kind, fields in new:
            if kind == "enter" and not self.graph.by_path[fields["state"]].children:
                self.path.append(fields["state"])

    def _story(self) -> str:
        return f"it is in {', '.join(self.active) or 'no state'} and took {' → '.join(self.path)}"


_BLANK = {Bool: False, Number: 0.0, Text: "", PointType: Point(0.0, 0.0, 0.0)}


def _blank(type_: Type) -> Any:
    """The first value of a host name of that type; None for one of which nothing is known."""
    match type_:
        case ListOf():
            return []
        case MapOf(fields=fields):
            return SimpleNamespace(**{n: _blank(inner) for n, inner in (fields or {}).items()})
        case _:
            return _BLANK.get(type(type_))
