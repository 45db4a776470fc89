"""The air about the vehicles of a session: the wind, and what the others' rotors push down."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp

from hal.sim.downwash import downwash
from hal.sim.physics import Triple
from hal.sim.vehicle import SimVehicle
from hal.sim.weather import Weather
from hal.vehicle import PERIOD
from vencejo.geometry import Point

_ESTIMATED_WITHIN = 1.0
"""Time constant of a vehicle's estimate of the wind, seconds."""
_SHARE = 1.0 - exp(-PERIOD / _ESTIMATED_WITHIN)
_STILL = (0.0, 0.0, 0.0)


class Air:
    """Gives each vehicle the air of the mission period that begins, and its estimate of it."""

    def __init__(
        self, weather: Weather | None, vehicles: Sequence[SimVehicle], *, downwash: bool
    ) -> None:
        """``downwash``: whether the vehicles' rotors move the air below them."""
        self._felt = [
            (vehicle, weather.of(vehicle.name) if weather else None) for vehicle in vehicles
        ]
        self._downwash = downwash

    def begin_period(self, time: float) -> None:
        """Let the wind of that time (session's clock, seconds) blow."""
        sinking = self._sinking() if self._downwash else [0.0] * len(self._felt)
        for (vehicle, weather), down in zip(self._felt, sinking, strict=True):
            position, _, velocity, _ = vehicle.dynamics.state
            x, y, z = weather.wind(position, velocity, time) if weather else _STILL
            wind = x, y, z - down
            vehicle.dynamics.wind = wind
            if vehicle.estimated_wind is not None:
                vehicle.estimated_wind = _followed(vehicle.estimated_wind, wind)

    def _sinking(self) -> list[float]:
        """How fast the others make the air about each vehicle sink, m/s."""
        all_ = [vehicle.dynamics for vehicle, _ in self._felt]
        blowing = [(d.state[0], d.rotors, d.thrust) for d in all_ if d.thrust > 0.0]
        found = []
        for dynamics in all_:
            x, y, z = dynamics.state[0]
            down = 0.0
            for (ax, ay, az), rotors, thrust in blowing:
                if az > z:
                    down += downwash(rotors, thrust, (x - ax, y - ay, z - az))
            found.append(down)
        return found


def _followed(estimate: Point, wind: Triple) -> Point:
    """The estimate a mission period later: a first-order low-pass."""
    ex, ey, ez = estimate
    x, y, z = wind
    return Point(ex + (x - ex) * _SHARE, ey + (y - ey) * _SHARE, ez + (z - ez) * _SHARE)
