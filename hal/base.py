"""What the vehicles of all backends have in common: verbs become orders, the rest is not there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from hal.lights import Lights
from hal.limits import Limits
from hal.orders import Decision, Order, Orders
from hal.vehicle import Answer, Camera, Sensor, Unavailable, VisionPose

Decide = Callable[..., Decision]
"""Carries out a verb, of its arguments, as far as that can be done at once."""


class BaseVehicle:
    """A vehicle to inherit from (see :class:`hal.vehicle.Vehicle`, and docs/backends.md).

    Every verb is an order that waits for :meth:`decide`. A verb without a decision, and cameras,
    sensors and vision poses unless a subclass offers them, raise Unavailable.
    """

    profiles: Mapping[str, Limits] = MappingProxyType({})

    def __init__(self, name: str, decisions: Mapping[str, Decide]) -> None:
        """``decisions``: what carries out each verb that the vehicle has."""
        self._name = name
        self._decisions = decisions
        self.orders = Orders()

    @property
    def name(self) -> str:
        return self._name

    def send(self, verb: str, *arguments: Any) -> Order:
        """Send a verb. Raises Unavailable when the vehicle does not have it."""
        if verb not in self._decisions:
            raise Unavailable(f"the vehicle '{self._name}' cannot {verb.replace('_', ' ')}")
        return self.orders.send(verb, *arguments)

    def decide(self) -> None:
        """Decide on what was sent since the last period; to be called within ``wait()``."""
        for order in self.orders.take():
            decision = self._decisions[order.verb](*order.arguments)
            if decision.state == "accepted":
                self.orders.accept(order)
            else:
                order.state, order.reason = decision

    def arm(self) -> Order:
        return self.send("arm")

    def disarm(self) -> Order:
        return self.send("disarm")

    def takeoff(self, altitude: float) -> Order:
        return self.send("takeoff", altitude)

    def land(self) -> Order:
        return self.send("land")

    def return_home(self) -> Order:
        return self.send("return_home")

    def emergency_stop(self) -> Order:
        return self.send("emergency_stop")

    def reset(self) -> Order:
        return self.send("reset")

    def trim(self) -> Order:
        return self.send("trim")

    def lights(self, lights: Lights) -> Order:
        return self.send("lights", lights)

    def configure(self, limits: Limits) -> Answer:
        """Refuses: a vehicle without the capability ``limits`` has none to change."""
        limits.given()
        return Answer(False, f"the vehicle '{self._name}' has no limits to change")

    def camera(self, name: str) -> Camera:
        raise Unavailable(f"the vehicle '{self._name}' has no camera '{name}'")

    def sensor(self, name: str) -> Sensor:
        raise Unavailable(f"the vehicle '{self._name}' has no sensor '{name}'")

    def send_vision_pose(self, pose: VisionPose) -> None:
        raise Unavailable(f"the vehicle '{self._name}' takes no vision poses")
