"""Behaviours that run at once: each commands only what it controls and raises its own events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import Any, ClassVar

import pytest

from behaviors import Behavior, BehaviorParams, NotInControl, describe, param
from hal import Lights
from hal.vehicle import Hold, Velocity
from tests.behaviors.flying import Rig

TWO = """
mission: two
states:
  takeoff: {do: takeoff, with: {altitude: 3 m}, on: {done: fly}}
  fly:
    do: COMPANION
    on: {HANDLERS}
    states:
      go: {do: move, with: {forward: 2 m/s}, after: {2 s: rest}}
      rest: {after: {1 s: land}}
  land: {do: land, on: {done: finish}}
  finish: {type: final}
"""


@dataclass(frozen=True)
class Rung:
    """The fields of ``bell.rung``: the behaviour that rang."""

    by: str = ""


@dataclass(frozen=True)
class Count:
    """Number of its steps."""

    steps: int = 0


class _Companion(Behavior):
    """Runs beside the behaviour that flies."""

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]
    controls = ()

    def step(self, flight: Any) -> None:
        return None


class Meddler(_Companion):
    """Commands motion, though it controls none."""

    def step(self, flight: Any) -> None:
        flight.command(Velocity(x=-3.0))


class Ringer(_Companion):
    """Publishes in every step, and raises and publishes when it is stopped."""

    class Params(BehaviorParams):
        """Its name."""

        word: str = param("ringer")

    events: Mapping[str, type | None] = {"bell.rung": Rung}  # type: ignore[misc]
    publishes = Count

    def start(self, flight: Any, progress: Any = None) -> None:
        self.steps = 0

    def step(self, flight: Any) -> None:
        self.steps += 1
        flight.publish(Count(self.steps))

    def progress(self) -> dict[str, Any]:
        return {"steps": self.steps}

    def stop(self, flight: Any) -> None:
        flight.publish(Count(-1))
        flight.raise_event("bell.rung", Rung(self.params.word))


class Ghost(_Companion):
    """Speaks after it was stopped, as a thread that it left behind would."""

    events: Mapping[str, type | None] = {"bell.rung": Rung}  # type: ignore[misc]
    publishes = Count
    flights: ClassVar[list[Any]] = []

    def start(self, flight: Any, progress: Any = None) -> None:
        self.flights.append(flight)


class Lamp(_Companion):
    """Shows a light."""

    controls = ("lights",)

    def start(self, flight: Any, progress: Any = None) -> None:
        flight.lights(Lights("solid", "blue"))


class Last(Behavior):
    """Commands when it is stopped, which it may not."""

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]

    def step(self, flight: Any) -> None:
        return None

    def stop(self, flight: Any) -> None:
        flight.command(Velocity(x=9.0))


class Teller(Behavior):
    """Commands when it is asked for its progress, and after it was stopped, which it may not."""

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]
    raised: ClassVar[list[Exception]] = []

    def start(self, flight: Any, progress: Any = None) -> None:
        self.flight = flight
        flight.command(Hold())

    def step(self, flight: Any) -> None:
        return None

    def progress(self) -> dict[str, Any]:
        for command in (self.flight.land, lambda: self.flight.command(Velocity(x=9.0))):
            try:
                command()
            except NotInControl as error:
                self.raised.append(error)
        return {}


class Stray(Behavior):
    """Commands a velocity that is no number."""

    outcomes: Mapping[str, type | None] = {}  # type: ignore[misc]

    def step(self, flight: Any) -> None:
        flight.command(Velocity(x=nan))


OWN = {
    info.name: info for info in map(describe, (Meddler, Ringer, Ghost, Lamp, Last, Teller, Stray))
}


def two(companion: str, handlers: str) -> str:
    """A mission whose state ``fly`` has a companion and these transitions for ``on``."""
    return TWO.replace("COMPANION", companion).replace("HANDLERS", handlers)


def logged(rig: Rig) -> list[str]:
    return [fields["text"] for kind, fields in rig.records if kind == "log"]


def test_a_companion_that_commands_has_failed_and_moves_nothing() -> None:
    rig = Rig(two("meddler", "failed: land"), own=OWN)
    rig.until_in("fly")
    rig.run(30)
    assert rig.pilot.outcome == "done" and "land" in rig.states
    assert all(command != Velocity(x=-3.0) for command in rig.vehicle.commands)
    told = [f for kind, f in rig.records if kind == "event" and f["name"] == "failed"]
    assert "does not control motion" in told[0]["fields"]["reason"]


def test_what_one_raises_and_publishes_in_its_stop_is_its_own() -> None:
    text = two("ringer", 'bell.rung: {actions: {log: "rung by $event.by"}}')
    text = text.replace("fly:\n", "fly:\n    as: outer\n")
    text = text.replace("do: move", "do: ringer, as: inner").replace(
        "with: {forward: 2 m/s}", 'with: {word: inner}, throughout: {log: "${outer.steps}"}'
    )
    rig = Rig(text, own=OWN)
    rig.until_in("fly.rest")
    # The inner one was stopped: the event is its own, and the outer one's values are untouched.
    assert rig.pilot.instance.outcome is None
    counts = [int(text) for text in logged(rig)]
    assert counts == list(range(len(counts)))
    rig.period()
    assert logged(rig)[-1] == "rung by inner"
    rig.run(30)
    assert rig.pilot.outcome == "done"
    assert not [fields for kind, fields in rig.records if kind == "error"]


def test_one_that_was_stopped_raises_and_publishes_nothing() -> None:
    Ghost.flights.clear()
    text = two("ghost", 'bell.rung: {actions: {log: "rung"}}')
    rig = Rig(text, own=OWN)
    rig.until_in("fly")
    rig.period()
    (flight,) = Ghost.flights
    flight.raise_event("bell.rung")
    rig.until_in("land")
    assert logged(rig) == ["rung"]
    with pytest.raises(NotInControl, match="that was stopped raises no events"):
        flight.raise_event("bell.rung")
    with pytest.raises(NotInControl, match="that was stopped publishes nothing"):
        flight.publish(Count(3))
    rig.run(30)
    assert rig.pilot.outcome == "done"
    rung = [f for kind, f in rig.records if kind == "event" and f["name"] == "bell.rung"]
    assert len(rung) == 1


def alone(behavior: str, handlers: str = "") -> str:
    """A mission in which this behaviour has motion for 2 s."""
    text = two("", handlers).replace("do: \n    ", "")
    return text.replace("do: move, with: {forward: 2 m/s}", f"do: {behavior}")


def test_one_that_tells_its_progress_commands_nothing() -> None:
    Teller.raised.clear()
    rig = Rig(alone("teller"), own=OWN)
    rig.until_in("fly.go")
    rig.run(0.5)
    rig.pilot.instance.post("operator.takeover")
    rig.period()
    assert rig.pilot.instance.suspended_at is not None
    assert ["asked for its progress" in str(error) for error in Teller.raised] == [True, True]
    assert rig.vehicle.verbs == ["takeoff"]
    # When it goes on, it commands again.
    rig.pilot.instance.post("operator.release")
    rig.run(30)
    assert rig.pilot.outcome == "done" and set(rig.vehicle.commands) == {Hold()}


def test_a_velocity_that_is_no_number_is_the_failure_of_its_behaviour() -> None:
    rig = Rig(alone("stray", "failed: {target: land, actions: {log: $event.reason}}"), own=OWN)
    rig.run(30)
    assert rig.pilot.outcome == "done"
    assert [text.startswith("ValueError: a set-point needs") for text in logged(rig)] == [True]


def test_lights_are_controlled_beside_motion() -> None:
    rig = Rig(two("lamp", "failed: land"), own=OWN)
    rig.run(40)
    assert rig.pilot.outcome == "done"
    assert rig.vehicle.shown == [Lights("solid", "blue")]
    assert Velocity(x=2.0, frame="heading") in rig.vehicle.commands


def test_a_mission_does_not_take_the_lights_from_a_behaviour_that_controls_them() -> None:
    text = two("lamp", 'error.execution: {actions: {log: "$event.message"}}')
    calls = "{entry: {call: {lights: {pattern: off}}}, after: {1 s: land}}"
    rig = Rig(text.replace("{after: {1 s: land}}", calls), own=OWN)
    rig.run(40)
    assert rig.pilot.outcome == "done"
    assert logged(rig) == ["call: a behaviour controls the lights now"]
    assert rig.vehicle.shown == [Lights("solid", "blue")]


def test_a_command_in_a_stop_is_an_error_and_not_flown() -> None:
    text = two("", 'error.execution: {actions: {log: "$event.message"}}')
    text = text.replace("do: \n    ", "")
    rig = Rig(text.replace("do: move, with: {forward: 2 m/s}", "do: last"), own=OWN)
    rig.run(40)
    assert rig.pilot.outcome == "done"
    assert ["being stopped" in text for text in logged(rig)] == [True]
    assert all(command in (Hold(),) for command in rig.vehicle.commands)
