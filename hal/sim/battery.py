"""The battery: its charge as a function of the power drawn."""

from __future__ import annotations

from collections.abc import Mapping

from hal.sim.model import BatteryPack


class Battery:
    """A battery's charge, and the voltage that is left under load."""

    def __init__(
        self, pack: BatteryPack, charge: float, chargers: Mapping[str, float] | None = None
    ) -> None:
        """``chargers``: the power (watts) of each thing that charges what stands on it."""
        self.charge = charge
        """Charge left, 0 to 1."""
        self.chargers = chargers or {}
        self._pack = pack
        self._current = 0.0

    @property
    def empty(self) -> bool:
        return self.charge <= 0.0

    @property
    def voltage(self) -> float:
        """Under the load of the last period, volts."""
        return self._pack.voltage(self.charge) - self._current * self._pack.resistance

    def charge_on(self, thing: str, seconds: float) -> None:
        """Charge for a time (s), until it is full, on a thing; on most nothing happens."""
        power = self.chargers.get(thing, 0.0)
        self.charge = min(1.0, self.charge + power * seconds / self._pack.energy)

    def swap(self) -> None:
        """Take a full battery instead."""
        self.charge = 1.0

    def drain(self, power: float, seconds: float) -> None:
        """Drain the charge that a power (watts) takes over a time (s)."""
        pack, charge = self._pack, self.charge
        self._current = current = pack.current(power, charge)
        self.charge = max(0.0, charge - pack.drain(current, charge) * seconds)
