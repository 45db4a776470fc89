"""The battery: charge as a function of the thrust flown."""

from __future__ import annotations

from collections.abc import Mapping

from hal.sim.airframe import Airframe
from hal.sim.physics import GRAVITY


class Battery:
    """A battery's charge.

    A rotor's power is proportional to its thrust to the power of 3/2 (momentum theory in hover);
    the factor is the one that empties a full battery in the airframe's hovering endurance.
    """

    def __init__(
        self, airframe: Airframe, charge: float, chargers: Mapping[str, float] | None = None
    ) -> None:
        """``chargers``: the power (watts) of each thing that charges what stands on it."""
        self.charge = charge
        """Charge left, 0 to 1."""
        self.chargers = chargers or {}
        self._capacity = airframe.capacity
        self._standby = airframe.standby_power
        hover_power = airframe.capacity / airframe.endurance
        hover_thrust = airframe.mass * GRAVITY
        self._factor = (hover_power - airframe.standby_power) / hover_thrust**1.5

    @property
    def empty(self) -> bool:
        return self.charge <= 0.0

    def charge_on(self, thing: str, seconds: float) -> None:
        """Charge for a time (s), until it is full, on a thing; on most nothing happens."""
        power = self.chargers.get(thing, 0.0)
        self.charge = min(1.0, self.charge + power * seconds / self._capacity)

    def swap(self) -> None:
        """Take a full battery instead."""
        self.charge = 1.0

    def drain(self, thrust: float, seconds: float) -> None:
        """Drain the energy of a mean thrust (newtons, 0 with the motors off) over a time (s)."""
        power = self._standby + self._factor * thrust**1.5
        self.charge = max(0.0, self.charge - power * seconds / self._capacity)
