"""Helpers: one behaviour at work, and whole missions, on a vehicle without physics."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from random import Random
from typing import Any

from behaviors import MissionFrame, Pilot, Registry, drone_vocabulary
from behaviors.activity import DroneActivity
from behaviors.channel import Channel
from fsm import BehaviorInfo, Outcome, compile_mission, read_mission_text
from fsm.engine.instance import Record
from hal.fake import FakeSession, FakeVehicle
from hal.vehicle import PERIOD, Observation, Setpoint
from vencejo.geometry import Point


def airborne(height: float = 3.0) -> tuple[FakeSession, FakeVehicle]:
    """A vehicle that hovers above its start, heading east."""
    session = FakeSession()
    vehicle = session.vehicles["drone"]
    order = vehicle.takeoff(height)
    while not order.ended:
        session.wait()
    session.wait()
    assert vehicle.observe().velocity.norm() == 0
    return session, vehicle


def observed(vehicle: FakeVehicle) -> Observation:
    """The observation of a vehicle without a session after its first period."""
    vehicle.advance(PERIOD)
    return vehicle.observe()


class Solo:
    """One behaviour on a vehicle, without a graph; ``run`` lets time pass."""

    def __init__(
        self,
        name: str | BehaviorInfo,
        values: Mapping[str, Any] | None = None,
        *,
        progress: Mapping[str, Any] | None = None,
        grounded: bool = False,
        vehicle: tuple[FakeSession, FakeVehicle] | None = None,
    ) -> None:
        self.session, self.vehicle = vehicle or (
            _on_ground(FakeSession()) if grounded else airborne()
        )
        self.channel = Channel(self.vehicle, MissionFrame(Point(0.0, 0.0, 0.0)), Random(0))
        self.events: list[tuple[str, Mapping[str, Any]]] = []
        self.live: dict[str, Any] = {}
        self.outcome: Outcome | None = None
        info = Registry()[name] if isinstance(name, str) else name
        self.activity = DroneActivity(info, values or {}, progress, self.channel, self._post)

    def _post(self, name: str, fields: Mapping[str, Any]) -> None:
        self.events.append((name, fields))

    def step(self) -> Setpoint | None:
        """One period; the set-point that was commanded (mission frame)."""
        self.channel.observe()
        self.outcome = self.activity.step(self.live)
        commanded = self.channel.setpoint
        self.channel.send()
        self.session.wait()
        return commanded

    def run(self, seconds: float) -> Outcome | None:
        """Step until it ends, for so many seconds at most."""
        for _ in range(round(seconds / PERIOD)):
            self.step()
            if self.outcome is not None:
                break
        return self.outcome

    def until_unstable(self) -> None:
        """Step until the vehicle has come down where it does not stand."""
        while not any(e.name == "vehicle.unstable" for e in self.vehicle.observe().events):
            self.step()

    @property
    def word(self) -> str | None:
        return self.outcome.word if self.outcome else None

    @property
    def time(self) -> float:
        return self.vehicle.observe().time


def _on_ground(session: FakeSession) -> tuple[FakeSession, FakeVehicle]:
    session.wait()
    return session, session.vehicles["drone"]


class Rig:
    """A mission on a vehicle without physics."""

    def __init__(
        self,
        text: str,
        *,
        own: Mapping[str, BehaviorInfo] | None = None,
        parameters: Mapping[str, Any] | None = None,
        places: Mapping[str, Point] | None = None,
        session: FakeSession | None = None,
        strip: tuple[str, ...] = (),
    ) -> None:
        self.session = session or FakeSession()
        self.vehicle = self.session.vehicles["drone"]
        self.vehicle.capabilities -= set(strip)
        graph = compile_mission(
            read_mission_text(text, "test.yaml"), drone_vocabulary(own, places or {})
        )
        self._step: float | None = self.session.wait()
        frame = MissionFrame.at_start(self.vehicle.observe(), places)
        self.pilot = Pilot(graph, self.vehicle, parameters, frame=frame)
        self.records: list[Record] = []

    def period(self) -> None:
        step = self.session.wait() if self._step is None else self._step
        self._step = None
        self.pilot.period(step)
        self.records += self.pilot.instance.records
        self.pilot.instance.records = []

    def run(self, seconds: float) -> None:
        """Fly on until everything is over, for so many seconds at most."""
        for _ in range(round(seconds / PERIOD)):
            if self.pilot.finished:
                return
            self.period()

    def until(self, reached: Callable[[], bool], seconds: float = 60.0) -> None:
        for _ in range(round(seconds / PERIOD)):
            if reached():
                return
            self.period()
        assert reached(), f"not so within {seconds} s; in {self.pilot.instance.paths()}"

    def until_in(self, state: str) -> None:
        self.until(lambda: self.pilot.instance.is_active(state))

    @property
    def states(self) -> list[str]:
        """The states entered, without the root."""
        return [fields["state"] for kind, fields in self.records if kind == "enter"][1:]

    @property
    def last(self) -> Setpoint:
        return self.vehicle.commands[-1]
